"""cofmupy: IRT Saint Exupéry's master on fmpy. It takes every port for a real, and starts every connection, and what is not connected, at 0."""

from pathlib import Path

from cofmupy import Coordinator

from common import DELAY, DURATION, GOAL, POSE, STEP, TO_CONTROLLER, TO_PLANT, Table, check_arrival, fmu

table = Table("cofmupy")


def connection(source, target, variable):
    ends = [{"type": "fmu", "id": part, "variable": variable, "unit": ""} for part in (source, target)]
    return {"source": ends[0], "target": ends[1]}


for fmi in (2, 3):
    parts = {"controller": ("Controller", GOAL | DELAY | {"enable": 1.0}), "plant": ("Plant", {})}
    configuration = {
        "fmus": [
            {"id": part, "name": part, "path": str(Path("reals").resolve() / fmu(fmi, model)), "initialization": start}
            for part, (model, start) in parts.items()
        ],
        "connections": [connection("plant", "controller", name) for name in TO_CONTROLLER]
        + [connection("controller", "plant", name) for name in TO_PLANT],
        "cosim_method": "jacobi",
        "iterative": False,
    }
    coordinator = Coordinator()
    with table.cell("reads", fmi):
        coordinator.start(configuration)
    with table.cell("steps", fmi):
        coordinator.do_step(STEP)
    with table.cell("closes the loop", fmi):
        for _ in range(1, round(DURATION / STEP)):
            coordinator.do_step(STEP)
        found = coordinator.get_variables([("plant", f"encoderPose.{name}") for name in POSE] + [("controller", "statusNumber")])
        *pose, status = [float(value[0]) for value in found.values()]
        check_arrival(pose, status)
    table.unavailable("saves a state", fmi)
for row in ("Model Exchange", "system", "system, closed"):
    table.unavailable(row)
table.print()
