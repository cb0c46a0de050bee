"""pathsim-fmi: FMUs as blocks of PathSim. It takes every port for a real, and sets to 0 what nothing is connected to."""

from pathlib import Path

from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from pathsim_fmi import CoSimulationFMU, ModelExchangeFMU

from common import DELAY, DURATION, GOAL, POSE, REST, STEP, TO_CONTROLLER, TO_PLANT, Table, check_arrival, fmu

table = Table("pathsim-fmi")


def real(fmi, model):
    return str(Path("reals") / fmu(fmi, model))


def constants(block, values):
    """Sources of these inputs of a block, and what connects them."""
    sources = [Constant(value) for value in values.values()]
    return sources, [Connection(source, block[name]) for source, name in zip(sources, values)]


for fmi in (2, 3):
    with table.cell("reads", fmi):
        controller = CoSimulationFMU(real(fmi, "Controller"), start_values=DELAY, dt=STEP)
        plant = CoSimulationFMU(real(fmi, "Plant"), dt=STEP)
    with table.cell("steps", fmi):
        sources, connections = constants(controller, GOAL | {"enable": 1.0})
        connections += [Connection(plant[name], controller[name]) for name in TO_CONTROLLER]
        connections += [Connection(controller[name], plant[name]) for name in TO_PLANT]
        simulation = Simulation([controller, plant, *sources], connections, dt=STEP, log=False)
        simulation.run(0.01, reset=False)
    with table.cell("closes the loop", fmi):
        simulation.run(DURATION - 0.01, reset=False)
        check_arrival([plant.outputs[f"encoderPose.{name}"] for name in POSE])
    table.unavailable("saves a state", fmi)
    with table.cell("Model Exchange", fmi):
        plant = ModelExchangeFMU(real(fmi, "PlantME"))
        sources, connections = constants(plant, {name: REST for name in TO_PLANT})
        Simulation([plant, *sources], connections, dt=STEP, log=False).run(0.1)
        assert abs(plant.outputs["encoderPose.z"] - 1.0) < 1e-6, plant.outputs["encoderPose.z"]
for row in ("system", "system, closed"):
    table.unavailable(row)
table.print()
