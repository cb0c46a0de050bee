"""fmpy: the Python importer that most use. The newest and, in an environment of its own, the oldest that knows FMI 3."""

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

from common import CABLES, DELAY, DURATION, GOAL, POSE, STEP, Table, check_arrival, fmu

table = Table("FMPy")


class Slave:
    def __init__(self, fmi, model):
        self.description = read_model_description(fmu(fmi, model))
        self.fmi3 = fmi == 3
        self.fmu = instantiate_fmu(extract(fmu(fmi, model)), self.description, fmi_type="CoSimulation")
        self.references = {variable.name: variable.valueReference for variable in self.description.modelVariables}

    def get(self, names):
        return (self.fmu.getFloat64 if self.fmi3 else self.fmu.getReal)([self.references[name] for name in names])

    def set(self, names, values):
        (self.fmu.setFloat64 if self.fmi3 else self.fmu.setReal)([self.references[name] for name in names], list(values))

    def initialize(self):
        if not self.fmi3:
            self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, time):
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=STEP)

    def saves(self):
        get, serialize, deserialize, put = (
            (self.fmu.getFMUState, self.fmu.serializeFMUState, self.fmu.deserializeFMUState, self.fmu.setFMUState)
            if self.fmi3
            else (self.fmu.getFMUstate, self.fmu.serializeFMUstate, self.fmu.deSerializeFMUstate, self.fmu.setFMUstate)
        )
        put(deserialize(serialize(get())))


MOTORS = [f"motorTension[{i}]" for i in CABLES]
ENCODERS = [f"encoderPose.{name}" for name in POSE]
for fmi in (2, 3):
    with table.cell("reads", fmi):
        controller, plant = Slave(fmi, "Controller"), Slave(fmi, "Plant")
    with table.cell("steps", fmi):
        controller.set(GOAL, GOAL.values())
        controller.set(DELAY, DELAY.values())
        controller.initialize()
        plant.initialize()
        controller.step(0.0)
        plant.step(0.0)
    with table.cell("saves a state", fmi):
        controller.saves()
        plant.saves()
    with table.cell("closes the loop", fmi):
        for k in range(1, round(DURATION / STEP)):
            pose, pull = plant.get(ENCODERS), controller.get(MOTORS)
            controller.set(ENCODERS, pose)
            plant.set(MOTORS, pull)
            controller.step(k * STEP)
            plant.step(k * STEP)
        check_arrival(plant.get(ENCODERS))
    with table.cell("Model Exchange", fmi):
        rows = simulate_fmu(fmu(fmi, "PlantME"), stop_time=0.5, relative_tolerance=1e-8, output=["encoderPose.z"])
        assert np.abs(rows["encoderPose.z"] - 1.0).max() < 1e-6
with table.cell("system", 2):
    from fmpy.ssp.simulation import simulate_ssp

    goal = {f"goalPose.{name}": lambda _, value=GOAL.get(f"goalPose.{name}", 0.0): value for name in POSE}
    rows = simulate_ssp("CableRobot.ssp", stop_time=DURATION, step_size=STEP, input=goal)
    check_arrival([rows[name][-1] for name in ENCODERS], rows["statusNumber"][-1])
with table.cell("system, closed", 2):
    rows = simulate_ssp("CableRobotClosed.ssp", stop_time=0.1, step_size=STEP)
# It knows SSP 1.0.
for row in ("system", "system, closed"):
    table.unavailable(row, 3)
table.print()
