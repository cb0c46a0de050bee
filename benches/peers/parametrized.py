"""toppra and ruckig on the straight way: one knows the tensions, the other limits of the axes only."""

import time

import numpy as np
import ruckig
import toppra
import toppra.algorithm
import toppra.constraint

import motion
from feasible import halfspaces

POINTS = 201  # of toppra's grid
HALVINGS = 14  # of the acceleration that ruckig gets

toppra.setup_logging("ERROR")


def tension_limits(rig, scheme):
    """For six cables in the tensions themselves, for more in the wrench."""
    if rig.cables == 6:
        sides, bounds = np.vstack([np.eye(6), -np.eye(6)]), np.repeat([rig.greatest, -rig.least], 6)
        of_pose = (rig.tensions, lambda _: sides, lambda _: bounds)
    else:
        of_pose = (rig.wrench, lambda q: halfspaces(rig, q)[0], lambda q: halfspaces(rig, q)[1])
    return toppra.constraint.SecondOrderConstraint(*of_pose, 6, discretization_scheme=scheme)


def by_toppra(scheme):
    def plan(rig, start, goal):
        begun = time.thread_time()
        path = toppra.SplineInterpolator([0, 1], np.array([start, goal]))
        grid = np.linspace(0, 1, POINTS)
        instance = toppra.algorithm.TOPPRA([tension_limits(rig, scheme)], path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
        trajectory = instance.compute_trajectory(0, 0)
        planning = time.thread_time() - begun
        if trajectory is None:
            return None
        return motion.planned(rig, goal, lambda t: [trajectory(t, order) for order in range(3)], trajectory.duration, planning)

    return plan


interpolation = by_toppra(toppra.constraint.DiscretizationType.Interpolation)
collocation = by_toppra(toppra.constraint.DiscretizationType.Collocation)


def by_ruckig(rig, start, goal):
    """The same acceleration for all axes, the greatest with which the tensions are kept, by halving; `planning` is of one call."""
    moving = np.flatnonzero(start != goal)
    planner, best = ruckig.Ruckig(len(moving)), None
    below, above = 0.0, 40.0
    for _ in range(HALVINGS):
        most = 0.5 * (below + above)
        found = _with_acceleration(planner, rig, start, goal, moving, most)
        if found.keeps:
            below, best = most, found
        else:
            above = most
    return best


def _with_acceleration(planner, rig, start, goal, moving, most):
    asked, trajectory = ruckig.InputParameter(len(moving)), ruckig.Trajectory(len(moving))
    asked.current_position, asked.target_position = start[moving], goal[moving]
    asked.max_velocity, asked.max_acceleration = [1e3] * len(moving), [most] * len(moving)
    asked.synchronization = ruckig.Synchronization.Phase
    begun = time.thread_time()
    planner.calculate(asked, trajectory)
    planning = time.thread_time() - begun

    def states(times):
        rows = np.zeros((3, len(times), 6))
        rows[0] = start
        rows[:, :, moving] = np.array([trajectory.at_time(t)[:3] for t in times]).swapaxes(0, 1)
        return rows

    return motion.planned(rig, goal, states, trajectory.duration, planning)
