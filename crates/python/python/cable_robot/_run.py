"""Simulations: controller and plant in a closed loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._numbers import axes, options, pose
from ._rig import Rig

if TYPE_CHECKING:
    import numpy as np

SHAPES = {"time": (), "status": (), "pose": (6,), "set_point": (6,), "reference": (6,), "goal": (6,)}


@dataclass(frozen=True)
class Run:
    """A row at the start and after each step."""

    time: np.ndarray
    """(k,), s."""
    pose: np.ndarray
    """(k, 6), m and rad, as the encoders see it."""
    set_point: np.ndarray
    """(k, 6), m and rad: the active one."""
    reference: np.ndarray
    """(k, 6), m and rad: what the law follows."""
    goal: np.ndarray
    """(k, 6), m and rad."""
    commanded_tension: np.ndarray
    """(k, n), N: held over the step that led to the row."""
    measured_tension: np.ndarray
    """(k, n), N, as the load cells see it."""
    cable_length: np.ndarray
    """(k, n), m."""
    slack: np.ndarray
    """(k, n), whether a cable pulls with nothing."""
    status: np.ndarray
    """(k,), numbers of `status_names`, from 1."""
    status_names: list[str]

    @property
    def smallest_tension(self) -> float:
        """Of all that were measured, N."""
        return float(self.measured_tension.min())

    @property
    def final_status(self) -> str:
        """What the controller said last."""
        return self.status_names[int(self.status[-1]) - 1]

    def plot(self, ax: Any = None) -> Any:
        """Draws the tensions over time; returns the axes (matplotlib)."""
        ax = axes(ax)
        lines = ax.plot(self.time, self.measured_tension, linewidth=1)
        names = [f"cable {number}" for number in range(1, len(lines) + 1)]
        ax.legend(lines, names, loc="center left", bbox_to_anchor=(1.0, 0.5))
        ax.set(xlabel="time (s)", ylabel="tension (N)", title=self.final_status)
        ax.set_ylim(bottom=0.0)
        ax.grid(alpha=0.3)
        return ax


def scenario(name: str) -> Run:
    """Runs a bundled scenario by its name, or that of a scenario file (docs/scenarios.md), to its end."""
    return _run(_native.scenario(str(name)))


def simulate(
    rig: Rig,
    start: Sequence[float] | None,
    goal: Sequence[float],
    *,
    duration: float = 12.0,
    step: float = 1e-3,
    planner: str | None = None,
    lambda_: float | None = None,
    eta: float | None = None,
    lift: float = 0.0,
    max_tension_rate: float = 0.0,
) -> Run:
    """Runs a robot that rests at `start` (the rig's home if `None`) and is given `goal`, for `duration` s with a step of the controller each `step` s.

    The plant is ideal; for friction, noise, pushes and more goals write a scenario file. For the rest see `plan`.
    """
    start = rig.home if start is None else pose("start", start)
    chosen = options(planner, lambda_, eta, lift, max_tension_rate)
    return _run(_native.simulate(rig._native, start, pose("goal", goal), (duration, step), chosen))


def _run(found):
    import numpy as np

    cables, names = found.pop("cables"), found.pop("status_names")
    arrays = {key: np.frombuffer(data).reshape(-1, *SHAPES.get(key, (cables,))) for key, data in found.items()}
    arrays |= {"slack": arrays["slack"] != 0.0, "status": arrays["status"].astype(int)}
    return Run(status_names=names, **arrays)
