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
    """A row of unknowns a step: pose and rates at its end, accelerations and tensions (shares of the weight) in it. A row of equations: pose, rates, wrench, tensions."""

    def __init__(self, rig, start, goal):
        self.rig, self.goal, self.width = rig, goal, 18 + rig.cables
        # What was predicted the step before, pose and rates at the beginning of each step.
        self.q, self.v = np.tile(start, (HORIZON + 1, 1)), np.zeros((HORIZON + 1, 6))
        self.u = np.full((HORIZON, rig.cables), 1.2 * rig.weight / rig.cables)
        self.solver, self.order = None, None

    def tensions(self, q, v):
        """Of the next step, N; None where OSQP finds none."""
        for rows in (self.q, self.v, self.u):
            rows[:-1] = rows[1:]
        self.q[0], self.v[0] = q, v
        pulls = self._pulls()
        entries, rows, columns = self._matrix(pulls)
        lower, upper = self._bounds(pulls)
        if self.solver is None:
            self._set_up(entries, rows, columns, lower, upper)
        else:
            self.solver.update(Ax=entries[self.order], l=lower, u=upper)
        solved = self.solver.solve()
        if solved.info.status_val not in (1, 2):
            return None
        parts = solved.x.reshape(HORIZON, self.width)
        self.q[1:], self.v[1:], self.u = parts[:, :6], parts[:, 6:12], parts[:, 18:] * self.rig.weight
        return self.u[0].clip(self.rig.least, self.rig.greatest)

    def _pulls(self):
        """By how much the wrench of the predicted tensions changes with the pose, a matrix a step."""
        tilted = np.stack([self.q[:-1] + sign * TILT * np.eye(6)[k] for sign in (1, -1) for k in range(6)])
        wrenches = apply(self.rig.matrix(tilted), self.u)
        return np.moveaxis((wrenches[:6] - wrenches[6:]) / (2 * TILT), 0, -1)

    def _matrix(self, pulls):
        """Entries with their rows and columns."""
        found, one, weight = _Entries(self.width), np.eye(6), self.rig.weight
        # At the end: q - h^2/2 q'' = q + h v of the beginning, and v - h q'' = v of the beginning.
        found.add(0, 0, one)
        found.add(0, 12, -0.5 * STEP**2 * one)
        found.add(6, 6, one)
        found.add(6, 12, -STEP * one)
        found.add(0, 0, -one, before=True)
        found.add(0, 6, -STEP * one, before=True)
        found.add(6, 6, -one, before=True)
        # W u - M q'' + (dW/dq u) q, at the beginning.
        found.add(12, 18, self.rig.matrix(self.q[:-1]))
        found.add(12, 12, -self.rig.inertial(self.q[:-1]) / weight)
        found.add(12, 0, pulls / weight, before=True)
        found.add(18, 18, np.eye(self.rig.cables))
        return found.joined()

    def _bounds(self, pulls):
        lower = np.zeros((HORIZON, self.width))
        lower[0, :12] = np.concatenate([self.q[0] + STEP * self.v[0], self.v[0]])
        wrench = self.rig.other(self.q[:-1], self.v[:-1]) + apply(pulls, self.q[:-1])
        wrench[0] -= apply(pulls[0], self.q[0])
        lower[:, 12:18] = wrench / self.rig.weight
        upper = lower.copy()
        lower[:, 18:], upper[:, 18:] = self.rig.least / self.rig.weight, self.rig.greatest / self.rig.weight
        return lower.ravel(), upper.ravel()

    def _set_up(self, entries, rows, columns, lower, upper):
        numbered = sparse.csc_matrix((np.arange(1, len(entries) + 1), (rows, columns)), (len(lower), HORIZON * self.width))
        self.order = numbered.data - 1
        matrix = sparse.csc_matrix((entries[self.order], numbered.indices, numbered.indptr), numbered.shape)
        scale = np.array([1, 1, 1, *[self.rig.radius] * 3]) ** 2
        weights = np.concatenate([scale, RATES * scale, ACCELERATIONS * scale, np.full(self.rig.cables, SHARES)])
        towards = np.zeros(self.width)
        towards[:6] = -scale * self.goal
        cost = sparse.diags(np.tile(weights, HORIZON), format="csc"), np.tile(towards, HORIZON)
        self.solver = osqp.OSQP()
        self.solver.setup(*cost, matrix, lower, upper, verbose=False, eps_abs=1e-5, eps_rel=1e-5, adaptive_rho_interval=50)


class _Entries:
    """Of a matrix of blocks, the same place in each step."""

    def __init__(self, width):
        self.width, self.parts = width, []

    def add(self, row, column, blocks, before=False):
        """A block a step; `before`: on the unknowns of the step before, which the first has none of."""
        steps = np.arange(before, HORIZON)[:, None, None] * self.width
        blocks = np.broadcast_to(blocks, (HORIZON, *blocks.shape[-2:]))[int(before) :]
        down, across = np.arange(blocks.shape[1])[:, None], np.arange(blocks.shape[2])
        places = steps + row + down, steps - before * self.width + column + across
        self.parts.append([np.broadcast_to(part, blocks.shape).ravel() for part in (blocks, *places)])

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
