"""The Modelica package: its plant in a Modelica simulator against the plant FMU, its external functions called from C against the controller FMU."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pymoca.parser
import pytest
import rumoca
from robot_fmu import Slave, cable_names, fmu_path, pose_names

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "modelica" / "CableRobot"
STARTS = [[0.05, -0.03, 1.0, 0.1, -0.05, 0.2], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
TENSION = [12.0, 9.0, 11.0, 10.5, 10.0, 11.5]


@pytest.fixture(scope="session")
def package() -> Path:
    done = subprocess.run([ROOT / "target/debug/fmu-build", "modelica"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())


@pytest.fixture(scope="session")
def harness(package, tmp_path_factory) -> Path:
    program = tmp_path_factory.mktemp("modelica") / "harness"
    library = package / "Resources" / "Library" / "linux64"
    here = ROOT / "fmpy-tests" / "modelica"
    command = ["gcc", "-Wall", "-Wextra", "-Werror", "-std=c11", f"-I{here}", f"-I{package / 'Resources' / 'Include'}", here / "harness.c",
               "-o", program, f"-L{library}", f"-Wl,-rpath,{library}", "-lCableRobot"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return program


def run(harness, *arguments, lines=""):
    return subprocess.run([harness, *map(str, arguments)], input=lines, capture_output=True, text=True)


@pytest.mark.parametrize("path", sorted(SOURCES.rglob("*.mo")), ids=lambda path: str(path.relative_to(SOURCES)))
def test_every_file_is_parsed_and_listed_in_its_package(path):
    assert pymoca.parser.parse(path.read_text()) is not None
    if path.name != "package.mo":
        assert path.stem in (path.parent / "package.order").read_text().split()
        assert path.read_text().startswith("within CableRobot" + "".join(f".{part}" for part in path.relative_to(SOURCES).parts[:-1]) + ";")


@pytest.mark.parametrize("start", STARTS, ids=["turned", "level"])
def test_the_plant_moves_as_the_plant_fmu(start, tmp_path):
    pulls = "".join(f"plant.motorTension[{k}] = {value};" for k, value in enumerate(TENSION, 1))
    text = f"model Moving CableRobot.Plants.Plant plant(initialPose = {{{', '.join(map(str, start))}}}); equation {pulls} end Moving;"
    model = rumoca.Session(roots=[str(SOURCES.parent)]).loads(text, model="Moving", filename=str(tmp_path / "Moving.mo"))
    config = rumoca.SimConfig(solver="bdf", rtol=1e-12, atol=1e-14)
    found = model.simulate(1.0, dt=0.01, config=config)
    times = np.asarray(found.time)
    moved = np.array([np.asarray(found[f"plant.encoderPose[{k}]"]) for k in range(1, 7)])

    with Slave(fmu_path(3, "CableRobotPlant")) as slave:
        slave.set(pose_names("initialPose"), start)
        slave.set(cable_names("motorTension"), TENSION)
        slave.initialize()
        expected = [slave.get(pose_names("encoderPose"))]
        for _ in times[1:]:
            slave.step(0.01)
            expected.append(slave.get(pose_names("encoderPose")))
    expected = np.array(expected).T
    assert np.abs(expected[:, -1] - expected[:, 0]).max() > 0.05, "it moves"
    assert np.abs(moved - expected).max() < 1e-9, np.abs(moved - expected).max(axis=1)


def new_python() -> str | None:
    """A Python of 3.12 or newer: on the path, or one of pyenv's."""
    names = [shutil.which(f"python3.{minor}") for minor in (12, 13, 14)]
    for python in [*names, *sorted(Path.home().glob(".pyenv/versions/3.1[2-9].*/bin/python"))]:
        if python and subprocess.run([python, "-c", "import sys; assert sys.version_info >= (3, 12)"], capture_output=True).returncode == 0:
            return str(python)
    return None


@pytest.mark.parametrize("start", STARTS, ids=["turned", "level"])
def test_the_plants_equations_move_so_in_another_simulator(start, environment_of_modelica):
    given = json.dumps({"folder": str(SOURCES / "Plants"), "initialPose": start, "motorTension": TENSION})
    script = ROOT / "fmpy-tests" / "modelica" / "scalars.py"
    done = subprocess.run([environment_of_modelica, script], input=given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with Slave(fmu_path(3, "CableRobotPlant")) as slave:
        slave.set(pose_names("initialPose"), start)
        slave.set(cable_names("motorTension"), TENSION)
        slave.initialize()
        slave.step(1.0)
        expected = slave.get(pose_names("encoderPose"))
    assert np.abs(np.array(json.loads(done.stdout)) - expected).max() < 1e-9


@pytest.fixture(scope="session")
def environment_of_modelica(tmp_path_factory) -> Path:
    python = new_python()
    if python is None:
        pytest.skip("not run: PyPI's modelica needs a Python of 3.12 or newer, and there is none")
    environment = tmp_path_factory.mktemp("modelica")
    subprocess.run([python, "-m", "venv", environment], check=True)
    requirements = ROOT / "fmpy-tests" / "modelica" / "requirements.txt"
    subprocess.run([environment / "bin/pip", "install", "--quiet", "--requirement", requirements], check=True)
    return environment / "bin" / "python"


@pytest.mark.parametrize("rig", ["paper", "eight"])
def test_the_plant_that_is_written_for_a_rig_moves_as_its_plant_fmu(rig, tmp_path):
    file = ROOT / "rigs" / f"{rig}.toml"
    cable_robot = ROOT / "target/debug/cable-robot"
    written = subprocess.run([cable_robot, "modelica", "--rig", file], cwd=ROOT, capture_output=True, text=True)
    assert written.returncode == 0, written.stderr
    if rig == "paper":
        ours = (SOURCES / "Plants" / "Plant.mo").read_text()
        assert ours == written.stdout.replace("within ;", "within CableRobot.Plants;", 1)
    packed = subprocess.run([cable_robot, "fmu", "--rig", file, "--output", tmp_path / "fmus"], cwd=ROOT, capture_output=True, text=True)
    assert packed.returncode == 0, packed.stderr
    with Slave(tmp_path / "fmus" / "fmi3" / "CableRobotPlant.fmu") as slave:
        count = sum(name.startswith("motorTension[") for name in slave.variables)
        motors, pose = [f"motorTension[{k}]" for k in range(1, count + 1)], pose_names("encoderPose")
        pulls = [value * (1 + 0.02 * (-1) ** k) for k, value in enumerate(slave.get(motors))]
        slave.set(motors, pulls)
        slave.initialize()
        expected = [slave.get(pose)]
        for _ in range(50):
            slave.step(0.01)
            expected.append(slave.get(pose))
    text = written.stdout.replace("within ;", "") + "model Moving Plant plant; equation "
    text += "".join(f"plant.motorTension[{k}] = {value!r};" for k, value in enumerate(map(float, pulls), 1)) + " end Moving;"
    model = rumoca.Session(roots=[str(SOURCES.parent)]).loads(text, model="Moving", filename=str(tmp_path / "Moving.mo"))
    found = model.simulate(0.5, dt=0.01, config=rumoca.SimConfig(solver="bdf", rtol=1e-12, atol=1e-14))
    moved = np.array([np.asarray(found[f"plant.encoderPose[{k}]"]) for k in range(1, 7)]).T
    assert np.abs(moved[-1] - moved[0]).max() > 1e-3, "it moves"
    assert np.abs(moved - np.array(expected)).max() < 1e-9, np.abs(moved - np.array(expected)).max(axis=0)


@pytest.mark.parametrize("planner", [1, 2], ids=["bounded", "exact"])
def test_the_external_functions_give_the_bits_of_the_controller_fmu(harness, planner):
    goal, step = [0.15, 0.1, 1.0, 0.0, 0.0, 0.0], 1e-3
    lines, expected = [], []
    with Slave(fmu_path(3, "CableRobotController")) as controller, Slave(fmu_path(3, "CableRobotPlant")) as plant:
        controller["planner"] = planner
        controller.set(pose_names("goalPose"), goal)
        controller.initialize()
        plant.set(cable_names("motorTension"), controller.get(cable_names("motorTension")))
        plant.initialize()
        for _ in range(1500):
            pose = plant.get(pose_names("encoderPose"))
            controller.set(pose_names("encoderPose"), pose)
            lines.append(" ".join(float(value).hex() for value in [controller.time, step, *pose, *goal]))
            controller.step(step)
            outputs = controller.get(cable_names("motorTension") + pose_names("setPoint") + ["tensionMargin"])
            expected.append([*outputs, controller["status"]])
            plant.set(cable_names("motorTension"), outputs[:6])
            plant.step(step)
    done = run(harness, planner, 3.0, lines="\n".join(lines))
    assert done.returncode == 0, done.stderr
    said = [line.split() for line in done.stdout.splitlines()]
    assert len(said) == len(expected)
    numbers = lambda values: [float.fromhex(value) for value in values]
    for k, (line, wanted) in enumerate(zip(said, expected)):
        assert [*numbers(line[:13]), int(line[13])] == wanted, k
        assert line[:14] == line[14:28], "two controllers do not disturb each other"
    # From rest at the start the planner alone gives the set point that the controller gives first.
    assert numbers(said[0][28:]) == numbers(said[0][6:12])


@pytest.mark.parametrize("arguments, lines, said", [
    ([7, 3.0], "", "planner = 7 is not allowed: 1 is Bounded, 2 is Exact"),
    ([1, -3.0], "", "parameter lambda = -3 is not allowed"),
    ([1, 3.0, "no/such.toml"], "", "rigFile no/such.toml"),
    ([2, 3.0, str(ROOT / "rigs" / "eight.toml")], "0 0.001 0 0 1 0 0 0 0 0 1 0 0 0", "motorTension has 6 elements: the rig has 8 cables"),
    ([1, 3.0], "0 0.001 nan 0 1 0 0 0 0 0 1 0 0 0", "encoderPose.x = NaN is not allowed"),
    ([1, 3.0], "0 0 0 0 1 0 0 0 0 0 1 0 0 0", "samplePeriod = 0 is not allowed"),
])
def test_what_is_wrong_reaches_the_tool_as_a_message(harness, arguments, lines, said):
    done = run(harness, *arguments, lines=lines)
    assert done.returncode == 3 and done.stderr.startswith("CableRobot ") and said in done.stderr, done.stderr
