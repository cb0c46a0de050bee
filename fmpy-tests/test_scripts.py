"""The scripts that we show people run as they stand."""

import re
import subprocess
import sys
import zipfile
from html import unescape
from pathlib import Path

from robot_fmu import fmu_path

ROOT = Path(__file__).resolve().parent.parent


def run(script: str, folder: Path) -> str:
    done = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_readme_script_reaches_the_goal():
    scripts = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    script = next(script for script in scripts if "fmpy" in script)
    x, y = map(float, re.findall(r"[\d.]+", run(script, ROOT))[:2])
    assert abs(x - 0.15) < 1e-3 and abs(y - 0.15) < 1e-3


def test_the_script_in_each_documentation_runs(version, model, tmp_path):
    page = zipfile.ZipFile(fmu_path(version, model)).read("documentation/index.html").decode()
    script = re.search(r"<pre>(.*?)</pre>", page, re.S).group(1)
    for name in ("CableRobotController", "CableRobotPlant"):
        (tmp_path / f"{name}.fmu").write_bytes(fmu_path(version, name).read_bytes())
    assert run(unescape(script), tmp_path).strip()


def test_messages_of_the_troubleshooting_page_are_those_of_the_programs():
    rows = re.findall(r"^\| (.*?) \|", (ROOT / "docs/troubleshooting.md").read_text(), re.M)
    quoted = {part for row in rows for part in re.findall(r'"([^"]+)"', row)}
    sources = [path for folder in ("src", "crates", "programs") for path in (ROOT / folder).rglob("*.rs")]
    # A message may go on in the next line of the source.
    text = " ".join(path.read_text() for path in sources).replace("\\\n", "")
    assert len(quoted) > 12
    assert [part for part in quoted if part not in text] == []
