"""Optima by CasADi and ipopt: of the time along the straight way, and free of it."""

import time
from functools import cache

import casadi as ca
import numpy as np

import motion
import optimum
from symbolic import residual

CELLS = {6: 100, 8: 50}  # of the way, by the number of cables
INTERVALS = 60  # of the free motion, of constant acceleration each
QUIET = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 500}


def on_the_way(rig, start, goal):
    solved = pieces_on_the_way(rig, start, goal)
    if solved is None:
        return None
    planning, pieces = solved
    way = goal - start
    rows = lambda t: [start + np.outer(pieces(t)[0], way), *(np.outer(part, way) for part in pieces(t)[1:])]
    return motion.planned(rig, goal, rows, pieces.ends[-1], planning)


def pieces_on_the_way(rig, start, goal):
    """Solver's CPU time and s over time: s'' constant in each cell, the limits held at both its ends. None where ipopt finds nothing."""
    cells = CELLS[rig.cables]
    h = 1 / cells
    a, b, c = optimum.conditions(rig, start, goal, np.linspace(0, 1, cells + 1))
    speed = ca.MX.sym("speed", cells + 1)
    x = speed**2
    change = (x[1:] - x[:-1]) / (2 * h)
    held = [ca.diag(change) @ ca.DM(a[k : k + cells]) + ca.diag(x[k : k + cells]) @ ca.DM(b[k : k + cells]) for k in (0, 1)]
    problem = {"x": speed, "f": ca.sum1(2 * h / (speed[1:] + speed[:-1])), "g": ca.vertcat(*(ca.vec(rows) for rows in held))}
    solver = ca.nlpsol("solver", "ipopt", problem, QUIET)
    bounds = np.concatenate([-c[k : k + cells].ravel(order="F") for k in (0, 1)])
    lower, upper = np.zeros(cells + 1), np.full(cells + 1, np.inf)
    upper[[0, -1]] = 0
    places = np.linspace(0, 1, cells + 1)
    begun = time.thread_time()
    solved = solver(x0=np.sqrt(places * (1 - places)) + 1e-3, lbx=lower, ubx=upper, ubg=bounds)
    planning = time.thread_time() - begun
    if not solver.stats()["success"]:
        return None
    speeds = np.array(solved["x"]).ravel()
    return planning, Pieces(2 * h / (speeds[1:] + speeds[:-1]), places, speeds)


class Pieces:
    """Position, rate and acceleration over time from pieces of constant acceleration."""

    def __init__(self, durations, places, speeds):
        self.ends, self.places, self.speeds = np.concatenate([[0], np.cumsum(durations)]), places, speeds
        self.accelerations = ((speeds[1:] - speeds[:-1]).T / np.diff(self.ends)).T

    def __call__(self, times):
        k = np.clip(np.searchsorted(self.ends, times, side="right") - 1, 0, len(self.ends) - 2)
        a = self.accelerations[k]
        t = (times - self.ends[k]).reshape(-1, *[1] * (a.ndim - 1))
        return self.places[k] + self.speeds[k] * t + 0.5 * a * t * t, self.speeds[k] + a * t, a


@cache
def _solver(rig, free, intervals):
    """The least time from a state to rest at a goal with the coordinates `free`; the others are those of the start."""
    d, n, lacking = len(free), rig.cables, residual(rig)
    total, q, v = ca.MX.sym("total"), ca.MX.sym("q", d, intervals + 1), ca.MX.sym("v", d, intervals + 1)
    a, u = ca.MX.sym("a", d, intervals), ca.MX.sym("u", n, 2 * intervals)
    fixed = ca.MX.sym("fixed", 6)
    spread = np.eye(6)[:, list(free)]
    h = total / intervals
    rest = ca.repmat((1 - spread.sum(axis=1)) * fixed, 1, intervals)
    ends = [(spread @ q[:, k : k + intervals] + rest, spread @ v[:, k : k + intervals]) for k in (0, 1)]
    wrenches = [
        lacking.map(intervals)(*end, spread @ a, rig.weight * u[:, k * intervals : (k + 1) * intervals]) for k, end in enumerate(ends)
    ]
    moved = q[:, 1:] - q[:, :-1] - h * v[:, :-1] - 0.5 * h**2 * a
    sped = v[:, 1:] - v[:, :-1] - h * a
    unknowns = ca.vertcat(total, ca.vec(q), ca.vec(v), ca.vec(a), ca.vec(u))
    equations = ca.vertcat(ca.vec(moved), ca.vec(sped), *(ca.vec(wrench) for wrench in wrenches))
    return ca.nlpsol("solver", "ipopt", {"x": unknowns, "p": fixed, "f": total, "g": equations}, QUIET)


def least_time(rig, start, rates, goal, free, guess, intervals=INTERVALS):
    """(solver's CPU time, duration, motion, its pieces in the free coordinates) from a state to rest at the goal; `guess` s. None where ipopt finds nothing."""
    d, free = len(free), list(free)
    solver = _solver(rig, tuple(free), intervals)
    sizes = [1, d * (intervals + 1), d * (intervals + 1), d * intervals, rig.cables * 2 * intervals]
    lower, upper = (np.concatenate([np.full(size, sign * np.inf) for size in sizes]) for sign in (-1, 1))
    cuts = np.cumsum([0, *sizes])
    lower[0] = 0.1 * guess
    for offset, first, last in ((cuts[1], start, goal), (cuts[2], rates, 0 * goal)):
        for bound in (lower, upper):
            bound[offset : offset + d], bound[offset + d * intervals : offset + d * (intervals + 1)] = first[free], last[free]
    lower[cuts[4] :], upper[cuts[4] :] = rig.least / rig.weight, rig.greatest / rig.weight
    tau = np.linspace(0, 1, intervals + 1)[:, None]
    way = (goal - start)[free]
    first = [[guess], start[free] + (3 * tau**2 - 2 * tau**3) * way, 6 * (tau - tau**2) * way / guess]
    first += [(6 - 12 * tau[:-1]) * way / guess**2, np.full(sizes[4], 1.2 / rig.cables)]
    begun = time.thread_time()
    solved = solver(x0=np.concatenate([np.ravel(part) for part in first]), p=start, lbx=lower, ubx=upper, lbg=0, ubg=0)
    planning = time.thread_time() - begun
    if not solver.stats()["success"]:
        return None
    parts = np.split(np.array(solved["x"]).ravel(), cuts[1:-1])
    durations = np.full(intervals, parts[0][0] / intervals)
    pieces = Pieces(durations, parts[1].reshape(-1, d), parts[2].reshape(-1, d))

    def rows(times):
        found = np.zeros((3, len(times), 6))
        found[0] = start
        found[:, :, free] = pieces(times)
        return found

    return planning, parts[0][0], rows, pieces


def from_rest(rig, start, goal, coordinates):
    """What `least_time` gives from rest to rest with those coordinates free."""
    guess = 1.5 * optimum.least_time(rig, start, goal, 50)
    return least_time(rig, start, 0 * start, goal, coordinates, guess)


def free_of_it(coordinates):
    def plan(rig, start, goal):
        solved = from_rest(rig, start, goal, coordinates)
        if solved is None:
            return None
        planning, duration, rows, _ = solved
        return motion.planned(rig, goal, rows, duration, planning)

    return plan


planar, spatial, whole = free_of_it((0, 1)), free_of_it((0, 1, 2)), free_of_it(range(6))
