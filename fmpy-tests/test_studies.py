"""What docs/studies.md says of the closed form, through the packed FMUs: the planner switched as a parameter."""

import re
from pathlib import Path

import pytest

from robot_fmu import ClosedLoop

STUDIES = Path(__file__).resolve().parent.parent / "docs" / "studies.md"
PLANNER = {"Bounded": 1, "ExactFromAnyState": 2}


def times_of_the_papers_move() -> dict[tuple[float, str], float]:
    """By gain and planner, s."""
    rows = re.findall(r"^ +(\d+)  (\w+) +([\d.]+) ", STUDIES.read_text(), re.MULTILINE)
    return {(float(gain), planner): float(time) for gain, planner, time in rows if planner in PLANNER}


@pytest.mark.parametrize("gain", [3.0, 5.0, 8.0])
@pytest.mark.parametrize("planner", PLANNER)
def test_the_papers_move_takes_the_time_of_the_study(version, gain, planner):
    expected = times_of_the_papers_move()[gain, planner]
    with ClosedLoop(version, controller={"planner": PLANNER[planner], "lambda": gain, "eta": gain}) as loop:
        while not loop.controller["atGoal"]:
            loop.step()
            assert loop.slack() == [] and loop.count < 15_000
        # Each set point, and the end, may come a tick of 0.05 s earlier or later: rest is told from an estimate, under held commands.
        ticks = loop.controller["setPointIndex"] + 1
        assert loop.count * 1e-3 == pytest.approx(expected, abs=0.05 * ticks)
