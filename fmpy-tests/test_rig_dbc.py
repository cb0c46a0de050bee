"""The DBC file of a rig, read by cantools, against the torques, counts and readings that are really on the bus."""

import struct
import subprocess
from pathlib import Path

import cantools
import pytest

ROOT = Path(__file__).resolve().parent.parent
RIG = ROOT / "rigs/can/akd.toml"


def export(rig: Path, bus: str) -> str:
    command = [ROOT / "target/debug/can-bridge", rig, "--export-dbc", bus]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def dbc():
    return cantools.database.load_string(export(RIG, "can0"), "dbc")


def test_every_frame_of_the_bus_is_there(dbc):
    drives, cells = range(1, 7), range(11, 17)
    identifiers = {0x080} | {0x200 + node for node in drives}
    for node in (*drives, *cells):
        identifiers |= {0x180 + node, 0x700 + node, 0x080 + node}
    assert {message.frame_id for message in dbc.messages} == identifiers | {0x77F}


def test_a_torque_is_the_tension_of_its_cable(dbc):
    # 250 per mille of 1 N m at 0.025 m are 10 N; drive 2 pulls with negative torques.
    for node, per_mille in ((1, 250), (2, -250)):
        decoded = dbc.decode_message(0x200 + node, struct.pack("<Hh", 0x000F, per_mille))
        assert str(decoded[f"controlWord_{node}"]) == "enable operation"
        assert decoded[f"targetTension_{node}"] == pytest.approx(10.0)
        # And back.
        encoded = dbc.encode_message(0x200 + node, {f"controlWord_{node}": 15, f"targetTension_{node}": 10.0})
        assert encoded == struct.pack("<Hh", 0x000F, per_mille)


def test_a_drives_answer_is_bits_metres_and_newtons(dbc):
    # A turn of 65536 counts is 2 pi 0.025 m; hauling in makes the cable shorter.
    decoded = dbc.decode_message(0x181, struct.pack("<Hih", 0x0237, 65536, -25))
    assert decoded["cableLength_1"] == pytest.approx(-0.15707963)
    assert decoded["motorTension_1"] == pytest.approx(-1.0)
    set_bits = {name for name, value in decoded.items() if value == 1}
    names = ("readyToSwitchOn", "switchedOn", "operationEnabled", "voltageEnabled", "noQuickStop", "remote")
    assert set_bits == {f"{name}_1" for name in names}


def test_load_cells_that_differ_are_read_as_they_are(dbc, tmp_path):
    assert dbc.decode_message(0x18B, struct.pack("<f", 12.5)) == {"measuredTension_1": 12.5}
    head, *cells = RIG.read_text().split("[[load_cells]]")
    for k, encoding in enumerate(("i16", "i24", "i32", "f32")):
        cells[k] = cells[k].replace('"f32"', f'"{encoding}"').replace("scale = 1.0", "scale = 0.01").replace("offset = 0.0", "offset = -2.0")
    # The second and third on one amplifier.
    cells[2] = cells[2].replace("node = 13", "node = 12").replace("subindex = 1", "subindex = 2")
    rig = tmp_path / "rig.toml"
    head = head.replace('rig = "lab.toml"', f'rig = "{RIG.parent}/lab.toml"')
    rig.write_text("[[load_cells]]".join([head, *cells]))
    dbc = cantools.database.load_string(export(rig, "can0"), "dbc")
    assert dbc.decode_message(0x18B, struct.pack("<h", -300))["measuredTension_1"] == pytest.approx(-5.0)
    packed = struct.pack("<i", -100)[:3] + struct.pack("<i", 123456)
    decoded = dbc.decode_message(0x18C, packed)
    assert decoded["measuredTension_2"] == pytest.approx(-3.0)
    assert decoded["measuredTension_3"] == pytest.approx(1232.56)
    assert dbc.decode_message(0x18E, struct.pack("<f", 300.0))["measuredTension_4"] == pytest.approx(1.0)


def test_a_bus_that_the_rig_does_not_have_is_refused():
    with pytest.raises(subprocess.CalledProcessError) as refusal:
        export(RIG, "can7")
    assert "can7: the fieldbus file knows can0" in refusal.value.stderr
