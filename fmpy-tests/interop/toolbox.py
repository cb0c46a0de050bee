"""fmu-manipulation-toolbox: checks FMUs, and packs several into one that steps them itself, which fmpy runs here."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import simulate_fmu

from common import DURATION, GOAL, POSE, STEP, Table, check_arrival, fmu

table = Table("fmu-manipulation-toolbox")
PROGRAMS = Path(sys.executable).parent


def run(program, *arguments, folder="."):
    done = subprocess.run([PROGRAMS / program, *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def contained(system, fmi):
    """The system as one FMU, at the end of its run."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(f"{system}.ssp", folder)
        run("fmucontainer", "-fmu-directory", ".", "-fmi", str(fmi), "-container", f"{system}.ssp:{STEP}", folder=folder)
        outputs = [f"encoderPose.{name}" for name in POSE] + ["statusNumber"]
        rows = simulate_fmu(
            str(Path(folder) / f"{system}.fmu"), stop_time=DURATION, step_size=STEP, output_interval=STEP, start_values=GOAL, output=outputs
        )
        *pose, status = [rows[name][-1] for name in outputs]
        check_arrival(pose, status)


for fmi in (2, 3):
    with table.cell("reads", fmi):
        for model in ("Controller", "Plant", "PlantME"):
            assert "ERROR" not in run("fmutool", "-input", fmu(fmi, model), "-check")
for row, system, fmi in [("system", "CableRobot", 2), ("system", "CableRobotFMI3", 3)]:
    with table.cell(row, fmi):
        contained(system, fmi)
table.cells["steps"] = table.cells["closes the loop"] = table.cells["system"]
table.unavailable("saves a state")
table.unavailable("Model Exchange")
with table.cell("system, closed", 2), tempfile.TemporaryDirectory() as folder:
    shutil.copy("CableRobotClosed.ssp", folder)
    run("fmucontainer", "-fmu-directory", ".", "-container", f"CableRobotClosed.ssp:{STEP}", folder=folder)
table.unavailable("system, closed", 3)
table.print()
