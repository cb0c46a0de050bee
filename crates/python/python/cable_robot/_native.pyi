"""The library's answers as dictionaries; `cable_robot` makes classes and arrays of them."""

from os import PathLike
from typing import Any

class Rig:
    name: str
    mass: float
    home: list[float]
    gains: tuple[float, float]
    cables: list[dict[str, Any]]
    @staticmethod
    def load(path: str | PathLike) -> Rig: ...
    @staticmethod
    def parse(text: str) -> Rig: ...
    @staticmethod
    def paper() -> Rig: ...
    def tensions(self, at: tuple[float, ...], rates: tuple[float, ...], accelerations: tuple[float, ...]) -> dict[str, Any]: ...
    def workspace(self, height: float, angles: tuple[float, ...]) -> dict[str, Any] | None: ...

def plan(
    rig: Rig, start: tuple[float, ...], goal: tuple[float, ...], through: list[tuple[float, ...]], options: dict[str, Any]
) -> dict[str, Any]: ...
def certify(
    rig: Rig,
    start: tuple[float, ...],
    goal: tuple[float, ...],
    rates: tuple[float, ...],
    gains: tuple[float | None, float | None],
    margins: dict[str, Any],
) -> dict[str, Any]: ...
def scenario(name: str) -> dict[str, Any]: ...
def simulate(
    rig: Rig, start: tuple[float, ...], goal: tuple[float, ...], times: tuple[float, float], options: dict[str, Any]
) -> dict[str, Any]: ...
def run_command(arguments: list[str], interpreter: str, fmus: str | PathLike) -> int: ...
