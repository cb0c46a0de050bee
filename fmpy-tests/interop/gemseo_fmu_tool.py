"""gemseo-fmu: FMUs as disciplines of GEMSEO, on fmpy. It takes every port for a real."""

from pathlib import Path

from gemseo_fmu.disciplines.do_step_fmu_discipline import DoStepFMUDiscipline
from numpy import array

from common import CABLES, DELAY, DURATION, GOAL, POSE, STEP, Table, check_arrival, fmu

table = Table("gemseo-fmu")
MOTORS = [f"motorTension[{i}]" for i in CABLES]
ENCODERS = [f"encoderPose.{name}" for name in POSE]


def discipline(fmi, model, inputs, outputs):
    return DoStepFMUDiscipline(
        str(Path("reals") / fmu(fmi, model)), input_names=inputs, output_names=outputs, initial_time=0.0,
        final_time=DURATION, time_step=STEP, restart=False,
    )


for fmi in (2, 3):
    with table.cell("reads", fmi):
        controller = discipline(fmi, "Controller", ENCODERS + list(GOAL) + list(DELAY), MOTORS + ["statusNumber"])
        plant = discipline(fmi, "Plant", MOTORS, ENCODERS)
    with table.cell("steps", fmi):
        given = {name: array([value]) for name, value in (GOAL | DELAY).items()}
        pose = {name: array([1.0 if name.endswith(".z") else 0.0]) for name in ENCODERS}
        pull = controller.execute(given | pose)
        moved = plant.execute({name: pull[name] for name in MOTORS})
    with table.cell("closes the loop", fmi):
        for _ in range(1, round(DURATION / STEP) - 1):
            pull, moved = (
                controller.execute(given | {name: moved[name] for name in ENCODERS}),
                plant.execute({name: pull[name] for name in MOTORS}),
            )
        check_arrival([float(moved[name][0]) for name in ENCODERS], float(pull["statusNumber"][0]))
    table.unavailable("saves a state", fmi)
for row in ("Model Exchange", "system", "system, closed"):
    table.unavailable(row)
table.print()
