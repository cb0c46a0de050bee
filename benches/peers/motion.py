"""What is asked of a motion, whoever made it: when it is at the goal, and the tensions that it needs, by the inverse dynamics of `rig.py`."""

from dataclasses import dataclass

import numpy as np

from feasible import extremes, keeps

SAMPLES = {6: 2000, 8: 400}  # of a motion, by the number of cables
NEAR = 0.02  # of the way: at the goal
KEPT = 1e-4  # of the weight: by more than that a limit is broken


@dataclass
class Found:
    """Of one motion. `duration` is None where the motion has no end of its own, `planning` where it is not measured."""

    within: float  # s, from when on the platform is within 2 % of the way of the goal
    duration: float | None  # s
    smallest: float  # N
    greatest: float  # N
    planning: float | None  # s
    keeps: bool  # the limits
    times: np.ndarray
    away: np.ndarray  # from the goal, as a share of the way


def found(rig, goal, times, q, wrench, duration, planning):
    """Of rows of poses and wrenches at times from 0 on; None where the motion does not come to the goal."""
    away = rig.distance(q, goal) / rig.distance(q[0], goal)
    outside = np.flatnonzero(away > NEAR)[-1]
    if outside == len(times) - 1:
        return None
    if rig.cables > 6:
        q, wrench = (rows[:: len(rows) // SAMPLES[rig.cables] + 1] for rows in (q, wrench))
    smallest, greatest = extremes(rig, q, wrench)
    is_kept = keeps(rig, q, wrench, KEPT * rig.weight)
    return Found(times[outside + 1], duration, smallest, greatest, planning, is_kept, times, away)


def planned(rig, goal, motion, duration, planning):
    """Of a motion, times -> (q, v, a), also between the places where its maker looked at it."""
    times = np.linspace(0, duration, SAMPLES[rig.cables])
    q, v, a = motion(times)
    return found(rig, goal, times, q, rig.wrench(q, v, a), duration, planning)


def simulated(rig, goal, h, q, v, planning):
    """Of rows of poses and rates every h seconds, between which the tensions are held: the wrench in the middle from the change of the rates."""
    middle, rates = 0.5 * (q[1:] + q[:-1]), 0.5 * (v[1:] + v[:-1])
    wrench = rig.wrench(middle, rates, np.diff(v, axis=0) / h)
    return found(rig, goal, h * (np.arange(len(middle)) + 0.5), middle, wrench, None, planning)
