"""FMUs of another rig than the paper's, packed by the program and stepped by fmpy."""

import zipfile

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.ssp.simulation import simulate_ssp
from fmpy.validation import validate_fmu

from robot_fmu import Slave, packed, pose_names

CABLES = range(1, 9)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The FMUs of the rig of eight cables."""
    return packed(tmp_path_factory.mktemp("eight"))


@pytest.fixture(scope="module")
def in_reals(tmp_path_factory):
    """The same for importers that take every variable for a real."""
    return packed(tmp_path_factory.mktemp("reals"), "--reals")


def names(prefix):
    return [f"{prefix}[{i}]" for i in CABLES]


def start(slave, name):
    """The start value that the XML says."""
    return float(slave.variables[name].start)


def test_they_validate_and_speak_of_eight_cables(folder, version, model):
    path = folder / f"fmi{version}" / f"{model}.fmu"
    assert validate_fmu(str(path)) == []
    variables = Slave(path).variables
    assert "motorTension[8]" in variables and "anchor[8].z" in variables
    assert "motorTension[9]" not in variables and "a" not in variables


def test_the_plant_for_model_exchange_has_an_indicator_a_cable_and_starts_at_rest(folder, version):
    path = folder / f"fmi{version}" / "CableRobotPlantME.fmu"
    assert validate_fmu(str(path)) == []
    description = read_model_description(str(path))
    assert (description.numberOfContinuousStates, description.numberOfEventIndicators) == (13, 8)
    result = simulate_fmu(str(path), stop_time=0.1, output=["encoderPose.z", "measuredTension[8]"])
    assert abs(result["encoderPose.z"] - result["encoderPose.z"][0]).max() < 1e-6
    assert result["measuredTension[8]"].min() > 0.0


def test_a_goal_is_reached_within_the_limits(folder, version):
    controller, plant = (Slave(folder / f"fmi{version}" / f"CableRobot{model}.fmu") for model in ("Controller", "Plant"))
    goal = [0.3, 0.2, 1.9]
    controller.set(pose_names("goalPose")[:3], goal)
    # In the cables from the first instant, as docs/fmu.md says.
    for slave in (controller, plant):
        slave.enter_initialization()
    controller.set(pose_names("encoderPose"), plant.get(pose_names("encoderPose")))
    plant.set(names("motorTension"), controller.get(names("motorTension")))
    for slave in (controller, plant):
        slave.exit_initialization()
    least, greatest = np.inf, 0.0
    for _ in range(4000):
        controller.set(pose_names("encoderPose"), plant.get(pose_names("encoderPose")))
        controller.step(1e-3)
        tension = controller.get(names("motorTension"))
        least, greatest = min(least, tension.min()), max(greatest, tension.max())
        plant.set(names("motorTension"), tension)
        plant.step(1e-3)
        if controller["atGoal"]:
            break
    assert controller["atGoal"], controller["status"]
    assert np.abs(plant.get(pose_names("encoderPose"))[:3] - goal).max() < 5e-3
    assert 5.0 < least and greatest < 400.0, (least, greatest)


def test_a_calibration_is_a_parameter_and_a_planner_that_does_not_serve_is_named(folder, version):
    controller = Slave(folder / f"fmi{version}" / "CableRobotController.fmu")
    controller.set(["anchor[1].x"], [start(controller, "anchor[1].x") + 0.002])
    controller.initialize()
    wrong = Slave(folder / f"fmi{version}" / "CableRobotController.fmu")
    with pytest.raises(Exception):
        wrong.set(["anchor[1].x"], [np.nan])
    assert "anchor[1].x" in wrong.messages[-1][2]


def test_a_step_with_the_anchors_of_another_rig_is_another(folder, version):
    """The geometry is a parameter that counts: moved anchors give other tensions."""
    def tensions(shift):
        controller = Slave(folder / f"fmi{version}" / "CableRobotController.fmu")
        controller.set(["anchor[1].z"], [start(controller, "anchor[1].z") + shift])
        controller.initialize()
        return controller.get(names("motorTension"))

    assert np.abs(tensions(0.0) - tensions(-0.05)).max() > 0.1


def test_in_reals_everything_is_a_real_and_the_steps_are_the_same(folder, in_reals, version, model):
    usual, real = (Slave(root / f"fmi{version}" / f"{model}.fmu") for root in (folder, in_reals))
    assert validate_fmu(real.path) == []
    assert list(real.variables) == list(usual.variables)
    assert {variable.type for variable in real.variables.values()} == {"Float64" if version == 3 else "Real"}
    for slave in (usual, real):
        slave.initialize()
        for _ in range(50):
            slave.step(1e-3)
    for name in usual.variables:
        assert real[name] == float(usual[name]), name


def test_a_real_that_stands_for_something_else_takes_only_what_that_takes(in_reals, version):
    path = in_reals / f"fmi{version}" / "CableRobotController.fmu"
    for name, wrong, allowed in [
        ("enable", 0.5, "0 (false) or 1 (true)"), ("bisectionSteps", 7.5, "a whole number"), ("planner", 4.0, "2 (Exact)")
    ]:
        slave = Slave(path)
        with pytest.raises(Exception):
            slave[name] = wrong
        assert name in slave.messages[-1][2] and allowed in slave.messages[-1][2]


@pytest.mark.parametrize("options", [["--ssp"], ["--ssp", "--reals"]])
def test_a_system_whose_connections_start_at_zero_reaches_its_goal(tmp_path, options):
    """fmpy.ssp, like others, hands zeros to everything first, and lets each step with what the other said a step before."""
    packed(tmp_path, *options, rig="paper")
    goal = {"goalPose.x": 0.1, "goalPose.y": 0.05, "goalPose.z": 1.0}
    names = [f"goalPose.{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw")]
    given = {name: lambda _, value=goal.get(name, 0.0): value for name in names}
    rows = simulate_ssp(str(tmp_path / "CableRobot.ssp"), stop_time=4.0, step_size=1e-3, input=given)
    end = {name: rows[name][-1] for name in rows.dtype.names}
    found = {name: end[name.replace("goalPose", "encoderPose")] for name in goal}
    assert np.abs([found[name] - goal[name] for name in goal]).max() < 2e-3, end
    assert end["atGoal"] and end["statusNumber"] == 4
    # The first step pulls with what it was handed, zeros.
    assert min(rows[f"motorTension[{i}]"][2:].min() for i in range(1, 7)) > 0.0


def test_a_system_of_another_rig_names_its_cables(tmp_path):
    packed(tmp_path, "--ssp")
    with zipfile.ZipFile(tmp_path / "CableRobot.ssp") as archive:
        text = archive.read("SystemStructure.ssd").decode()
        assert sorted(archive.namelist()) == [
            "SystemStructure.ssd", "resources/CableRobotController.fmu", "resources/CableRobotPlant.fmu"
        ]
    assert text.count('startConnector="motorTension[8]"') == 2 and "motorTension[9]" not in text
