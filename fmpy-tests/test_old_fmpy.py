"""The oldest fmpy that knows FMI 3 reads and steps the FMUs. Others pin such versions: cofmupy, gemseo-fmu."""

import json
import subprocess
import venv
from pathlib import Path

FMUS = Path(__file__).resolve().parent.parent / "target" / "fmu"
SCRIPT = """
import json, sys
from fmpy import __version__, simulate_fmu
rows = {path: len(simulate_fmu(path, stop_time=0.01, output_interval=0.001)) for path in sys.argv[1:]}
print(json.dumps([__version__, rows]))
"""


def test_fmpy_0_3_12_reads_and_runs_all_six(tmp_path):
    venv.create(tmp_path, with_pip=True)
    python = tmp_path / "bin" / "python"
    # fmpy of that time wants setuptools, and knows numpy 1 only.
    install = [python, "-m", "pip", "install", "--quiet", "fmpy==0.3.12", "numpy<2", "setuptools<81"]
    subprocess.run(install, check=True)
    # Nodes on buses need Event Mode and clocks.
    names = ["CableRobotController", "CableRobotPlant", "CableRobotPlantME"]
    paths = [str(FMUS / version / f"{name}.fmu") for version in ("fmi2", "fmi3") for name in names]
    done = subprocess.run([python, "-c", SCRIPT, *paths], check=True, capture_output=True, text=True)
    version, rows = json.loads(done.stdout.splitlines()[-1])
    assert version == "0.3.12" and rows == {path: 11 for path in paths} and len(paths) == 6
