"""Plans, and certificates of steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._numbers import axes, options, pose, six
from ._rig import Rig

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Plan:
    """From rest at a start towards rest at a goal."""

    start: tuple[float, ...]
    """m and rad."""
    goal: tuple[float, ...]
    """m and rad."""
    planner: str
    """bounded, exact or minimum-time."""
    set_points: np.ndarray
    """(k, 6), m and rad, in their order; with way points the poses that are passed, and the goal."""
    reachable: bool | None
    """Whether the last is the goal; `None`: given up after 1,000 set points, not known."""
    smallest_tension: float | None
    """The smallest tension predicted, N."""
    duration: float | None
    """s, of planner minimum-time."""
    times: np.ndarray | None
    """(k,), s: when each is passed, with way points."""
    nearest: tuple[float, ...] | None
    """Of a goal that is not reachable: the nearest pose that is."""
    barrier_cable: int | None
    """and the number of the cable, from 1, that forbids to go on at rest."""

    def plot(self, ax: Any = None) -> Any:
        """Draws the set points in the plane; returns the axes (matplotlib)."""
        ax = axes(ax)
        way = [self.start[:2], *(point[:2] for point in self.set_points)]
        ax.plot(*zip(*way), "o-", markersize=4)
        ax.plot(*self.goal[:2], "*", markersize=12, label="goal")
        ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title=f"{len(self.set_points)} set points, {self.planner}")
        ax.legend()
        return ax


@dataclass(frozen=True)
class Certificate:
    """The verdict on a step, proved (docs/certificate.md)."""

    verdict: str
    """admissible, not admissible or undecided."""
    least: float | None
    """Admissible: a lower bound of all tensions for all time, N,"""
    greatest: float | None
    """and an upper one, N."""
    time: float | None
    """Not admissible: when, undecided: about when, s after the step."""
    cable: int | None
    """Not admissible, six cables: its number, from 1,"""
    tension: float | None
    """and its tension then, N."""
    shortfall: float | None
    """Not admissible, more than six cables: by how much some limit is broken at least, N."""
    cause: str | None
    """Undecided: why."""

    def __bool__(self) -> bool:
        """Whether it is proved that the step is admissible."""
        return self.verdict == "admissible"


def plan(
    rig: Rig,
    start: Sequence[float],
    goal: Sequence[float],
    *,
    planner: str | None = None,
    through: Sequence[Sequence[float]] = (),
    lambda_: float | None = None,
    eta: float | None = None,
    lift: float = 0.0,
    max_tension_rate: float = 0.0,
) -> Plan:
    """The set points from rest at `start` to `goal`.

    planner: "bounded" (the paper's; its rig only), "exact" or "minimum-time"; left out, bounded for the paper's rig, exact for others.
    through: up to seven way points, passed without a stop; then the planner is "minimum-time".
    lambda_, eta: gains, 1/s; the rig file's if left out.
    lift: by how much the platform may rise above the straight way to be quicker, m; max_tension_rate: N/s, 0 for no limit ("minimum-time").
    """
    import numpy as np

    if through and planner not in (None, "minimum-time"):
        raise ValueError(f"planner = {planner!r}: with way points only minimum-time will do, others stop at every set point")
    planner = "minimum-time" if through else planner
    start, goal = pose("start", start), pose("goal", goal)
    ways = [pose("through", way) for way in through]
    found = _native.plan(rig._native, start, goal, ways, options(planner, lambda_, eta, lift, max_tension_rate))
    found["set_points"] = np.array(found["set_points"], dtype=float).reshape(-1, 6)
    found["times"] = found["times"] and np.array(found["times"])
    found["nearest"] = found["nearest"] and tuple(found["nearest"])
    return Plan(start=start, goal=goal, **found)


def certify(
    rig: Rig,
    start: Sequence[float],
    goal: Sequence[float],
    *,
    rates: Sequence[float] | None = None,
    lambda_: float | None = None,
    eta: float | None = None,
    mass_error: float = 0.0,
    centre_of_mass_error: float = 0.0,
    force: float = 0.0,
    torque: float = 0.0,
    friction: float = 0.0,
    accuracy: float | None = None,
    sample_period: float = 0.0,
    delay: float = 0.0,
) -> Certificate:
    """Decides whether the step to the set point `goal`, given at `start`, keeps every tension strictly within its limits for all time.

    rates: of the six coordinates at the start, m/s and rad/s. lambda_, eta: gains, 1/s; the rig file's if left out.
    mass_error: relative error of mass and moments of inertia. centre_of_mass_error: m. force, torque: that disturb, N and N m.
    friction: N a cable. accuracy: of anchors and attachments, m; the rig file's if left out. sample_period, delay: s.
    """
    margins = {
        "mass_error": mass_error,
        "centre_of_mass_error": centre_of_mass_error,
        "force": force,
        "torque": torque,
        "friction": friction,
        "accuracy": accuracy,
        "sample_period": sample_period,
        "delay": delay,
    }
    step = pose("start", start), pose("goal", goal), six("rates", rates)
    return Certificate(**_native.certify(rig._native, *step, (lambda_, eta), margins))
