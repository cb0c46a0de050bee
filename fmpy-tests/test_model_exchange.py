"""The plant for Model Exchange, integrated by others, is the plant of co-simulation."""

import ctypes
import shutil
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from fmpy import extract, instantiate_fmu, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.sundials import CVodeSolver
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

from robot_fmu import Slave, cable_names, fmu_path, pose_names

MODEL = "CableRobotPlantME"
MOTORS, POSE = cable_names("motorTension"), pose_names("encoderPose")
STEP = 0.01
TOLERANCE = 1e-10
REST = 10.761231667425436


@contextmanager
def papers_move(version):
    """The motors obey the controller, which makes the paper's move."""
    with Slave(fmu_path(version, "CableRobotController")) as controller:
        controller.set(pose_names("goalPose"), [0.15, 0.15, 1.0, 0.0, 0.0, 0.0])
        controller.set(POSE, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        controller.initialize()

        def command(pose):
            controller.set(POSE, pose)
            controller.step(STEP)
            return controller.get(MOTORS)

        yield command


@contextmanager
def drop(_version):
    """The motors fling the platform up, let go, pull unevenly and catch it. With friction cables go slack as they run in, and taut as they run out."""
    rows = np.full((40, 6), REST)
    rows[2:8] = 40.0
    rows[8:20] = 0.0
    rows[20:24] = [0.2, 30.0, 0.0, 30.0, -1.0, 30.0]
    rows[24:] = 14.0
    left = iter(rows)
    yield lambda _pose: next(left)


# What commands the motors, for how many steps, and the parameters of the plant.
RUNS = {"papers_move": (papers_move, 800, {}), "drop": (drop, 40, {"friction": 0.4})}


def co_simulated(version, run):
    """Poses and slack cables after each step of the co-simulation plant."""
    commanding, steps, parameters = RUNS[run]
    with Slave(fmu_path(version, "CableRobotPlant")) as plant, commanding(version) as command:
        for name, value in parameters.items():
            plant[name] = value
        plant.initialize()
        poses, slack = [], []
        for _ in range(steps):
            plant.set(MOTORS, command(plant.get(POSE)))
            plant.step(STEP)
            poses.append(plant.get(POSE))
            slack.append([plant[name] for name in cable_names("slack")])
        return np.array(poses), np.array(slack)


class Exchanged:
    """An instance between Event Mode and Continuous-Time Mode."""

    def __init__(self, version):
        path = str(fmu_path(version, MODEL))
        self.description = read_model_description(path)
        self.fmi3 = version == 3
        self.folder = extract(path)
        self.messages = []
        logger = (lambda *log: self.messages.append(log[-1]))
        self.fmu = instantiate_fmu(self.folder, self.description, fmi_type="ModelExchange", logger=logger)
        self.derivatives = self.fmu.getContinuousStateDerivatives if self.fmi3 else self.fmu.getDerivatives
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}

    def start(self, values):
        for name, value in values.items():
            self.set([name], [value])
        if self.fmi3:
            self.fmu.enterInitializationMode()
        else:
            self.fmu.setupExperiment()
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.settle()
        self.fmu.enterContinuousTimeMode()

    def settle(self):
        (self.fmu.updateDiscreteStates if self.fmi3 else self.fmu.newDiscreteStates)()

    def event(self, values):
        self.fmu.enterEventMode()
        self.set(list(values), values.values())
        self.settle()
        self.fmu.enterContinuousTimeMode()

    def set(self, names, values):
        references = [self.references[name] for name in names]
        (self.fmu.setFloat64 if self.fmi3 else self.fmu.setReal)(references, list(values))

    def get(self, names):
        references = [self.references[name] for name in names]
        return np.array((self.fmu.getFloat64 if self.fmi3 else self.fmu.getReal)(references))

    def _array(self, call, count):
        values = (ctypes.c_double * count)()
        call(values, count)
        return np.array(values)

    def states(self):
        return self._array(self.fmu.getContinuousStates, 13)

    def put(self, states):
        self.fmu.setContinuousStates((ctypes.c_double * 13)(*states), 13)

    def rates(self, states):
        self.put(states)
        return self._array(self.derivatives, 13)

    def indicators(self, states):
        self.put(states)
        return self._array(self.fmu.getEventIndicators, 6)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


class CVode:
    """fmpy's."""

    def __init__(self, plant, indicators=6):
        self.solver = CVodeSolver(
            nx=13, nz=indicators, get_x=plant.fmu.getContinuousStates, set_x=plant.fmu.setContinuousStates,
            get_dx=plant.derivatives, get_z=plant.fmu.getEventIndicators, set_time=plant.fmu.setTime,
            get_nominals=plant.fmu.getNominalsOfContinuousStates, input=SimpleNamespace(apply=lambda _time: None),
            startTime=0.0, relativeTolerance=TOLERANCE, maxNumSteps=100_000,
        )

    def advance(self, time, end):
        """Whether an indicator changed its sign, and the time reached."""
        event, _, time = self.solver.step(time, end)
        return event, time

    def restart(self, time):
        self.solver.reset(time)


class RK45:
    """SciPy's, which stops where an indicator changes its sign."""

    def __init__(self, plant):
        self.plant = plant
        self.crossings = [lambda _time, x, k=k: plant.indicators(x)[k] for k in range(6)]
        for crossing in self.crossings:
            crossing.terminal = True

    def advance(self, time, end):
        plant = self.plant
        found = solve_ivp(
            lambda _time, x: plant.rates(x), (time, end), plant.states(), rtol=TOLERANCE, atol=TOLERANCE,
            events=self.crossings,
        )
        assert found.status >= 0, found.message
        time, x = found.t[-1], found.y[:, -1]
        if found.status == 1:
            # A moment past the crossing, so that its sign is certain.
            time, x = time + 1e-9, x + plant.rates(x) * 1e-9
        plant.put(x)
        return found.status == 1, time

    def restart(self, _time):
        pass


def integrated(version, run, integrator, **options):
    """Poses as of `co_simulated`, and how many events there were beside those of the commands."""
    commanding, steps, parameters = RUNS[run]
    with Exchanged(version) as plant, commanding(version) as command:
        plant.start(parameters)
        integrator = integrator(plant, **options)
        poses, events, time = [], 0, 0.0
        for k in range(steps):
            plant.event(dict(zip(MOTORS, command(plant.get(POSE)))))
            integrator.restart(time)
            while time < (k + 1) * STEP - 1e-9:
                event, time = integrator.advance(time, (k + 1) * STEP)
                if event:
                    events += 1
                    plant.event({})
                    integrator.restart(time)
            poses.append(plant.get(POSE))
        return np.array(poses), events


@pytest.mark.parametrize("integrator", [CVode, RK45])
@pytest.mark.parametrize("run", RUNS)
def test_integrated_by_others_it_moves_as_in_co_simulation(version, run, integrator):
    wanted, slack = co_simulated(version, run)
    assert run != "drop" or slack.any() and not slack[-1].any()
    poses, events = integrated(version, run, integrator)
    difference = np.abs(poses - wanted).max()
    print(f"{run}, {integrator.__name__}: {difference:.1e} m, rad, {events} events")
    assert difference < 1e-7


def test_without_the_event_indicators_a_cable_would_push(version):
    wanted, _ = co_simulated(version, "drop")
    assert read_model_description(str(fmu_path(version, MODEL))).numberOfEventIndicators == 6
    poses, _ = integrated(version, "drop", CVode, indicators=0)
    assert np.abs(poses - wanted).max() > 1e-5


def test_validates_without_findings(version):
    assert validate_fmu(str(fmu_path(version, MODEL))) == []


def test_directional_derivatives_are_those_of_differences(version):
    with Exchanged(version) as plant:
        plant.start({"friction": 0.3, "initialPose.x": 0.05, "initialPose.yaw": 0.2})
        x = plant.states() + 1e-4 * np.arange(13)
        plant.put(x)
        states = [name for name in plant.references if name.startswith("state.")]
        rates = [f"der({name})" for name in states]
        unknown, known = [[plant.references[name] for name in names] for names in (rates, states)]
        for k in range(13):
            step = 1e-7 * np.eye(13)[k]
            seen = (plant.rates(x + step) - plant.rates(x - step)) / 2e-7
            plant.put(x)
            said = np.array(plant.fmu.getDirectionalDerivative(unknown, [known[k]], [1.0]))
            assert np.abs(said - seen).max() < 1e-5 * (1.0 + np.abs(seen).max()), states[k]


@pytest.mark.parametrize("integrator", [CVode, RK45])
def test_a_free_fall_has_no_event_without_end(version, integrator):
    """Without friction all pulls are zero: indicators that are zero too stopped SciPy's integrators at every restart."""
    with Exchanged(version) as plant:
        plant.start({})
        integrator, time = integrator(plant), 0.0
        plant.event({name: 0.0 for name in MOTORS})
        assert np.all(plant.indicators(plant.states()) < 0.0)
        integrator.restart(time)
        event, time = integrator.advance(time, 0.1)
        assert not event and abs(time - 0.1) < 1e-12
        assert abs(plant.get(POSE)[2] - (1.0 + 0.5 * 9.81 * 0.1**2)) < 1e-9


def test_what_is_no_number_is_discarded_by_every_getter(version):
    """At a quaternion of length zero the derivatives were discarded and the outputs were NaN with status OK."""
    with Exchanged(version) as plant:
        plant.start({})
        states = plant.states()
        states[6:10] = 0.0
        plant.put(states)
        for name in ("encoderPose.roll", "cableLength[1]"):
            with pytest.raises(FMICallException) as refused:
                plant.get([name])
            assert refused.value.status == 2
        assert np.isfinite(plant.get(["velocity.x"])).all()
