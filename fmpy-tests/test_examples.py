"""The examples run, and print what docs/python.md says."""

import csv
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from dask.distributed import LocalCluster

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "fmpy-tests" / "examples"
OF_THE_WHEEL = "heights"
NAMES = ["closed_loop", "goal_sequence", "sweep_gains", "sweep_dask"]


def run(name, folder, *options):
    return subprocess.run(
        [sys.executable, str(EXAMPLES / f"{name}.py"), *options], cwd=folder, capture_output=True, text=True
    )


def documented():
    """Name, options and output of each example as docs/python.md shows them; what needs the wheel is test_wheel.py's."""
    page = (ROOT / "docs" / "python.md").read_text()
    blocks = re.findall(r"\$ python fmpy-tests/examples/(\w+)\.py(.*)\n((?:.+\n)*?)```", page)
    return [(name, options.split(), output) for name, options, output in blocks if name != OF_THE_WHEEL]


def test_the_page_shows_each_example():
    assert [name for name, _, _ in documented()] == NAMES


@pytest.mark.parametrize("name, options, output", documented(), ids=lambda value: value if isinstance(value, str) else "")
def test_an_example_prints_what_the_page_says(name, options, output, tmp_path):
    done = run(name, tmp_path, *options, "--picture", "made.png", "--csv", "made.csv")
    assert done.returncode == 0, done.stderr
    assert done.stdout == output
    assert (tmp_path / "made.png").read_bytes().startswith(b"\x89PNG")
    header, *rows = csv.reader((tmp_path / "made.csv").open())
    assert rows and all(len(row) == len(header) for row in rows)


@pytest.mark.parametrize("name", NAMES)
def test_help_says_what_an_example_does(name, tmp_path):
    done = run(name, tmp_path, "--help")
    assert done.returncode == 0 and "--picture" in done.stdout and "tension" in done.stdout.split("options:")[0]


def test_without_dask_its_example_says_what_to_install(tmp_path):
    """It ended in a traceback, --help too."""
    (tmp_path / "dask").mkdir()
    (tmp_path / "dask" / "__init__.py").write_text("raise ImportError('no dask here')")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, str(EXAMPLES / "sweep_dask.py")]
    helped = subprocess.run([*command, "--help"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert helped.returncode == 0 and "--scheduler" in helped.stdout, helped.stderr
    refused = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert refused.returncode == 2 and "requirements-dask.txt" in refused.stderr, refused.stderr


def test_the_examples_requirements_are_those_tested_with():
    """They asked for sixty packages where three serve."""
    pinned = (ROOT / "fmpy-tests" / "requirements.txt").read_text().splitlines()
    for name, count in (("requirements.txt", 3), ("requirements-dask.txt", 1)):
        lines = (EXAMPLES / name).read_text().splitlines()
        wanted = [line.replace("[distributed]", "") for line in lines if "==" in line]
        assert len(wanted) == count and set(wanted) <= set(pinned)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_missing_is_said_before_anything_runs(name, tmp_path):
    for options, expected in ((["--fmus", "nowhere"], "cargo fmu build"), (["--csv", "no/such.csv"], "no/such.csv")):
        done = run(name, tmp_path, *options)
        assert done.returncode == 2 and expected in done.stderr, done.stderr


def test_a_goal_that_cannot_be_had_is_said(tmp_path):
    done = run("closed_loop", tmp_path, "--goal", "0.5,0,1", "--duration", "0.2")
    assert done.returncode == 3 and "not at the goal: GoalUnreachable" in done.stdout


@pytest.mark.parametrize(
    "name, options, expected",
    [("closed_loop", ["--goal", "1,2"], "a position is x,y,z"), ("goal_sequence", ["0,0,1", "1,2"], "a position is x,y,z"),
     ("closed_loop", ["--goal", "nan,0,1"], "'nan' is not a finite number"),
     ("closed_loop", ["--goal", "0,zero,1"], "'zero' is not a finite number"),
     ("closed_loop", ["--goal", "0,0,-1"], "z > 0"),
     ("closed_loop", ["--duration", "0"], "'0' is not a time above 0"),
     ("closed_loop", ["--step", "-0.001"], "'-0.001' is not a time above 0"),
     ("goal_sequence", ["--longest", "inf"], "'inf' is not a time above 0"),
     ("goal_sequence", ["0.1,nan,1"], "'nan' is not a finite number"),
     ("sweep_gains", ["--gains", "3,-2"], "'-2' is not a gain above 0"),
     ("sweep_dask", ["--gains", "0,4"], "'0' is not a gain above 0"),
     ("sweep_dask", ["--workers", "0"], "'0' is not a number of workers"),
     ("closed_loop", ["--picture", "x.xyz"], "a picture ends with .png, .svg, .pdf"),
     ("sweep_gains", ["--picture", "x.xyz"], "a picture ends with .png, .svg, .pdf"),
     ("sweep_gains", ["--csv", "."], "it is a folder"),
     ("sweep_dask", ["--scheduler", "tcp://127.0.0.1:1"], "no scheduler at tcp://127.0.0.1:1")],
)
def test_wrong_options_are_named(name, options, expected, tmp_path):
    done = run(name, tmp_path, *options)
    assert done.returncode == 2 and expected in done.stderr.splitlines()[-1], done.stderr


def test_a_goal_may_begin_with_a_minus(tmp_path):
    done = run("closed_loop", tmp_path, "--goal", "-0.1,0,1", "--duration", "3")
    assert done.returncode == 0 and "set point 1 from 0.00 s on: (-0.1000, 0.0000, 1.0000) m" in done.stdout, done.stderr
    done = run("goal_sequence", tmp_path, "-.05,0,1", "--longest", "3")
    assert done.returncode == 0 and "1: (-0.05, 0.0, 1.0) AtGoal" in done.stdout, done.stderr


@pytest.mark.parametrize("name, options", [("sweep_gains", []), ("sweep_dask", ["--workers", "2"])])
def test_ctrl_c_is_a_line_and_no_traceback(name, options, tmp_path):
    started = subprocess.Popen(
        [sys.executable, "-u", str(EXAMPLES / f"{name}.py"), *options], cwd=tmp_path, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, start_new_session=True,
    )
    # At work once it says how far it is; what a terminal does then: the signal goes to the whole group. lxml loses the exception of one
    # that comes while it reads a description; who presses Ctrl-C in vain presses it again.
    (started.stderr if name == "sweep_dask" else started.stdout).read(1)
    for _ in range(5):
        os.killpg(started.pid, signal.SIGINT)
        try:
            _, said = started.communicate(timeout=2 if name == "sweep_gains" else 60)
            break
        except subprocess.TimeoutExpired:
            continue
    said = said.decode()
    assert started.returncode == 130 and said.splitlines()[-1] == "interrupted" and "Traceback" not in said, said


def test_a_cluster_elsewhere_gives_the_same(tmp_path):
    """Two workers whose only files are those that the example sends them."""
    options = ["--gains", "4,8", "--step", "0.005", "--csv"]
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        there = run("sweep_dask", tmp_path, *options, "there.csv", "--scheduler", cluster.scheduler_address)
    assert there.returncode == 0, there.stderr
    assert "4 of 4 cases" in there.stderr, "progress"
    here = run("sweep_dask", tmp_path, *options, "here.csv", "--workers", "1")
    assert here.returncode == 0, here.stderr
    assert (tmp_path / "there.csv").read_text() == (tmp_path / "here.csv").read_text()
