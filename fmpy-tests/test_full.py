"""FMUs that show all of FMI 3: arrays, Event Mode with the clock of the planner, steps that end where it ticks."""

import re
import shutil
import zipfile

import pytest
from fmpy import extract, instantiate_fmu, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from robot_fmu import Slave, cable_names, packed, pose_names

STEP = 1e-3
PERIOD = 0.05
GOAL = [0.15, 0.15, 1.0, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """FMUs with arrays and with scalars."""
    return [packed(tmp_path_factory.mktemp("full"), *options, rig="paper") / "fmi3" for options in (["--full"], [])]


class Full:
    """An instance whose variables are arrays."""

    def __init__(self, path, events=False, early=False):
        self.description = read_model_description(str(path))
        self.folder = extract(str(path))
        self.messages = []
        self.fmu = instantiate_fmu(
            self.folder, self.description, fmi_type="CoSimulation", event_mode_used=events, early_return_allowed=early,
            logger=lambda _environment, _status, _category, text: self.messages.append(text.decode()),
        )
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.time = 0.0

    def get(self, name, count):
        return self.fmu.getFloat64([self.variables[name].valueReference], count)

    def set(self, name, values):
        self.fmu.setFloat64([self.variables[name].valueReference], list(values))

    def initialize(self):
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, length):
        """Whether there is an event, and whether the step ended early."""
        event, _, early, self.time = self.fmu.doStep(self.time, length)
        return event, early

    def ticks(self):
        return self.fmu.getClock([self.variables["plannerTick"].valueReference])[0]

    def handle_events(self):
        """Whether the clock ticked."""
        ticked = self.ticks()
        self.fmu.updateDiscreteStates()
        assert not self.ticks()
        self.fmu.enterStepMode()
        return ticked

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def path(folders, model, kind=0):
    return folders[kind] / f"CableRobot{model}.fmu"


@pytest.mark.parametrize("model", ["Controller", "Plant", "PlantME"])
def test_validates_without_findings(folders, model):
    assert validate_fmu(str(path(folders, model))) == []


@pytest.mark.parametrize("kind", [0, 1], ids=["full", "scalars"])
@pytest.mark.parametrize("model", ["Controller", "Plant", "PlantME"])
def test_terminals_name_variables_that_are_there(folders, model, kind):
    there = {variable.name for variable in read_model_description(str(path(folders, model, kind))).modelVariables}
    with zipfile.ZipFile(path(folders, model, kind)) as archive:
        text = archive.read("terminalsAndIcons/terminalsAndIcons.xml").decode()
    named = set(re.findall(r'variableName="([^"]*)"', text))
    assert named and named <= there


def moved(controller, plant, handle):
    """Poses and commands of half a second of the paper's move, both of them read and written whole; `handle` is told of each step of the controller."""
    controller.set("goalPose", GOAL)
    controller.initialize()
    plant.initialize()
    handle(True)
    rows = []
    for _ in range(500):
        controller.set("encoderPose", plant.get("encoderPose", 6))
        handle(controller.step(STEP)[0])
        plant.set("motorTension", controller.get("motorTension", 6))
        plant.step(STEP)
        rows.append(plant.get("encoderPose", 6) + controller.get("setPoint", 6))
    return rows


def test_arrays_events_and_clock_change_no_bit(folders):
    ticks = []
    with Full(path(folders, "Controller"), events=True) as controller, Full(path(folders, "Plant")) as plant:

        def handle(event):
            if not event:
                return
            if controller.time > 0.0:
                controller.fmu.enterEventMode()
            assert controller.handle_events()
            ticks.append(controller.time)

        with_events = moved(controller, plant, handle)
    assert ticks == pytest.approx([k * PERIOD for k in range(11)])

    with Full(path(folders, "Controller")) as controller, Full(path(folders, "Plant")) as plant:
        assert moved(controller, plant, lambda _event: None) == with_events

    controller, plant = (Slave(path(folders, model, 1)) for model in ("Controller", "Plant"))
    with controller, plant:
        controller.set(pose_names("goalPose"), GOAL)
        controller.initialize()
        plant.initialize()
        for row in with_events:
            controller.set(pose_names("encoderPose"), plant.get(pose_names("encoderPose")))
            controller.step(STEP)
            plant.set(cable_names("motorTension"), controller.get(cable_names("motorTension")))
            plant.step(STEP)
            assert list(plant.get(pose_names("encoderPose"))) + list(controller.get(pose_names("setPoint"))) == row


def test_a_step_ends_where_the_planner_decides_if_that_is_allowed(folders):
    for early in (False, True):
        with Full(path(folders, "Controller"), events=True, early=early) as controller:
            controller.initialize()
            controller.handle_events()
            assert controller.step(0.03) == (False, False)
            event, ended_early = controller.step(0.03)
            assert (event, ended_early) == (True, early)
            assert controller.time == pytest.approx(PERIOD if early else 0.06)
            controller.fmu.enterEventMode()
            assert controller.handle_events()


def test_what_is_not_as_it_should_be_is_named(folders):
    with Full(path(folders, "Controller")) as controller:
        with pytest.raises(FMICallException):
            controller.set("goalPose", [0.0] * 5)
        assert "right is 6" in controller.messages[-1]
    with Full(path(folders, "Controller")) as controller:
        controller.initialize()
        with pytest.raises(FMICallException):
            controller.fmu.enterEventMode()
        assert "without events" in controller.messages[-1]
    with Full(path(folders, "Plant")) as plant:
        with pytest.raises(FMICallException):
            plant.fmu.getFloat64([plant.variables["motorTension"].valueReference + 1])
        assert "no variable with value reference" in plant.messages[-1]
    with pytest.raises(Exception):
        Full(path(folders, "Controller", 1), events=True)
