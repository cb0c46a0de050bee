"""A thin, named face on fmpy's FMI 2 and FMI 3 slaves, as the tests and examples use it."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

FMU_FOLDER = Path(__file__).resolve().parent.parent / "target" / "fmu"
POSE = ["x", "y", "z", "roll", "pitch", "yaw"]
STATUS = {1: "Disabled", 2: "Holding", 3: "Moving", 4: "AtGoal", 5: "GoalUnreachable", 6: "SensorFault",
          7: "WaitingForPose"}


def fmu_path(version: int, model: str) -> Path:
    """The packed FMU of `model` (CableRobotController or CableRobotPlant) in FMI `version`."""
    path = FMU_FOLDER / f"fmi{version}" / f"{model}.fmu"
    if not path.exists():
        raise FileNotFoundError(f"{path} is missing: run `cargo fmu build` first")
    return path


def packed(folder, *options, rig="eight"):
    """The folder, with the FMUs of a rig that the program packed there."""
    root = FMU_FOLDER.parent.parent
    command = [root / "target/debug/cable-robot", "fmu", "--rig", root / "rigs" / f"{rig}.toml", "--output", folder, "--library", FMU_FOLDER]
    subprocess.run([*command, *options], check=True, capture_output=True)
    return folder


def pose_names(prefix: str) -> list[str]:
    return [f"{prefix}.{component}" for component in POSE]


def cable_names(prefix: str) -> list[str]:
    return [f"{prefix}[{cable}]" for cable in range(1, 7)]


class Slave:
    """One instance of an FMU; variables by name, messages of the FMU in `messages` as (status, category, text)."""

    def __init__(self, path, debug_logging: bool = False):
        self.path = str(path)
        self.description = read_model_description(self.path)
        self.fmi3 = self.description.fmiVersion.startswith("3")
        self.folder = extract(self.path)
        self.messages = []
        logger = self._log3 if self.fmi3 else self._log2
        self.fmu = instantiate_fmu(
            self.folder, self.description, fmi_type="CoSimulation", debug_logging=debug_logging, logger=logger
        )
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.time = 0.0

    def _log2(self, _environment, _instance, status, category, message):
        self.messages.append((status, category.decode(), message.decode()))

    def _log3(self, _environment, status, category, message):
        self.messages.append((status, category.decode(), message.decode()))

    def _access(self, action: str, name: str):
        variable = self.variables[name]
        kinds = {"Real": "Real", "Float64": "Float64", "Boolean": "Boolean", "Integer": "Integer", "Int32": "Int32"}
        kind = kinds.get(variable.type) or ("Int64" if self.fmi3 else "Integer")
        return getattr(self.fmu, action + kind), [variable.valueReference]

    def __getitem__(self, name: str):
        call, reference = self._access("get", name)
        return call(reference)[0]

    def __setitem__(self, name: str, value):
        call, reference = self._access("set", name)
        call(reference, [value])

    def get(self, names: list[str]) -> np.ndarray:
        """Several real variables."""
        references = [self.variables[name].valueReference for name in names]
        return np.array(self.fmu.getFloat64(references) if self.fmi3 else self.fmu.getReal(references))

    def set(self, names: list[str], values):
        """Several real variables."""
        references = [self.variables[name].valueReference for name in names]
        (self.fmu.setFloat64 if self.fmi3 else self.fmu.setReal)(references, list(values))

    def enter_initialization(self, start_time: float = 0.0, stop_time: float | None = None):
        self.time = start_time
        if self.fmi3:
            self.fmu.enterInitializationMode(startTime=start_time, stopTime=stop_time)
        else:
            self.fmu.setupExperiment(startTime=start_time, stopTime=stop_time)
            self.fmu.enterInitializationMode()

    def exit_initialization(self):
        self.fmu.exitInitializationMode()

    def initialize(self, **keywords):
        self.enter_initialization(**keywords)
        self.exit_initialization()

    def step(self, h: float, time: float | None = None):
        time = self.time if time is None else time
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=h)
        self.time = time + h

    def save(self) -> bytes:
        """The serialised state of the instance."""
        get, serialize, free = (
            (self.fmu.getFMUState, self.fmu.serializeFMUState, self.fmu.freeFMUState)
            if self.fmi3
            else (self.fmu.getFMUstate, self.fmu.serializeFMUstate, self.fmu.freeFMUstate)
        )
        state = get()
        blob = serialize(state)
        free(state)
        return bytes(blob)

    def restore(self, blob: bytes):
        deserialize, put, free = (
            (self.fmu.deserializeFMUState, self.fmu.setFMUState, self.fmu.freeFMUState)
            if self.fmi3
            else (self.fmu.deSerializeFMUstate, self.fmu.setFMUstate, self.fmu.freeFMUstate)
        )
        state = deserialize(blob)
        put(state)
        free(state)

    def close(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class ClosedLoop:
    """Controller and plant FMU, connected; the controller first in each step."""

    def __init__(self, version: int, goal=(0.15, 0.15, 1.0, 0.0, 0.0, 0.0), h: float = 1e-3, controller=None, plant=None):
        self.h, self.count = h, 0
        self.controller = Slave(fmu_path(version, "CableRobotController"))
        self.plant = Slave(fmu_path(version, "CableRobotPlant"))
        for slave, parameters in ((self.controller, controller), (self.plant, plant)):
            for name, value in (parameters or {}).items():
                slave[name] = value
            slave.enter_initialization()
        self.goal = goal
        self._measure()
        self._pull()
        self.controller.exit_initialization()
        self.plant.exit_initialization()

    @property
    def goal(self):
        return self.controller.get(pose_names("goalPose"))

    @goal.setter
    def goal(self, pose):
        self.controller.set(pose_names("goalPose"), pose)

    def _measure(self):
        self.controller.set(pose_names("encoderPose"), self.plant.get(pose_names("encoderPose")))
        for name in ("cableLength", "measuredTension"):
            self.controller.set(cable_names(name), self.plant.get(cable_names(name)))

    def _pull(self):
        self.plant.set(cable_names("motorTension"), self.controller.get(cable_names("motorTension")))

    def step(self):
        time = self.count * self.h
        self._measure()
        self.controller.step(self.h, time)
        self._pull()
        self.plant.step(self.h, time)
        self.count += 1

    def slack(self) -> list[int]:
        """Numbers of the cables that are slack."""
        return [cable for cable in range(1, 7) if self.plant[f"slack[{cable}]"]]

    def close(self):
        self.controller.close()
        self.plant.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
