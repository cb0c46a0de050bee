"""States saved, restored and carried into another process."""

import subprocess
import sys

import pytest

from robot_fmu import ClosedLoop, Slave, cable_names, fmu_path, pose_names

RIG = {"friction": 0.2, "motorLag": 0.005, "loadCellNoise": 0.1, "encoderResolution": 1e-5, "noiseSeed": 9}
NAMES = cable_names("measuredTension") + pose_names("encoderPose")


def trace(loop: ClosedLoop, steps: int) -> bytes:
    out = b""
    for _ in range(steps):
        loop.step()
        out += loop.plant.get(NAMES).tobytes() + loop.controller.get(cable_names("motorTension")).tobytes()
    return out


def test_a_run_continues_from_a_saved_state_bit_for_bit(version):
    with ClosedLoop(version, plant=RIG) as loop:
        trace(loop, 500)
        saved, count = (loop.controller.save(), loop.plant.save()), loop.count
        first = trace(loop, 500)
        loop.controller.restore(saved[0])
        loop.plant.restore(saved[1])
        loop.count = count
        assert trace(loop, 500) == first


def test_a_state_continues_in_another_process_bit_for_bit(version, tmp_path):
    with ClosedLoop(version, plant=RIG) as loop:
        trace(loop, 500)
        (tmp_path / "controller").write_bytes(loop.controller.save())
        (tmp_path / "plant").write_bytes(loop.plant.save())
        here = trace(loop, 200)
    script = f"""
import sys; sys.path.insert(0, {str(__file__.rsplit('/', 1)[0])!r})
from pathlib import Path
from robot_fmu import ClosedLoop
from test_state import trace
with ClosedLoop({version}) as loop:
    loop.controller.restore(Path({str(tmp_path)!r}, "controller").read_bytes())
    loop.plant.restore(Path({str(tmp_path)!r}, "plant").read_bytes())
    loop.count = 500
    sys.stdout.buffer.write(trace(loop, 200))
"""
    there = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stdout
    assert there == here


@pytest.mark.parametrize("spoil", ["truncated", "flipped", "garbage", "empty", "foreign"])
def test_a_blob_that_is_not_a_state_of_this_model_is_refused(version, model, spoil):
    other = {"CableRobotController": "CableRobotPlant", "CableRobotPlant": "CableRobotController"}[model]
    # One after the other: fmpy hands the messages of all FMI 2 instances to the logger of the last one.
    with Slave(fmu_path(version, other)) as foreign:
        foreign.initialize()
        foreign_state = foreign.save()
    with Slave(fmu_path(version, model)) as slave:
        slave.initialize()
        good = slave.save()
        blob = {
            "truncated": good[:-1],
            "flipped": good[:40] + bytes([good[40] ^ 1]) + good[41:],
            "garbage": b"\x07" * len(good),
            "empty": b"",
            "foreign": foreign_state,
        }[spoil]
        with pytest.raises(Exception):
            slave.restore(blob)
        assert "state" in slave.messages[-1][2]
        slave.restore(good)
        slave.step(1e-3)
