"""The wheel in an environment of its own: module, command line and FMUs, without anything else of this project."""

import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """The Python of a fresh environment in which the wheel is installed, with numpy and without matplotlib."""
    given = os.environ.get("CABLE_ROBOT_WHEEL")
    wheels = [Path(given)] if given else sorted((ROOT / "target/wheels").glob("*/*.whl"))
    if not wheels:
        pytest.skip("no wheel: `cargo wheel` builds it")
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    python = folder / "bin/python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", wheels[-1]], check=True)
    return python


def run(python, code, folder, **options):
    """What a script prints, run where nothing of the project is."""
    done = subprocess.run([python, "-c", code], cwd=folder, capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


def command(python, *arguments, cwd):
    return subprocess.run([python.with_name("cable-robot"), *arguments], cwd=cwd, capture_output=True, text=True)


def test_the_lines_of_the_readme_run_as_printed(installed, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    lines = next(block for block in blocks if "import cable_robot" in block)
    printed = run(installed, lines, tmp_path)
    assert "admissible" in printed and "AtGoal" in printed, printed


def test_the_example_prints_what_the_page_says(installed, tmp_path):
    page = (ROOT / "docs/python.md").read_text()
    said = re.search(r"\$ python (fmpy-tests/examples/heights\.py)\n((?:.+\n)*?)```", page)
    done = subprocess.run([installed, ROOT / said[1], "--csv", "heights.csv"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == said[2], done.stderr
    assert len((tmp_path / "heights.csv").read_text().splitlines()) == 6


def test_numpy_is_not_imported_before_it_is_needed(installed, tmp_path):
    code = (
        "import sys, cable_robot\n"
        "rig = cable_robot.Rig.paper()\n"
        "assert cable_robot.certify(rig, rig.home, (0.1, 0, 1))\n"
        "assert 'numpy' not in sys.modules\n"
        "rig.tensions()\n"
        "assert 'numpy' in sys.modules and 'matplotlib' not in sys.modules"
    )
    run(installed, code, tmp_path)


def test_tensions_hold_the_weight(installed, tmp_path):
    """By numpy alone: directions from anchors and attachments, at zero orientation."""
    code = (
        "import numpy as np, cable_robot\n"
        "rig = cable_robot.Rig.paper()\n"
        "at = np.array([0.05, -0.02, 0.9])\n"
        "found = rig.tensions(at)\n"
        "force = np.zeros(3)\n"
        "for cable, length, tension in zip(rig.cables, found.length, found.tension):\n"
        "    way = np.array(cable.anchor) - at - np.array(cable.attachment)\n"
        "    assert abs(np.linalg.norm(way) - length) < 1e-12\n"
        "    force += tension * way / length\n"
        "assert np.allclose(force, [0, 0, -rig.mass * 9.81], atol=1e-9), force\n"
        "assert found.feasible and found.margin > 1"
    )
    run(installed, code, tmp_path)


def test_plans_say_what_the_command_says(installed, tmp_path):
    code = (
        "import cable_robot as c\n"
        "rig = c.Rig.paper()\n"
        "plan = c.plan(rig, (0, 0, 1), (0.15, 0.15, 1))\n"
        "assert plan.planner == 'bounded' and plan.reachable and plan.set_points.shape == (4, 6)\n"
        "fast = c.plan(rig, (0, 0, 1), (0.15, 0.15, 1), planner='minimum-time')\n"
        "assert 0.5 < fast.duration < 0.6\n"
        "way = c.plan(rig, (0, 0, 1), (0.15, 0.15, 1), through=[(0.1, 0, 1), (0.15, 0.05, 1)])\n"
        "assert way.times.shape == (3,) and way.times[-1] == way.duration\n"
        "far = c.plan(rig, (0, 0, 1), (0, 0.4, 1))\n"
        "assert far.reachable is False and far.nearest and far.barrier_cable\n"
        "print(repr(plan.set_points[0, 0]))"
    )
    first = float(run(installed, code, tmp_path).split("(")[-1].rstrip(")\n"))
    shown = command(installed, "plan", "--from", "0,0,1", "--to", "0.15,0.15,1", "--json", cwd=tmp_path)
    assert shown.returncode == 0 and repr(first) in shown.stdout, shown


def test_runs_are_arrays(installed, tmp_path):
    code = (
        "import cable_robot as c\n"
        "run = c.simulate(c.Rig.paper(), None, (0.1, 0, 1), duration=4, planner='exact')\n"
        "assert run.time.shape == (4001,) and run.pose.shape == (4001, 6) and run.slack.dtype == bool\n"
        "assert run.final_status == 'AtGoal' and abs(run.pose[-1, 0] - 0.1) < 1e-3\n"
        "assert not run.slack.any() and run.smallest_tension > 1\n"
        "gust = c.scenario('gust')\n"
        "assert gust.commanded_tension.shape == gust.measured_tension.shape"
    )
    run(installed, code, tmp_path)


@pytest.mark.parametrize(
    "call, kind, words",
    [
        ("c.plan(rig, (0, 0), (0, 0, 1))", "ValueError", "start = (0.0, 0.0): 3 or 6 numbers are wanted, not 2"),
        ("c.plan(rig, (0, 0, 1), (0, 0, 1), planner='slow')", "ValueError", 'planner = "slow" is none of'),
        ("c.plan(rig, (0, 0, -1), (0, 0, 1))", "ValueError", "start: z = -1: z points down"),
        ("c.simulate(rig, None, (0, 0, 1), duration=1, step=0.3)", "ValueError", "such as 0.9 or 1.2 s"),
        ("c.simulate(rig, None, (float('nan'), 0, 1))", "ValueError", "goal"),
        ("c.certify(rig, rig.home, (0, 0, 1), mass_error=2)", "ValueError", "margins.mass = 2"),
        ("c.Rig.parse('name = 3')", "ValueError", "line"),
        ("c.Rig.load('nowhere.toml')", "OSError", "nowhere.toml"),
        ("c.fmu('Robot')", "ValueError", "Controller"),
        ("c.fmu('Controller', version=4)", "ValueError", "version 2 or 3"),
    ],
)
def test_what_makes_no_sense_is_named(installed, tmp_path, call, kind, words):
    code = (
        "import cable_robot as c\nrig = c.Rig.paper()\n"
        f"try:\n    {call}\n    print('nothing')\nexcept {kind} as error:\n    print(error)"
    )
    assert words in run(installed, code, tmp_path)


def test_the_command_line_is_the_program(installed, tmp_path):
    assert command(installed, "--version", cwd=tmp_path).stdout.startswith("cable-robot ")
    assert command(installed, "certify", "--from", "0,0,1", "--to", "0.1,0,1", cwd=tmp_path).returncode == 0
    refused = command(installed, "plan", "--from", "0,0,1", "--to", "0,0.4,1", cwd=tmp_path)
    assert refused.returncode == 3 and "cable" in refused.stdout
    wrong = command(installed, "plan", "--form", "0,0,1", cwd=tmp_path)
    assert wrong.returncode == 2 and "--from" in wrong.stderr


def test_fmus_of_the_wheel_run_in_a_process_of_their_own_and_are_packed_for_other_rigs(installed, tmp_path):
    path = run(installed, "import cable_robot; print(cable_robot.fmu('Controller'))", tmp_path).strip()
    move = ["simulate", "--to", "0.1,0,1", "--duration", "1", "--json"]
    ours, theirs = (command(installed, *move, *more, cwd=tmp_path) for more in ([], ["--fmu", path]))
    assert ours.returncode == theirs.returncode == 0, theirs.stderr
    rig = ROOT / "rigs/eight.toml"
    packed = command(installed, "fmu", "--rig", str(rig), "--output", "mine", cwd=tmp_path)
    assert packed.returncode == 0 and (tmp_path / "mine/fmi3/CableRobotPlant.fmu").is_file(), packed.stderr


def test_without_matplotlib_a_plot_says_what_is_missing(installed, tmp_path):
    code = (
        "import cable_robot\n"
        "try:\n    cable_robot.Rig.paper().workspace().plot()\n"
        "except ModuleNotFoundError as error:\n    print(error.name)"
    )
    assert run(installed, code, tmp_path).strip() == "matplotlib"


def test_plots_are_drawn(installed, tmp_path):
    """With the matplotlib of the tests' environment."""
    places = os.pathsep.join(place for place in sys.path if place.endswith("site-packages"))
    code = (
        "import matplotlib\nmatplotlib.use('Agg')\nimport cable_robot as c\n"
        "rig = c.Rig.paper()\n"
        "for number, shown in enumerate([rig.workspace(), c.plan(rig, rig.home, (0.15, 0.15, 1)),\n"
        "        c.simulate(rig, None, (0.1, 0, 1), duration=1)]):\n"
        "    shown.plot().figure.savefig(f'{number}.png')"
    )
    run(installed, code, tmp_path, env=os.environ | {"PYTHONPATH": places})
    assert all((tmp_path / f"{number}.png").stat().st_size > 5000 for number in range(3))
