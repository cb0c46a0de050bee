"""toppra and ruckig on the straight way: one knows the tensions, the other limits of the axes only."""

import time

import numpy as np
import ruckig
import toppra
import toppra.algorithm
import toppra.constraint

import motion
from feasible import halfspaces
from rig import apply

POINTS = 201  # of toppra's grid
HALVINGS = 14  # of the acceleration that ruckig gets

toppra.setup_logging("ERROR")


class TensionLimits(toppra.constraint.LinearConstraint):
    """As toppra's `SecondOrderConstraint`, whose function of one point in Python takes most of the time, but of all points at once."""

    def __init__(self, rig, scheme):
        super().__init__()
        self.rig, self.dof = rig, 6
        self.set_discretization_type(scheme)

    def compute_constraint_params(self, path, gridpoints):
        q, slope, bend = (path(gridpoints, order) for order in range(3))
        rest = self.rig.other(q, 0 * slope)
        inertial = self.rig.inertial(q)
        wrenches = apply(inertial, slope), apply(inertial, bend) + self.rig.other(q, slope) - rest, rest
        canonical = *self._limited(q, wrenches), None, None
        if self.discretization_type == toppra.constraint.DiscretizationType.Collocation:
            return canonical
        return toppra.constraint.canlinear_colloc_to_interpolate(*canonical, gridpoints)

    def _limited(self, q, wrenches):
        """Of six cables the tensions themselves, of more the wrenches."""
        if self.rig.cables > 6:
            return *wrenches, *halfspaces(self.rig, q)
        inverse = np.linalg.inv(self.rig.matrix(q))
        sides = np.tile(np.vstack([np.eye(6), -np.eye(6)]), (len(q), 1, 1))
        bounds = np.tile(np.repeat([self.rig.greatest, -self.rig.least], 6), (len(q), 1))
        return *(apply(inverse, wrench) for wrench in wrenches), sides, bounds


def a_point_at_a_time(rig, scheme):
    """toppra's own class, as its documentation has it."""
    if rig.cables == 6:
        sides, bounds = np.vstack([np.eye(6), -np.eye(6)]), np.repeat([rig.greatest, -rig.least], 6)
        limits = rig.tensions, lambda _: sides, lambda _: bounds
    else:
        limits = rig.wrench, lambda q: halfspaces(rig, q)[0], lambda q: halfspaces(rig, q)[1]
    return toppra.constraint.SecondOrderConstraint(*limits, 6, discretization_scheme=scheme)


def toppras(rig, start, goal, scheme, limits=TensionLimits):
    """toppra's trajectory or None."""
    path = toppra.SplineInterpolator([0, 1], np.array([start, goal]))
    grid = np.linspace(0, 1, POINTS)
    instance = toppra.algorithm.TOPPRA([limits(rig, scheme)], path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    return instance.compute_trajectory(0, 0)


def by_toppra(scheme, limits=TensionLimits):
    def plan(rig, start, goal):
        begun = time.thread_time()
        trajectory = toppras(rig, start, goal, scheme, limits)
        planning = time.thread_time() - begun
        if trajectory is None:
            return None
        return motion.planned(rig, goal, lambda t: [trajectory(t, order) for order in range(3)], trajectory.duration, planning)

    return plan


INTERPOLATION, COLLOCATION = toppra.constraint.DiscretizationType.Interpolation, toppra.constraint.DiscretizationType.Collocation
interpolation = by_toppra(INTERPOLATION)
second_order = by_toppra(INTERPOLATION, a_point_at_a_time)
collocation = by_toppra(COLLOCATION)


def by_ruckig(rig, start, goal):
    """`planning` is of one call."""
    return fastest_by_ruckig(rig, start, goal, lambda found: found.keeps)[0]


def fastest_by_ruckig(rig, start, goal, is_kept):
    """The same acceleration for all axes, the greatest with which a motion is kept, by halving: what was found of it, ruckig's trajectory; None, None where there is none."""
    moving = np.flatnonzero(start != goal)
    planner, best = ruckig.Ruckig(len(moving)), (None, None)
    below, above = 0.0, 40.0
    for _ in range(HALVINGS):
        most = 0.5 * (below + above)
        found, trajectory = _with_acceleration(planner, rig, start, goal, moving, most)
        if is_kept(found):
            below, best = most, (found, trajectory)
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

    return motion.planned(rig, goal, states, trajectory.duration, planning), trajectory
