"""The robot once more, in numpy and independent of the Rust code: geometry, wrench matrix, law and plant."""

import numpy as np

A, B, M, G = 0.45, 0.25, 6.0, 9.81
INERTIA = np.diag([0.018, 0.018, 0.075])


def _vertices(half_side, azimuths):
    angles = np.radians(azimuths)
    return 2 * half_side / np.sqrt(3) * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(6)])


ANCHORS = _vertices(A, [300, 300, 60, 60, 180, 180])
ATTACHMENTS = _vertices(B, [240, 0, 0, 120, 120, 240])


def rotation(roll, pitch, yaw):
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return rz @ ry @ rx


def euler_angles(r):
    return np.array([np.arctan2(r[2, 1], r[2, 2]), -np.arcsin(r[2, 0]), np.arctan2(r[1, 0], r[0, 0])])


def wrench_matrix(position, r):
    arms = ATTACHMENTS @ r.T
    along = ANCHORS - position - arms
    directions = along / np.linalg.norm(along, axis=1, keepdims=True)
    return np.vstack([directions.T, np.cross(arms, directions).T])


def static_tensions(position):
    return np.linalg.solve(wrench_matrix(np.asarray(position), np.eye(3)), [0, 0, -M * G, 0, 0, 0])


def law(position, velocity, set_point, gain=3.0):
    """Tensions of Eq. (4) for a translation with zero orientation, and no planner before it."""
    s = velocity + gain * (position - set_point)
    force = M * (-gain * velocity - gain * s) - np.array([0, 0, M * G])
    return np.linalg.solve(wrench_matrix(position, np.eye(3)), np.concatenate([force, np.zeros(3)]))


class Plant:
    """Newton and Euler with a rotation matrix, by classical Runge-Kutta; cables pull and cannot push."""

    def __init__(self, position=(0.0, 0.0, 1.0)):
        self.position, self.velocity = np.array(position, float), np.zeros(3)
        self.r, self.omega = np.eye(3), np.zeros(3)  # omega in the base frame

    def pose(self):
        return np.concatenate([self.position, euler_angles(self.r)])

    @staticmethod
    def _rates(state, pull):
        position, velocity, r, omega = state
        wrench = wrench_matrix(position, r) @ pull
        inertia = r @ INERTIA @ r.T
        alpha = np.linalg.solve(inertia, wrench[3:] - np.cross(omega, inertia @ omega))
        return velocity, wrench[:3] / M + np.array([0, 0, G]), np.cross(omega, r.T).T, alpha

    def step(self, tensions, h):
        pull = np.maximum(tensions, 0.0)
        state = (self.position, self.velocity, self.r, self.omega)
        shifted = lambda k, share: tuple(x + share * h * dx for x, dx in zip(state, k))
        k1 = self._rates(state, pull)
        k2 = self._rates(shifted(k1, 0.5), pull)
        k3 = self._rates(shifted(k2, 0.5), pull)
        k4 = self._rates(shifted(k3, 1.0), pull)
        state = tuple(x + h / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4))
        self.position, self.velocity, self.r, self.omega = state
        u, _, v = np.linalg.svd(self.r)
        self.r = u @ v
