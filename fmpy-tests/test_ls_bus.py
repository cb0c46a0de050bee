"""Controller and rig as nodes of FMI-LS-BUS, joined by an importer of our own (bus_importer.py)."""

import struct
import subprocess
import zipfile
from xml.etree import ElementTree

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from bus_importer import CONFIGURATION, FORMAT_ERROR, TRANSMIT, Bus, Direct, Late, Node, Pair, Silent, operation, operations
from robot_fmu import FMU_FOLDER

ROOT = FMU_FOLDER.parent.parent
#: s, a quarter of a period of the example
STEP = 1e-3
GOAL = (0.1, 0.1, 1.0)
MIME_TYPE = 'application/org.fmi-standard.fmi-ls-bus.can; version="1.0.0"'


def packed(folder, fieldbus):
    """The folder of the FMUs of a fieldbus file, as the program packs them."""
    command = [ROOT / "target/debug/cable-robot", "fmu", "--can", ROOT / "rigs/can" / fieldbus, "--output", folder, "--library", FMU_FOLDER]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "fmi3"


@pytest.fixture(scope="module")
def akd(tmp_path_factory):
    return packed(tmp_path_factory.mktemp("akd"), "akd.toml")


@pytest.fixture(scope="module")
def eight(tmp_path_factory):
    return packed(tmp_path_factory.mktemp("eight"), "eight.toml")


@pytest.mark.parametrize("model", ["Controller", "Rig"])
def test_description_manifest_and_terminals_are_those_of_the_standard(akd, model):
    path = akd / f"CableRobotCan{model}.fmu"
    assert validate_fmu(str(path)) == []
    # `cargo fmu build` packs the same for the example.
    assert path.read_bytes() == (FMU_FOLDER / "fmi3" / path.name).read_bytes()
    with zipfile.ZipFile(path) as archive:
        manifest = ElementTree.fromstring(archive.read("extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml"))
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
    namespace = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert manifest.get(f"{namespace}fmi-ls-name") == "org.fmi-standard.fmi-ls-bus"
    assert (manifest.get(f"{namespace}fmi-ls-version"), manifest.get("isBusSimulationFMU")) == ("1.0.0", "false")
    assert description.find("CoSimulation").get("hasEventMode") == "true"
    by_reference = {variable.get("valueReference"): variable for variable in description.find("ModelVariables")}
    with Node(path) as node:
        assert set(node.buses["can0"]) == {"Rx_Data", "Tx_Data", "Rx_Clock", "Tx_Clock"}
        for direction, causality in (("Rx", "input"), ("Tx", "output")):
            data, clock = (by_reference[str(node.buses["can0"][f"{direction}_{member}"])] for member in ("Data", "Clock"))
            assert (data.tag, data.get("causality"), data.get("mimeType"), data.get("clocks")) == ("Binary", causality, MIME_TYPE, clock.get("valueReference"))
            assert (clock.tag, clock.get("causality"), clock.get("intervalVariability")) == ("Clock", causality, "triggered")


def test_the_first_event_configures_the_bus(akd):
    with Pair(akd, STEP) as pair:
        for sent in pair.trace[0][1]:
            rate, behaviour = operations(sent)
            assert rate == (CONFIGURATION, struct.pack("<BI", 1, 1_000_000))
            assert behaviour == (CONFIGURATION, bytes([4, 1]))


def test_a_whole_start_has_the_frames_of_bridge_and_rig_themselves(akd):
    """Bit for bit with the library's own state machines, which know nothing of FMI; and the platform gets to its goal."""
    example = subprocess.run([ROOT / "target/debug/examples/start_on_a_bus"], check=True, capture_output=True, text=True)
    wanted = [tuple(line.split()) for line in example.stdout.splitlines()]
    states = []
    with Pair(akd, STEP) as pair:
        pair.controller["home"] = True
        for k in range(1, 24_001):
            state = pair.state
            if not states or states[-1] != state:
                states.append(state)
            pair.controller["enable"] = state in ("Ready", "Enabled")
            if k == 20_000:
                pair.go_to(*GOAL)
            pair.step()
        assert states == ["Configuring", "Homing", "TakingUpSlack", "Ready", "Enabled"]
        assert pair.frames() == [(int(step), sender, text) for step, sender, text in wanted]
        assert len(wanted) > 100_000
        assert [text for text in pair.controller.messages + pair.rig.messages if "operation" in text] == []
        pair.run(8.0)
        assert pair.rig.pose()[:3] == pytest.approx(GOAL, abs=2e-3)
        assert pair.controller.pose()[:3] == pytest.approx(pair.rig.pose()[:3], abs=1e-4)
        assert not any(pair.rig[f"slack[{cable}]"] for cable in range(1, 7))
        assert pair.rig["supportNumber"] == 2
        tensions = [[node[f"motorTension[{cable}]"] for cable in range(1, 7)] for node in pair.nodes]
        # What a drive pulls is whole per mille of its rated torque, 0.04 N.
        assert tensions[1] == pytest.approx(tensions[0], abs=0.05)


def test_through_a_bus_that_takes_time_arbitrates_and_confirms(akd):
    line = Bus()
    with Pair(akd, STEP / 2, line, notifications=True) as pair:
        assert pair.start()[-1] == "Enabled"
        pair.run(1.0)
        pair.go_to(*GOAL)
        pair.run(8.0)
        assert pair.rig.pose()[:3] == pytest.approx(GOAL, abs=2e-3)
        assert pair.state == "Enabled" and pair.controller["fault"] == ""
        assert line.rates == [1_000_000, 1_000_000] and line.carried > 50_000


@pytest.mark.parametrize("mishap", ["lost", "late"])
def test_frames_that_are_lost_or_late_lead_to_the_safe_state(akd, mishap):
    with Pair(akd, STEP) as pair:
        pair.start()
        pair.run(1.0)
        height = pair.rig["pose.z"]
        now = pair.count * STEP
        pair.line = Silent() if mishap == "lost" else Late(now + 0.03)
        pair.run(0.03)
        pair.line = Direct()
        assert pair.controller["fault"] == "the encoder of cable 1 is silent"
        assert pair.run_until("Fault", 1.0)[-1] == "Fault"
        pair.run(2.0)
        # Held by the safe output, and enable alone brings nothing back.
        assert pair.state == "Fault" and pair.rig["supportNumber"] == 2
        assert pair.rig["pose.z"] == pytest.approx(height, abs=0.05)
        assert any("the encoder of cable 1 is silent" in text for text in pair.controller.messages)
        pair.controller["enable"] = pair.controller["home"] = False
        pair.controller["reset"] = True
        pair.run_until("Homing", 30.0)
        assert pair.controller["fault"] == ""


def test_a_button_that_is_let_go_leads_to_the_safe_state(akd):
    with Pair(akd, STEP) as pair:
        pair.start()
        pair.controller["enable"] = False
        # At once, not when the enable expires.
        pair.run(4 * STEP)
        assert pair.state == "Stopping"
        pair.run_until("Safe", 1.0)
        assert pair.controller["fault"] == "" and pair.rig["supportNumber"] == 2


def test_eight_cables_start_as_well(eight):
    with Pair(eight, STEP) as pair:
        assert pair.start()[-1] == "Enabled"
        pair.run(1.0)
        assert pair.state == "Enabled"
        assert pair.rig["motorTension[8]"] > 0.0


def test_two_buses_are_two_terminals(tmp_path):
    drives, cells = (ROOT / "rigs/can/akd.toml").read_text().split("[[load_cells]]", 1)
    drives = drives.replace('rig = "lab.toml"', f'rig = "{ROOT}/rigs/can/lab.toml"')
    second = '[[buses]]\nname = "can1"\nbit_rate = 500e3\n\n[heartbeat]'
    (tmp_path / "two.toml").write_text(drives.replace("[heartbeat]", second) + "[[load_cells]]" + cells.replace('"can0"', '"can1"'))
    with Pair(packed(tmp_path, tmp_path / "two.toml"), STEP) as pair:
        assert list(pair.controller.buses) == list(pair.rig.buses) == ["can0", "can1"]
        rates = [operations(sent)[0][1][1:] for _, both in pair.trace[:2] for sent in both]
        assert rates == [struct.pack("<I", rate) for rate in (1_000_000, 1_000_000, 500_000, 500_000)]
        assert pair.start()[-1] == "Enabled"


HOSTILE = {
    b"\x10\0\0": "3 bytes are left",
    operation(0x99, b"abc"): "operation code 0x99",
    struct.pack("<II", TRANSMIT, 4_000_000_000) + b"x" * 20: "its length is 4000000000",
    operation(TRANSMIT, struct.pack("<IBBH", 1, 7, 0, 0)): "ide is 7",
    operation(TRANSMIT, struct.pack("<IBBH", 1, 0, 2, 0)): "rtr is 2",
    operation(TRANSMIT, struct.pack("<IBBH", 0x800, 0, 0, 0)): "its identifier is 0x800",
    operation(TRANSMIT, struct.pack("<IBBH", 1, 0, 0, 9) + b"x" * 9): "9 bytes of data",
}


@pytest.mark.parametrize("model", ["Controller", "Rig"])
@pytest.mark.parametrize("data", HOSTILE)
def test_what_is_no_operation_is_answered_with_format_error_and_a_message(akd, model, data):
    with Node(akd / f"CableRobotCan{model}.fmu") as node:
        node.initialize()
        node.send("can0")
        node.receive("can0", data)
        node.fmu.updateDiscreteStates()
        node.fmu.enterStepMode()
        assert any(HOSTILE[data] in text and text.startswith("can0: ") for text in node.messages), node.messages
        assert node.step(STEP)
        node.fmu.enterEventMode()
        answers = [content for code, content in operations(node.send("can0")) if code == FORMAT_ERROR]
        assert answers == [struct.pack("<H", len(data)) + data]


def test_what_is_evaluated_within_an_event_is_still_to_be_sent(akd):
    with Node(akd / "CableRobotCanController.fmu") as node:
        node.initialize()
        node.fmu.fmi3EvaluateDiscreteStates(node.fmu.component)
        assert [code for code, _ in operations(node.send("can0"))] == [CONFIGURATION, CONFIGURATION]


def refused(node, call, *words):
    with pytest.raises(FMICallException):
        call()
    assert all(word in node.messages[-1] for word in words), node.messages[-1]


def test_what_is_out_of_order_is_refused_and_named(akd):
    path = akd / "CableRobotCanController.fmu"

    def fresh():
        node = Node(path)
        node.initialize()
        return node, node.buses["can0"]

    with Node(path) as node:
        refused(node, lambda: node.__setitem__("org.fmi_standard.fmi_ls_bus.Can_BusNotifications", True), "Configuration Mode")
    node, bus = fresh()
    with node:
        refused(node, lambda: node.fmu.setBinary([bus["Rx_Data"]], [b"x"]), "can0.Rx_Data", "its clock does not tick")
    node, bus = fresh()
    with node:
        refused(node, lambda: node.fmu.setClock([bus["Tx_Clock"]], [True]), "can0.Tx_Clock", "it is an output")
    node, bus = fresh()
    with node:
        node.fmu.setClock([bus["Rx_Clock"]], [True])
        refused(node, lambda: node.fmu.setBinary([bus["Rx_Data"]], [b"x" * 30_000]), "30000", "24576")
    node, bus = fresh()
    with node:
        node.fmu.updateDiscreteStates()
        refused(node, lambda: node.fmu.getBinary([bus["Tx_Data"]]), "can0.Tx_Data", "its clock does not tick")
    node, bus = fresh()
    with node:
        refused(node, lambda: node.fmu.getFMUState(), "fmi3GetFMUState", "no saved states")
    node, bus = fresh()
    with node:
        node.fmu.enterStepMode()
        refused(node, lambda: node.fmu.doStep(0.0, 0.1), "communicationStepSize = 0.1", "at most 0.064")
    with pytest.raises(Exception):
        from fmpy import extract, instantiate_fmu, read_model_description

        instantiate_fmu(extract(str(path)), read_model_description(str(path)), fmi_type="CoSimulation", event_mode_used=False)


def test_a_reset_is_a_new_power_on(akd):
    with Pair(akd, STEP) as pair:
        pair.run(0.5)
        first = pair.frames()
        for node in pair.nodes:
            node.fmu.reset()
            node.time = 0.0
            node.initialize()
        pair.trace, pair.count = [], 0
        pair._exchange()
        pair.run(0.5)
        assert pair.frames() == first and len(first) > 100


def test_a_fieldbus_file_that_is_refused_names_the_field(tmp_path):
    text = (ROOT / "rigs/can/akd.toml").read_text().replace('rig = "lab.toml"', f'rig = "{ROOT}/rigs/can/lab.toml"')
    for old, new, words in [
        ("rate = 250.0", "rate = -1.0", ["rate", "-1"]),
        ("forceLoop = true", "forceLop = true", ["controller.parameters.forceLop", "forceLoop"]),
        ('poseSource = "CableLengths"', 'poseSource = "Cables"', ["controller.parameters.poseSource", "Cables", "CableLengths"]),
    ]:
        (tmp_path / "bad.toml").write_text(text.replace(old, new))
        command = [ROOT / "target/debug/cable-robot", "fmu", "--can", tmp_path / "bad.toml", "--output", tmp_path, "--library", FMU_FOLDER]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 1 and all(word in done.stderr for word in ["bad.toml", *words]), done.stderr
