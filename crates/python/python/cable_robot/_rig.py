"""Rigs: tensions and the static workspace."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._numbers import axes, numbers, pose, six

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Cable:
    """A cable as the rig file says."""

    anchor: tuple[float, ...]
    """Base frame, m."""
    attachment: tuple[float, ...]
    """Platform's frame, whose origin is the centre of mass, m."""
    least: float
    """Least tension, N."""
    greatest: float
    """Greatest tension, N; infinite where nothing limits it."""
    pulley_radius: float | None
    """Of the swivelling pulley at the anchor, m."""


@dataclass(frozen=True)
class Tensions:
    """Lengths and tensions of the cables at a pose."""

    length: np.ndarray
    """(n,), m."""
    tension: np.ndarray
    """(n,), N: of more than six cables as the control law shares the load."""
    margin: float
    """Least distance of a tension to its limit, N; less than 0 if one is broken."""
    widest_margin: float
    """The greatest margin that any distribution has, N."""

    @property
    def feasible(self) -> bool:
        """Whether all tensions are within their limits."""
        return self.margin >= 0.0


@dataclass(frozen=True)
class Workspace:
    """Where the cables can hold the platform at rest within their limits, at one height and orientation."""

    x: np.ndarray
    """(k,), m."""
    y: np.ndarray
    """(k,), m."""
    margin: np.ndarray
    """(k, k), N: how far inside their limits the tensions can be at x[j], y[i]; less than 0 outside."""
    border: np.ndarray
    """(c, 2), m: corners of the border, seen from the deepest point."""
    area: float
    """Within the border, m²."""
    deepest: tuple[float, float]
    """Where the margin is greatest, m."""
    greatest_margin: float
    """The margin there, N."""

    def plot(self, ax: Any = None) -> Any:
        """Draws margins and border; returns the axes (matplotlib)."""
        ax = axes(ax)
        filled = ax.contourf(self.x, self.y, self.margin, levels=[0.0, *self._levels()], cmap="viridis", extend="max")
        ax.figure.colorbar(filled, ax=ax, label="margin (N)")
        ax.plot(*self.border[[*range(len(self.border)), 0]].T, color="black", linewidth=1)
        ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title=f"static workspace, {self.area:.4g} m²")
        return ax

    def _levels(self):
        return [self.greatest_margin * k / 8 for k in range(1, 9)]


class Rig:
    """A cable-suspended robot: six to sixteen cables of any geometry."""

    def __init__(self, native: Any):
        self._native = native

    @classmethod
    def load(cls, path: str | os.PathLike) -> Rig:
        """The rig of a rig file (TOML, docs/rigs.md)."""
        return cls(_native.Rig.load(path))

    @classmethod
    def parse(cls, text: str) -> Rig:
        """The rig of a rig file's text."""
        return cls(_native.Rig.parse(text))

    @classmethod
    def paper(cls) -> Rig:
        """The paper's rig, Table I: z points down."""
        return cls(_native.Rig.paper())

    @property
    def name(self) -> str:
        """What people call it."""
        return self._native.name

    @property
    def mass(self) -> float:
        """Of the platform, kg."""
        return self._native.mass

    @property
    def home(self) -> tuple[float, ...]:
        """x, y, z, roll, pitch, yaw, m and rad."""
        return tuple(self._native.home)

    @property
    def gains(self) -> tuple[float, float]:
        """λ and η of the control law, 1/s."""
        return self._native.gains

    @property
    def cables(self) -> list[Cable]:
        """In the order of their numbers."""
        return [Cable(**cable | {key: tuple(cable[key]) for key in ("anchor", "attachment")}) for cable in self._native.cables]

    def __repr__(self) -> str:
        return f"<Rig {self.name!r}: {len(self.cables)} cables, {self.mass:g} kg>"

    def tensions(
        self,
        at: Sequence[float] | None = None,
        rates: Sequence[float] | None = None,
        accelerations: Sequence[float] | None = None,
    ) -> Tensions:
        """Lengths and tensions at a pose (the home if left out), at rest or with rates (m/s, rad/s) and accelerations (m/s², rad/s²) of the six
        coordinates. Raises `ValueError` where the wrench matrix is singular."""
        import numpy as np

        at = self.home if at is None else pose("at", at)
        found = self._native.tensions(at, six("rates", rates), six("accelerations", accelerations))
        return Tensions(**found | {key: np.array(found[key]) for key in ("length", "tension")})

    def workspace(self, height: float | None = None, orientation: Sequence[float] = (0.0, 0.0, 0.0)) -> Workspace | None:
        """The static workspace at a height (z of the centre of mass, m; the home's if left out) and an orientation (roll, pitch, yaw, rad).
        `None` if the cables hold the platform nowhere there."""
        import numpy as np

        height = self.home[2] if height is None else float(height)
        found = self._native.workspace(height, numbers("orientation", orientation, (3,)))
        if found is None:
            return None
        arrays = {key: np.array(found[key]) for key in ("x", "y", "margin", "border")}
        return Workspace(**found | arrays | {"deepest": tuple(found["deepest"])})
