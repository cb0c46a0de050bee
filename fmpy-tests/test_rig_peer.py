"""The program can-bridge against drives and load cells that others wrote: canopen's nodes, after the standards (rig_peer.py)."""

import json
import math
import re
import signal
import subprocess
import threading
import time
import tomllib
from pathlib import Path

import canopen
import jsonschema
import pytest

from rig_peer import CYCLIC_SYNCHRONOUS_TORQUE, HEARTBEAT_LOST, OPERATIONAL, VALUE_OUT_OF_RANGE, Lab, null_modem
from schemas import described

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/debug/can-bridge"
EXIT_FAULT = 5

# Python is no real-time system: slower, and more patient, than the example.
PATIENT = {
    "rate": 25.0,
    "period": 0.05,
    "timeout": 1.5,
    "drive_watchdog": 1.0,
    "service": 2.0,
    "enable": 5.0,
    "lost_cycles": 20,
    "disagreement_time": 1.0,
    "rig": f'"{ROOT}/rigs/can/lab.toml"',
}


def patient(name: str, changes: dict) -> str:
    """An example's fieldbus file, with these changes."""
    text = (ROOT / "rigs/can" / name).read_text()
    for field, value in changes.items():
        text, count = re.subn(rf"^{field} = \S+", f"{field} = {value}", text, count=1, flags=re.M)
        assert count == 1, field
    return re.sub(r"(\[slack\][^[]*?ramp = )2.0", r"\g<1>0.5", text)


def rig_file(folder: Path, packed: bool) -> tuple[Path, dict]:
    text = patient("akd.toml", PATIENT)
    # Winches that differ, so that none can be mistaken for another.
    for k, gear, radius in ((1, 1.0, 0.02), (2, 3.0, 0.05), (4, 0.5, 0.01)):
        parts = text.split("[[drives]]")
        parts[k] = parts[k].replace("gear = 1.0", f"gear = {gear}").replace("pulley_radius = 0.025", f"pulley_radius = {radius}")
        text = "[[drives]]".join(parts)
    if packed:
        for k in range(6):
            frame = f"torque_frame = {{ id = {0x201 + 3 * (k // 3)}, slot = {k % 3 + 1} }}"
            text = text.replace(f"\nnode = {k + 1}\n", f"\nnode = {k + 1}\n{frame}\n")
            cell = f"node = {11 + k // 3}\nindex = 0x7130\nsubindex = {k % 3 + 1}\nencoding = \"i16\"\nscale = 0.01"
            text = re.sub(rf'node = {11 + k}\nindex = \S+\nsubindex = 1\nencoding = "f32"[^\n]*\nscale = 1.0', cell, text)
    path = folder / "rig.toml"
    path.write_text(text)
    return path, tomllib.loads(text)


class Session:
    """A running bridge, its operator, and what it says."""

    def __init__(self, rig: Path, device: str):
        command = [PROGRAM, rig, "--bus", f"can0=slcan:{device}", "--status", "-", "--no-realtime", "--uncommissioned"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=rig.parent, stdin=pipe, stdout=pipe, stderr=pipe, text=True, bufsize=1)
        self.status, self.lines, self.log = {}, [], []
        self.readers = [threading.Thread(target=self.read_status), threading.Thread(target=self.read_log)]
        for reader in self.readers:
            reader.start()

    def read_status(self):
        for line in self.process.stdout:
            self.lines.append(json.loads(line))
            if "state" in self.lines[-1]:
                self.status = self.lines[-1]

    def read_log(self):
        self.log.extend(self.process.stderr)

    def say(self, command: str):
        print(command, file=self.process.stdin, flush=True)

    def wait_for(self, state: str, again: str | None = None):
        for _ in range(300):
            if self.status and self.status["state"] == state:
                return self.status
            assert self.process.poll() is None, "".join(self.log)
            if again:
                self.say(again)
            time.sleep(0.1)
        raise AssertionError(f"{self.status} is not {state}\n{''.join(self.log)}")

    def end(self) -> int:
        self.process.terminate()
        code = self.process.wait(timeout=30)
        for reader in self.readers:
            reader.join()
        return code


@pytest.fixture
def packed():
    """Whether frames are shared; tests say so by a parameter."""
    return False


@pytest.fixture
def cables():
    """Of the rig; a test of eight says so by a parameter."""
    return 6


@pytest.fixture
def rig(tmp_path, packed, cables):
    return rig_file(tmp_path, packed) if cables == 6 else file_of_eight(tmp_path)


def file_of_eight(folder: Path) -> tuple[Path, dict]:
    text = patient("eight.toml", PATIENT | {"rig": f'"{ROOT}/rigs/eight.toml"'})
    path = folder / "rig.toml"
    path.write_text(text)
    return path, tomllib.loads(text)


@pytest.fixture
def lab(rig):
    return Lab(rig[1])


@pytest.fixture
def session(rig, lab):
    """The bridge, started; the lab is powered first. Tests break things in `lab` before they ask for it."""
    running = []

    def start() -> Session:
        running.append(Session(rig[0], device))
        return running[0]

    with null_modem() as (device, other), lab.powered(other):
        yield start
        for one in running:
            one.process.kill()
            one.end()


def enabled(start) -> Session:
    session = start()
    session.wait_for("Homing")
    session.wait_for("Ready", again="home")
    session.wait_for("Enabled", again="enable")
    return session


def test_start_up_sets_up_every_node_as_the_standards_have_it(rig, lab, session):
    file = rig[1]
    session().wait_for("Homing")
    for drive in lab.drives:
        assert drive.value(0x1016, 1) == file["node"] << 16 | round(1000 * file["heartbeat"]["drive_watchdog"])
        assert drive.value(0x1400, 1) == 0x200 + drive.id and drive.value(0x1400, 2) == 1
        assert drive.value(0x1800, 1) & 0xBFFFFFFF == 0x180 + drive.id and drive.value(0x1800, 2) == 1
        assert drive.mapping(0x1600) == [(0x6040, 0, 2), (0x6071, 0, 2)]
        assert drive.mapping(0x1A00) == [(0x6041, 0, 2), (0x6064, 0, 4), (0x6077, 0, 2)]
        assert drive.value(0x6060) == drive.value(0x6061) == CYCLIC_SYNCHRONOUS_TORQUE
        assert drive.value(0x6072) == round(1000 * drive.entry["torque_limit"] / drive.entry["rated_torque"])
        assert drive.value(0x605A) == 2
        assert (0x6076, 0) in drive.read
        assert drive.states == ["Switch on disabled"] and drive.pull() == 0.0
    for amplifier in lab.amplifiers:
        assert amplifier.value(0x1800, 1) & 0xBFFFFFFF == 0x180 + amplifier.id and amplifier.value(0x1800, 2) == 1
        assert amplifier.mapping(0x1A00) == [(0x6130, 1, 4)]
    for node in lab.nodes:
        assert node.nmt.state == OPERATIONAL
        assert node.value(0x1017) == round(1000 * file["heartbeat"]["period"])
        assert set(node.written) <= set(node.read), "not everything that was written was read back"


def test_the_torques_carry_the_platform(lab, session):
    carries_the_platform(lab, enabled(session))


def test_every_line_of_the_status_conforms_to_its_schema(session):
    schema = json.loads(subprocess.run([PROGRAM, "--status-schema"], capture_output=True, check=True).stdout)
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    assert [name for name, text in described(schema, "status") if not text] == []
    session = enabled(session)
    session.say("goal 9 0 1")
    for _ in range(100):
        if session.status["goal"]:
            break
        time.sleep(0.1)
    session.end()
    messages, cycles = ([line for line in session.lines if ("message" in line) == is_message] for is_message in (True, False))
    assert messages and {line["state"] for line in cycles} >= {"Homing", "Ready", "Enabled"}
    assert [error.message for line in session.lines for error in validator.iter_errors(line)] == []
    for whole in (messages[-1], next(line for line in reversed(cycles) if line["goal"])):
        for part in (whole, whole.get("goal") or {}):
            for name in list(part):
                value = part.pop(name)
                assert not validator.is_valid(whole), f"without {name}"
                part[name] = value
        assert validator.is_valid(whole) and not validator.is_valid(whole | {"unheardOf": 1})


def carries_the_platform(lab, session):
    """The drives pull what the bridge says, and that is the weight."""
    time.sleep(2.0)
    pulls = [drive.pull() for drive in lab.drives]
    # Table I: two equilateral triangles of sides 0.9 m and 0.5 m, 1 m apart, 6 kg. Cables 1, 2 | 3, 4 | 5, 6 share an anchor.
    base = [corner(0.9, angle) for angle in (-60, 60, 180)]
    platform = [corner(0.5, angle) for angle in (-120, 0, 120)]
    ends = [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2), (2, 0)]
    upwards = 0.0
    for pull, (anchor, attachment) in zip(pulls, ends):
        across = math.dist(base[anchor], platform[attachment])
        upwards += pull / math.hypot(across, 1.0)
    assert upwards == pytest.approx(6.0 * 9.81, abs=0.1)
    # Not of the same cycle: two per mille of the rated torque.
    for drive, pull, told in zip(lab.drives, pulls, session.status["tension"]):
        assert pull == pytest.approx(told, abs=0.13)
        # 0x6040 led it up one step after the other, as CiA 402 has it.
        assert drive.states[-4:] == ["Switch on disabled", "Ready to switch on", "Switched on", "Operation enabled"]


def corner(side: float, degrees: float) -> tuple[float, float]:
    """Corner of an equilateral triangle around the origin."""
    radius, angle = side / math.sqrt(3), math.radians(degrees)
    return radius * math.cos(angle), radius * math.sin(angle)


@pytest.mark.parametrize("cables", [8])
def test_eight_cables_carry_their_platform(lab, session):
    """Force and torque of what eight drives pull are the weight, and every cable is within its limits."""
    session = enabled(session)
    time.sleep(2.0)
    pulls = [drive.pull() for drive in lab.drives]
    file = tomllib.loads((ROOT / "rigs/eight.toml").read_text())
    force, torque = [0.0] * 3, [0.0] * 3
    # Torques are whole per mille: half of one for each drive, on arms of less than half a metre.
    rounding = sum(0.0005 * d.entry["rated_torque"] * d.entry["gear"] / d.entry["pulley_radius"] for d in lab.drives)
    for pull, cable in zip(pulls, file["cables"], strict=True):
        assert file["tension"]["min"] < pull < file["tension"]["max"]
        arm = [a - c for a, c in zip(cable["attachment"], file["platform"]["center_of_mass"])]
        way = [a - (h + r) for a, h, r in zip(cable["anchor"], file["home"], arm)]
        pulled = [pull * component / math.hypot(*way) for component in way]
        force = [f + p for f, p in zip(force, pulled)]
        torque = [t + arm[(k + 1) % 3] * pulled[(k + 2) % 3] - arm[(k + 2) % 3] * pulled[(k + 1) % 3] for k, t in enumerate(torque)]
    assert force == pytest.approx([0.0, 0.0, -file["platform"]["mass"] * file["gravity"]], abs=rounding)
    assert torque == pytest.approx([0.0] * 3, abs=0.5 * rounding)
    assert session.status["tension"] == pytest.approx(pulls, abs=0.5)


@pytest.mark.parametrize("packed", [True])
def test_frames_may_be_shared(packed, lab, session):
    """Three drives on a torque frame, with dummies in their mappings, and three cells on an amplifier."""
    session = enabled(session)
    for k, drive in enumerate(lab.drives):
        assert drive.value(0x1400, 1) == 0x201 + 3 * (k // 3)
        assert drive.mapping(0x1600)[k % 3 + 1] == (0x6071, 0, 2)
    assert [amplifier.mapping(0x1A00) for amplifier in lab.amplifiers] == [[(0x7130, k, 2) for k in (1, 2, 3)]] * 2
    carries_the_platform(lab, session)


def test_a_drive_that_aborts_a_setting_stops_the_start(lab, session):
    lab.drives[2].aborts[0x605A, 0] = VALUE_OUT_OF_RANGE
    session = session()
    fault = session.wait_for("Fault")["fault"]
    assert "3" in fault and re.search("605A", fault, re.I) and re.search("06090030", fault), fault
    assert all(drive.states == ["Switch on disabled"] for drive in lab.drives)
    assert session.end() == EXIT_FAULT


def test_a_drive_that_stays_in_its_mode_is_refused_before_any_torque(lab, session):
    lab.drives[4].is_stubborn = True
    session = session()
    # Some drives show their mode only once they are enabled.
    fault = session.wait_for("Fault", again="home")["fault"]
    assert "5" in fault and "mode" in fault, fault
    assert lab.drives[4].value(0x6060) == CYCLIC_SYNCHRONOUS_TORQUE and lab.drives[4].value(0x6061) == 0
    assert all(drive.pull() == 0.0 for drive in lab.drives)
    assert session.end() == EXIT_FAULT


def test_a_drive_that_refuses_the_mode_stops_the_start(lab, session):
    lab.drives[0].aborts[0x6060, 0] = VALUE_OUT_OF_RANGE
    session = session()
    fault = session.wait_for("Fault")["fault"]
    assert re.search("node 1\\b", fault) and re.search("6060", fault), fault
    assert session.end() == EXIT_FAULT


@pytest.mark.parametrize("mishap", ["reset", "power_off"])
def test_a_drive_that_is_lost_ends_the_controllers_tensions(mishap, lab, session):
    session = enabled(session)
    with lab.drives[1].lock:
        getattr(lab.drives[1], mishap)()
    fault = session.wait_for("Fault", again="enable")["fault"]
    assert re.search("(node|cable) 2\\b|drive 2|encoder 2", fault), fault
    assert all(drive.state == "Operation enabled" for k, drive in enumerate(lab.drives) if k != 1)
    assert session.end() == EXIT_FAULT


def test_an_emergency_ends_the_controllers_tensions_and_only_a_reset_leads_on(lab, session):
    session = enabled(session)
    lab.drives[3].fail(0x2310)
    fault = session.wait_for("Fault", again="enable")["fault"]
    assert "4" in fault, fault
    time.sleep(1.0)
    assert lab.drives[3].states[-1] == "Fault", "it was reset, and nobody had asked for it"
    assert lab.drives[3].pull() == 0.0
    session.say("release")
    session.say("reset")
    session.wait_for("Homing")
    session.wait_for("Ready", again="home")
    assert [drive.states[-1] for drive in lab.drives] == ["Operation enabled"] * 6
    assert session.end() == 0


def test_when_the_bridge_is_killed_the_drives_stop_by_themselves(lab, session):
    session = enabled(session)
    assert all(drive.pull() > 0.0 for drive in lab.drives)
    session.process.send_signal(signal.SIGKILL)
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline and any(drive.state != "Fault" for drive in lab.drives):
        time.sleep(0.05)
    for drive in lab.drives:
        assert drive.state == "Fault" and drive.value(0x603F) == HEARTBEAT_LOST and drive.pull() == 0.0


def test_the_data_sheets_of_these_nodes_have_what_the_bridge_uses_and_what_is_missing_is_named(tmp_path):
    path, rig = rig_file(tmp_path, packed=False)
    lab = Lab(rig)

    def check(drive, cell):
        sheets = [(f"{kind}=", tmp_path / f"{kind}.eds", od) for kind, od in (("drives", drive), ("load-cells", cell))]
        for _, sheet, od in sheets:
            canopen.export_od(od, str(sheet))
        options = [word for kind, sheet, _ in sheets for word in ("--eds", f"{kind}{sheet}")]
        found = subprocess.run([PROGRAM, path, "--check", *options], capture_output=True, text=True)
        return found.returncode, found.stdout, found.stderr

    code, said, error = check(lab.drives[0].object_dictionary, lab.amplifiers[0].object_dictionary)
    assert code == 0 and said.count("has all that the bridge uses") == 2, said + error
    assert "of node 1, 2, 3, 4, 5, 6" in said

    poor = lab.drives[1].object_dictionary
    del poor[0x6072]
    poor[0x6060].access_type = "ro"
    poor[0x6077].pdo_mappable = False
    poor[0x6064].data_type = canopen.objectdictionary.datatypes.INTEGER16
    code, said, error = check(poor, lab.amplifiers[0].object_dictionary)
    assert code == 1 and "of 2 data sheets 1 lack what the bridge uses" in error, error
    lacks = [line.strip() for line in said.splitlines() if line.startswith("  0x6")]
    assert lacks == [
        "0x6064:0 (6064:00) has the type 0x0003 (2 bytes), 4 bytes are expected",
        "0x6077:0 (6077:00) cannot be mapped to a PDO that the node sends (PDOMapping, AccessType)",
        "0x6072:0 is not in it",
        "0x6060:0 (6060:00) cannot be written (AccessType = ro)",
    ], said
