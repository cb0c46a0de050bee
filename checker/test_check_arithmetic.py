"""A sample of what `check_arithmetic.py` checks, and that it sees what is wrong."""

import struct
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CHECK = [sys.executable, ROOT / "checker" / "check_arithmetic.py"]


def lines(kind, count):
    command = [ROOT / "target/debug/examples/arithmetic", kind, str(count), "7"]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def checked(text):
    return subprocess.run(CHECK, input=text, capture_output=True, text=True)


@pytest.mark.parametrize("kind, count, names", [("functions", 60_000, 6), ("models", 2000, 11)])
def test_values_and_models_enclose_what_arb_says(kind, count, names):
    found = checked(lines(kind, count))
    assert found.returncode == 0, found.stdout + found.stderr
    assert len(found.stdout.splitlines()) == names, found.stdout


def test_a_value_ten_units_off_and_an_error_a_hundredth_too_small_are_seen():
    name, argument, value = lines("functions", 1).split()
    off = struct.pack(">d", struct.unpack(">d", bytes.fromhex(value))[0] * (1 + 10 * 2**-52)).hex()
    found = checked(f"{name} {argument} {off}\n")
    assert found.returncode == 1 and "line 1" in found.stderr, found.stderr
    worst = 0
    for line in lines("models", 200).splitlines():
        *words, error = line.split()
        small = struct.pack(">d", struct.unpack(">d", bytes.fromhex(error))[0] * 0.99).hex()
        worst += checked(" ".join([*words, small]) + "\n").returncode if line.startswith(("add", "sub")) else 0
    assert worst > 5, worst


def test_nothing_to_check_is_no_success():
    assert checked("").returncode == 1
