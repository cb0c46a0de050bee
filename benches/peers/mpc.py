"""Linearised model predictive control towards the goal with the limits of the tensions, by OSQP, in closed loop on the plant of `rig.py`.

Unknown are poses, rates, accelerations and tensions of all steps of the horizon. The equation of motion is linearised about what was predicted the step before.
"""

import time

import numpy as np
import osqp
from scipy import sparse

import motion
from rig import apply

STEP, HORIZON = 0.01, 40  # s, steps
PARTS, LONGEST = 5, 1.5  # of a step, in which the plant is integrated; s
RATES, ACCELERATIONS, SHARES = 3e-3, 1e-7, 1e-6  # weights of rates, accelerations and shares of the weight beside those of the pose (m)
REST = 5e-3  # of the way: the end of a run
TILT = 1e-6  # rad, for derivatives


class Controller:
    def __init__(self, rig, start, goal):
        self.rig, self.goal, n = rig, goal, rig.cables
        self.q, self.v = np.tile(start, (HORIZON + 1, 1)), np.zeros((HORIZON + 1, 6))
        self.a, self.u = np.zeros((HORIZON, 6)), np.full((HORIZON, n), 1.2 * rig.weight / n)
        self.width = 18 + n
        self.solver, self.order = None, None

    def tensions(self, q, v):
        """Of the next step, N; None where OSQP finds none."""
        self._shift(q, v)
        entries, rows, columns, lower, upper = self._constraints(q, v)
        if self.solver is None:
            self._set_up(entries, rows, columns, lower, upper)
        else:
            self.solver.update(Ax=entries[self.order], l=lower, u=upper)
        solved = self.solver.solve()
        if solved.info.status_val not in (1, 2):
            return None
        parts = solved.x.reshape(HORIZON, self.width)
        self.q[1:], self.v[1:], self.a, self.u = parts[:, :6], parts[:, 6:12], parts[:, 12:18], parts[:, 18:] * self.rig.weight
        return self.u[0].clip(self.rig.least, self.rig.greatest)

    def _shift(self, q, v):
        for rows in (self.q, self.v, self.a, self.u):
            rows[:-1] = rows[1:]
        self.q[0], self.v[0] = q, v

    def _set_up(self, entries, rows, columns, lower, upper):
        shape = (len(lower), HORIZON * self.width)
        numbered = sparse.csc_matrix((np.arange(1, len(entries) + 1), (rows, columns)), shape)
        self.order = numbered.data - 1
        numbered = sparse.csc_matrix((entries[self.order], numbered.indices, numbered.indptr), shape)
        scale = np.array([1, 1, 1, *[self.rig.radius] * 3]) ** 2
        weights = np.concatenate([scale, RATES * scale, ACCELERATIONS * scale, np.full(self.rig.cables, SHARES)])
        weights = np.tile(weights, (HORIZON, 1))
        towards = np.zeros_like(weights)
        towards[:, :6] = -weights[:, :6] * self.goal
        self.solver = osqp.OSQP()
        self.solver.setup(
            sparse.diags(weights.ravel(), format="csc"), towards.ravel(), numbered, lower, upper,
            verbose=False, eps_abs=1e-5, eps_rel=1e-5, max_iter=4000, adaptive_rho_interval=50,
        )  # fmt: skip

    def _constraints(self, q, v):
        """Entries of the matrix with rows and columns, and the bounds."""
        width, n, found = self.width, self.rig.cables, _Entries()
        steps = np.arange(HORIZON)
        state, row = steps * width, steps * (12 + 6 + n)
        every = np.arange(6)
        at = lambda base, offset: (base[:, None] + offset + every).ravel()
        # q and v of the end of each step from those of the one before; of the first these are known.
        for offset, factors in ((0, ((0, 1.0), (12, -0.5 * STEP**2))), (6, ((6, 1.0), (12, -STEP)))):
            for column, factor in factors:
                found.add(at(row, offset), at(state, column), factor)
        found.add(at(row[1:], 0), at(state[:-1], 0), -1.0)
        found.add(at(row[1:], 0), at(state[:-1], 6), -STEP)
        found.add(at(row[1:], 6), at(state[:-1], 6), -1.0)
        # Equation of motion at the start of each step, over the weight: pull - M q'' = other, where the pull also changes with the pose.
        pulls, other, inertial = self._linearised()
        block = lambda offset, wide: np.broadcast_to((row[:, None, None] + 12 + every[:, None]), (HORIZON, 6, wide)).ravel()
        across = lambda base, offset, wide: np.broadcast_to(base[:, None, None] + offset + np.arange(wide), (len(base), 6, wide)).ravel()
        found.add(block(12, n), across(state, 18, n), self.rig.matrix(self.q[:-1]).ravel())
        found.add(block(12, 6), across(state, 12, 6), -inertial.ravel() / self.rig.weight)
        found.add(block(12, 6).reshape(HORIZON, -1)[1:].ravel(), across(state[:-1], 0, 6), pulls[1:].ravel() / self.rig.weight)
        right = other + apply(pulls, self.q[:-1])
        right[0] -= apply(pulls[0], q)
        # Limits.
        found.add((row[:, None] + 18 + np.arange(n)).ravel(), (state[:, None] + 18 + np.arange(n)).ravel(), 1.0)
        lower = np.zeros((HORIZON, 18 + n))
        lower[0, :12] = np.concatenate([q + STEP * v, v])
        lower[:, 12:18] = right / self.rig.weight
        upper = lower.copy()
        lower[:, 18:], upper[:, 18:] = self.rig.least / self.rig.weight, self.rig.greatest / self.rig.weight
        return *found.joined(), lower.ravel(), upper.ravel()

    def _linearised(self):
        """By how much the wrench of the predicted tensions changes with the pose, the wrench of rates and gravity, and what q'' is multiplied with."""
        q, v = self.q[:-1], self.v[:-1]
        tilted = np.stack([q + sign * TILT * np.eye(6)[k] for sign in (1, -1) for k in range(6)])
        wrenches = apply(self.rig.matrix(tilted), self.u)
        pulls = np.moveaxis((wrenches[:6] - wrenches[6:]) / (2 * TILT), 0, -1)
        return pulls, self.rig.other(q, v), self.rig.inertial(q)


class _Entries:
    def __init__(self):
        self.parts = []

    def add(self, rows, columns, values):
        self.parts.append((np.broadcast_to(values, rows.shape), rows, columns))

    def joined(self):
        return [np.concatenate(part) for part in zip(*self.parts)]


def closed_loop(rig, start, goal):
    """From rest, each command held for a step, until the platform rests."""
    controller, way = Controller(rig, start, goal), rig.distance(start, goal)
    rows, took = [(start, np.zeros(6))], []
    for _ in range(round(LONGEST / STEP)):
        q, v = rows[-1]
        begun = time.thread_time()
        tensions = controller.tensions(q, v)
        took.append(time.thread_time() - begun)
        if tensions is None:
            return None
        for _ in range(PARTS):
            rows.append(rig.step(*rows[-1], tensions, STEP / PARTS))
        if rig.distance(rows[-1][0], goal) < REST * way and rig.distance(rows[-1][1], 0) < REST * way / 0.1:
            break
    q, v = np.array(rows).swapaxes(0, 1)
    return motion.simulated(rig, goal, STEP / PARTS, q, v, np.median(took))
