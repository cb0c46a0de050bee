"""fmu-manipulation-toolbox: checks FMUs, and packs several into one that steps them itself, which fmpy runs here."""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import simulate_fmu

from common import DELAY, DURATION, GOAL, POSE, STEP, Table, check_arrival, fmu

table = Table("fmu-manipulation-toolbox")
PROGRAMS = Path(sys.executable).parent


def run(program, *arguments, folder="."):
    done = subprocess.run([PROGRAMS / program, *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


OUTPUTS = [f"encoderPose.{name}" for name in POSE] + ["statusNumber"]


def contained(system, fmi):
    """The system as one FMU, at the end of its run."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(f"{system}.ssp", folder)
        run("fmucontainer", "-fmu-directory", ".", "-fmi", str(fmi), "-container", f"{system}.ssp:{STEP}", folder=folder)
        arrives(str(Path(folder) / f"{system}.fmu"), GOAL)


def arrives(path, start_values):
    rows = simulate_fmu(
        path, stop_time=DURATION, step_size=STEP, output_interval=STEP, start_values=start_values, output=OUTPUTS
    )
    *pose, status = [rows[name][-1] for name in OUTPUTS]
    check_arrival(pose, status)


def two_wires():
    """Controller and plant connected terminal by terminal."""
    controller, plant = "CableRobotController.fmu", "CableRobotPlant.fmu"
    assembly = {
        "name": "Wired.fmu", "step_size": STEP, "auto_input": False, "auto_output": False, "auto_parameter": False,
        "fmu": [controller, plant],
        "link": [[controller, "motors", plant, "motors"], [plant, "sensors", controller, "sensors"]],
        "start": [[controller, name, value] for name, value in (GOAL | DELAY).items()],
        "output": [[plant if name in OUTPUTS[:6] else controller, name, name] for name in OUTPUTS],
    }
    with tempfile.TemporaryDirectory() as folder:
        for model in ("Controller", "Plant"):
            shutil.copy(fmu(3, model), folder)
        (Path(folder) / "wired.json").write_text(json.dumps(assembly))
        run("fmucontainer", "-fmu-directory", ".", "-fmi", "3", "-container", "wired.json", folder=folder)
        arrives(str(Path(folder) / "Wired.fmu"), {})


for fmi in (2, 3):
    with table.cell("reads", fmi):
        for model in ("Controller", "Plant", "PlantME"):
            assert "ERROR" not in run("fmutool", "-input", fmu(fmi, model), "-check")
for row, system, fmi in [("system", "CableRobot", 2), ("system", "CableRobotFMI3", 3)]:
    with table.cell(row, fmi):
        contained(system, fmi)
with table.cell("terminals", 3):
    two_wires()
table.unavailable("terminals", 2)
table.cells["steps"] = table.cells["closes the loop"] = table.cells["system"]
table.unavailable("saves a state")
table.unavailable("Model Exchange")
with table.cell("system, closed", 2), tempfile.TemporaryDirectory() as folder:
    shutil.copy("CableRobotClosed.ssp", folder)
    run("fmucontainer", "-fmu-directory", ".", "-container", f"CableRobotClosed.ssp:{STEP}", folder=folder)
table.unavailable("system, closed", 3)
table.print()
