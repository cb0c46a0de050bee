"""A rig in numpy, independent of the Rust code: geometry and inverse dynamics, of one pose or of many at once (leading axes)."""

import tomllib

import numpy as np


class Rig:
    """m, kg, N; z down. q = (x, y, z, roll, pitch, yaw) of the centre of mass, R = Rz(yaw) Ry(pitch) Rx(roll); v = q', a = q''."""

    def __init__(self, path, least, greatest):
        file = tomllib.loads(path.read_text())
        platform, cables = file["platform"], file["cables"]
        self.path, self.home = path, np.array([*file["home"], 0, 0, 0])
        self.mass, self.inertia = platform["mass"], np.diag(platform["inertia"])
        self.gravity, self.weight = file["gravity"], self.mass * file["gravity"]
        self.anchors = np.array([cable["anchor"] for cable in cables])
        self.arms = np.array([cable["attachment"] for cable in cables]) - platform.get("center_of_mass", [0, 0, 0])
        self.cables, self.least, self.greatest = len(cables), least, greatest
        self.radius = np.linalg.norm(self.arms, axis=1).max()

    def matrix(self, q):
        """W of Eq. (1), (..., 6, n)."""
        arms = self.arms @ swapped(rotation(q))
        along = self.anchors - q[..., None, :3] - arms
        directions = along / np.linalg.norm(along, axis=-1, keepdims=True)
        return swapped(np.concatenate([directions, cross(arms, directions)], axis=-1))

    def inertial(self, q):
        """(..., 6, 6): times q'' it is the part of the wrench that accelerations ask for."""
        found = np.zeros((*q.shape[:-1], 6, 6))
        found[..., :3, :3] = self.mass * np.eye(3)
        found[..., 3:, 3:] = self._turned_inertia(q) @ rates_to_omega(q)
        return found

    def other(self, q, v):
        """The part that rates and gravity ask for."""
        omega, inertia = apply(rates_to_omega(q), v[..., 3:]), self._turned_inertia(q)
        found = np.zeros(q.shape)
        found[..., 2] = -self.weight
        found[..., 3:] = apply(inertia, apply(omega_change(q, v), v[..., 3:])) + cross(omega, apply(inertia, omega))
        return found

    def wrench(self, q, v, a):
        """What the cables are to exert in a motion."""
        return apply(self.inertial(q), a) + self.other(q, v)

    def tensions(self, q, v, a):
        """Of six cables."""
        return np.linalg.solve(self.matrix(q), self.wrench(q, v, a)[..., None])[..., 0]

    def acceleration(self, q, v, tensions):
        """q'' under tensions."""
        return np.linalg.solve(self.inertial(q), (apply(self.matrix(q), tensions) - self.other(q, v))[..., None])[..., 0]

    def step(self, q, v, tensions, h):
        """q and v after h seconds of tensions that are held, by classical Runge-Kutta."""
        rates = lambda y: np.concatenate([y[6:], self.acceleration(y[:6], y[6:], tensions)])
        y = np.concatenate([q, v])
        k1 = rates(y)
        k2 = rates(y + 0.5 * h * k1)
        k3 = rates(y + 0.5 * h * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(y + h * k3))
        return y[:6], y[6:]

    def distance(self, q, goal):
        """m, an angle of 1 rad counted as the platform's radius."""
        return np.linalg.norm((q - goal) * [1, 1, 1, *[self.radius] * 3], axis=-1)

    def _turned_inertia(self, q):
        r = rotation(q)
        return r @ self.inertia @ swapped(r)


def apply(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]


def cross(a, b):
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]


def swapped(matrices):
    return np.swapaxes(matrices, -1, -2)


def _matrices(q, entries):
    """(..., 3, 3) from nine arrays or numbers, row by row."""
    found = np.empty((*q.shape[:-1], 9))
    for k, entry in enumerate(entries):
        found[..., k] = entry
    return found.reshape(*q.shape[:-1], 3, 3)


def _parts(q):
    """cos and sin of roll, pitch, yaw."""
    angles = np.moveaxis(q[..., 3:], -1, 0)
    return *np.cos(angles), *np.sin(angles)


def rotation(q):
    cr, cp, cy, sr, sp, sy = _parts(q)
    first = [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr]
    return _matrices(q, [*first, sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, -sp, cp * sr, cp * cr])


def rates_to_omega(q):
    """E: omega = E (roll', pitch', yaw')."""
    _, cp, cy, _, sp, sy = _parts(q)
    return _matrices(q, [cy * cp, -sy, 0, sy * cp, cy, 0, -sp, 0, 1])


def omega_change(q, v):
    """dE/dt."""
    _, cp, cy, _, sp, sy = _parts(q)
    dp, dy = v[..., 4], v[..., 5]
    first = [-sy * cp * dy - cy * sp * dp, -cy * dy, 0]
    return _matrices(q, [*first, cy * cp * dy - sy * sp * dp, -sy * dy, 0, -cp * dp, 0, 0])
