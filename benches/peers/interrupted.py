"""Level moves that get a new goal on the way: MinimumTime beside the free planar optimum from the same state, by CasADi and ipopt."""

import sys

import numpy as np

import ipopt
import moves
from ours import REFERENCE, SETTLED, timed
from robot_fmu import pose_names

MOVES = 40
INTERVALS = 120  # of the optimum
STEP = 5e-4  # s, also the planner's period: the new goal is taken up at once
LONGEST = 3.0  # s


def compared(own):
    """Of each move: our time over the optimum's, our planning (s of CPU), the optimum's. Interrupted (Ctrl-C), of those until then."""
    rng, rows = np.random.default_rng(moves.SEED), []
    try:
        for k in range(MOVES):
            print(f"\rinterrupted moves: {k + 1} of {MOVES}  ", end="", file=sys.stderr, flush=True)
            rows += _compared(own, *(moves.pose(rng, 0, 0) for _ in range(3)), rng.uniform(0.1, 0.9))
    except KeyboardInterrupt:
        pass
    print(file=sys.stderr)
    return np.array(rows)


def _compared(own, start, goal, then, share):
    """One row, none where ipopt finds no optimum."""
    q, v, duration, planning = _ours(own, start, goal, then, share)
    optimum = ipopt.least_time(own.rig, q, v[:2], then, (0, 1), 1.5 * duration, INTERVALS)
    return [(duration / optimum[1], planning, optimum[0])] if optimum else []


def _ours(own, start, goal, then, share):
    """State in which the new goal is taken up, s from there to rest at it, s of CPU of that step less the one before."""
    given = round((SETTLED + share * own.duration(start, goal)) / STEP)
    with own.controller("MinimumTime", start, plannerPeriod=STEP) as controller:
        controller.set(pose_names("goalPose"), goal)
        controller.exit_initialization()
        rows = []
        for k in range(given + round(LONGEST / STEP)):
            if k == given - 1:
                before = timed(controller, STEP, k * STEP)
            elif k == given:
                controller.set(pose_names("goalPose"), then)
                planning = timed(controller, STEP, k * STEP) - before
            else:
                controller.step(STEP, k * STEP)
            rows.append(controller.get(REFERENCE).reshape(3, 6))
            controller.set(pose_names("encoderPose"), rows[-1][0])
            if k > given and not rows[-1][1].any() and np.allclose(rows[-1][0], then, atol=1e-6):
                break
        else:
            raise RuntimeError(f"{then} is not reached from {start} by way of {goal}")
    q, v, _ = rows[given]
    return q, v, (len(rows) - 1 - given) * STEP, planning
