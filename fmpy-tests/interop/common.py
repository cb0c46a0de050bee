"""What the scripts here have in common. Each tries the packed FMUs in a tool of others and prints what it found as a line of JSON:

    {"tool": "ecospy 0.7.2", "cells": {"reads": {"fmi2": "yes", "fmi3": "no: ..."}, ...}}

A tool is told to make the paper's move, with both FMUs stepped with what the other said a step before. Their working folder is that of the FMUs and
systems that `cargo interop` packs.
"""

import json
import sys
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

CABLES = range(1, 7)
POSE = ["x", "y", "z", "roll", "pitch", "yaw"]
GOAL = {"goalPose.x": 0.15, "goalPose.y": 0.15, "goalPose.z": 1.0}
# What the motors pull at rest at the start, N.
REST = 10.761231667425436
STEP = 1e-3
DURATION = 10.0
# Both FMUs are stepped at once.
DELAY = {"commandDelay": STEP}
AT_GOAL = 4
TO_CONTROLLER = [f"encoderPose.{name}" for name in POSE] + [
    f"{name}[{i}]" for name in ("cableLength", "measuredTension") for i in CABLES
]
TO_PLANT = [f"motorTension[{i}]" for i in CABLES]


class Table:
    """The cells of a tool."""

    def __init__(self, package):
        self.tool = f"{package} {version(package)}"
        self.cells = {}

    @contextmanager
    def cell(self, row, fmi):
        """Whether what is done within works."""
        cells = self.cells.setdefault(row, {})
        try:
            yield
            cells[f"fmi{fmi}"] = "yes"
        except BaseException as error:  # what a tool throws is its affair
            lines = str(error).strip().splitlines() or [type(error).__name__]
            cells[f"fmi{fmi}"] = f"no: {lines[-1][:120]}"

    def unavailable(self, row, *fmis):
        """The tool has no such thing, or no script here tries it."""
        for fmi in fmis or (2, 3):
            self.cells.setdefault(row, {})[f"fmi{fmi}"] = "–"

    def print(self):
        # Tools write to the same stream; the line that counts is the last one.
        sys.stdout.flush()
        print("\n" + json.dumps({"tool": self.tool, "cells": self.cells}, ensure_ascii=False), flush=True)


def fmu(fmi, model):
    return str(Path(f"fmi{fmi}") / f"CableRobot{model}.fmu")


def check_arrival(pose, status=AT_GOAL):
    """At the goal, in the way that the tool's master gets there."""
    wanted = [0.15, 0.15, 1.0, 0.0, 0.0, 0.0]
    assert max(abs(a - b) for a, b in zip(pose, wanted)) < 1e-4 and status == AT_GOAL, f"ends at {pose}, status {status}"
