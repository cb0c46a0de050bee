"""Runs recorded with `cable-robot simulate`, with their report and their CSV."""

import csv
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SCREENSHOTS = ROOT / "target" / "screenshots"

# A move, then a push that turns the platform and slackens cables, then another goal; the title must not end up as HTML.
PUSHED = """
title = "A push that slackens cables <&>"
duration = 6.0
[[goals]]
time = 0.0
pose = [0.15, 0.15, 1.0]
[[goals]]
time = 4.0
pose = [0.0, 0.0, 1.0]
[[disturbances]]
from = 1.0
until = 1.3
force = [-20.0, -8.0, 0.0]
torque = [0.0, 0.0, 0.3]
[controller]
planner = "exact"
observer_bound = 0.0
"""


class Recorded:
    """A run folder with its report; `columns` holds the CSV."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.page = folder / "report.html"
        with (folder / "run.csv").open() as file:
            rows = list(csv.reader(file))
        self.columns = {name: [float(row[k]) for row in rows[1:]] for k, name in enumerate(rows[0])}

    def at(self, time: float, name: str) -> float:
        """The value in the row of this time."""
        times = self.columns["time"]
        row = min(range(len(times)), key=lambda k: abs(times[k] - time))
        assert abs(times[row] - time) < 1e-6, f"{time} s is no row of run.csv"
        return self.columns[name][row]


def cable_robot(*arguments) -> None:
    command = ["target/debug/cable-robot", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    # 3: a goal was not reached, 4: a cable went slack.
    assert done.returncode in (0, 3, 4), done.stderr


def record(scenario, folder: Path) -> Recorded:
    cable_robot("simulate", scenario, "--output", folder)
    cable_robot("report", folder)
    return Recorded(folder)
