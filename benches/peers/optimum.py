"""The least time along a straight way in the six coordinates, on a fine grid: what every motion on that way is measured by."""

import numpy as np

from feasible import halfspaces
from rig import apply


def conditions(rig, start, goal, s):
    """a s'' + b s'^2 + c <= 0 at each place s of the way, arrays (places, conditions)."""
    along = np.broadcast_to(goal - start, (len(s), 6))
    q = start + s[:, None] * (goal - start)
    rest = rig.other(q, 0 * along)
    planes, bounds = halfspaces(rig, q)
    a, b, c = (apply(planes, w) for w in (apply(rig.inertial(q), along), rig.other(q, along) - rest, rest))
    return a, b, c - bounds


def least_time(rig, start, goal, cells=2000):
    """s, or None. s'' is constant in each cell and the limits hold in its middle, so that the error is of second order."""
    h = 1 / cells
    rows = list(zip(*conditions(rig, start, goal, (np.arange(cells) + 0.5) * h)))
    # x = s'^2 where the cells meet: as large as it may be for the end to be reachable, then as large as can be from the start.
    most = [0.0]
    for a, b, c in reversed(rows):
        entered = _enterable(a - b * h, b, c, most[-1])
        if entered is None:
            return None
        most[-1] = entered
        most.append(entered - 2 * h * _range(a - b * h, b * entered + c)[0])
    most.reverse()
    x = [0.0]
    for (a, b, c), ahead in zip(rows, most[1:]):
        greatest = _range(a + b * h, b * x[-1] + c)[1]
        x.append(min(x[-1] + 2 * h * greatest, ahead))
    speeds = np.sqrt(x)
    return (2 * h / (speeds[1:] + speeds[:-1])).sum()


def _range(a, rest):
    """The s'' with a s'' + rest <= 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = -rest / a
    return ends[a < 0].max(initial=-np.inf), ends[a > 0].min(initial=np.inf)


def _enterable(a, b, c, most):
    """The largest x up to `most` at the end of a cell for which there is an s''."""
    admits = lambda x: np.less_equal(*_range(a, b * x + c))
    if admits(most):
        return most
    if not admits(0.0):
        return None
    low, high = 0.0, most
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if admits(middle) else (low, middle)
    return low
