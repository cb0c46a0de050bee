"""ecospy: a C++ master of NTNU's with its own reader of FMUs and systems."""

from common import DELAY, DURATION, GOAL, POSE, STEP, TO_CONTROLLER, TO_PLANT, Table, check_arrival, fmu
from ecospy import EcosSimulation, EcosSimulationStructure

table = Table("ecospy")


def pose(simulation):
    return [simulation.get_real(f"plant::encoderPose.{name}") for name in POSE]


for fmi in (2, 3):
    with EcosSimulationStructure() as structure:
        with table.cell("reads", fmi):
            structure.add_model("controller", fmu(fmi, "Controller"))
            structure.add_model("plant", fmu(fmi, "Plant"))
        for name in TO_CONTROLLER:
            structure.make_real_connection(f"plant::{name}", f"controller::{name}")
        for name in TO_PLANT:
            structure.make_real_connection(f"controller::{name}", f"plant::{name}")
        structure.add_parameter_set("start", {f"controller::{name}": value for name, value in (GOAL | DELAY).items()})
        with table.cell("steps", fmi):
            simulation = EcosSimulation(step_size=STEP, structure=structure)
            assert simulation.init(parameter_set="start")
            simulation.step()
        with table.cell("closes the loop", fmi):
            simulation.step_until(DURATION)
            check_arrival(pose(simulation), simulation.get_integer("controller::statusNumber"))
        table.unavailable("saves a state", fmi)
        table.unavailable("Model Exchange", fmi)
for row, name in [("system", "CableRobot"), ("system, closed", "CableRobotClosed")]:
    with table.cell(row, 2), EcosSimulation(step_size=STEP, ssp_path=f"{name}.ssp") as simulation:
        assert simulation.init()
        simulation.step(100)
        assert abs(pose(simulation)[2] - 1.0) < 1e-6
    table.unavailable(row, 3)
table.print()
