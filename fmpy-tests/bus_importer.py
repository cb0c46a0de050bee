"""An importer for nodes of FMI-LS-BUS (CAN) on fmpy's raw calls: two nodes joined directly, or by a bus that takes time."""

import shutil
import struct
from xml.etree import ElementTree

from fmpy import extract, instantiate_fmu, read_model_description

FORMAT_ERROR, TRANSMIT, CONFIRM, CONFIGURATION = 0x01, 0x10, 0x20, 0x40
CAN_BAUDRATE = 1
NOTIFICATIONS = "org.fmi_standard.fmi_ls_bus.Can_BusNotifications"
STATE = {1: "Configuring", 2: "Homing", 3: "TakingUpSlack", 4: "Ready", 5: "Enabled", 6: "Stopping", 7: "Safe", 8: "Fault", 9: "Lowering"}


def operation(code, content=b""):
    """An operation of the standard as bytes."""
    return struct.pack("<II", code, 8 + len(content)) + content


def operations(data):
    """(code, content) of each operation in the bytes of a binary variable."""
    found = []
    while data:
        code, length = struct.unpack_from("<II", data)
        assert 8 <= length <= len(data)
        found.append((code, data[8:length]))
        data = data[length:]
    return found


def frame(content):
    """The content of a Transmit operation as candump would write it."""
    identifier, ide, rtr, length = struct.unpack_from("<IBBH", content)
    assert (ide, rtr) == (0, 0) and len(content) == 8 + length <= 16
    return f"{identifier:03X}#{content[8:].hex().upper()}"


class Node:
    """An FMU with terminals of FMI-LS-BUS; variables by name, messages as text."""

    def __init__(self, path, notifications=False, logging=True):
        self.description = read_model_description(str(path))
        self.folder = extract(str(path))
        self.messages = []
        self.fmu = instantiate_fmu(
            self.folder, self.description, fmi_type="CoSimulation", event_mode_used=True, early_return_allowed=False, debug_logging=logging,
            logger=lambda _environment, _status, _category, text: self.messages.append(text.decode()),
        )
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.buses = self._terminals()
        if notifications:
            self.fmu.enterConfigurationMode()
            self[NOTIFICATIONS] = True
            self.fmu.exitConfigurationMode()
        self.time = 0.0

    def _terminals(self):
        """Value references by bus and member, from the terminals and not from names of variables."""
        root = ElementTree.parse(f"{self.folder}/terminalsAndIcons/terminalsAndIcons.xml").getroot()
        kind, rule = "org.fmi-ls-bus.network-terminal", "org.fmi-ls-bus.transceiver"
        buses = [terminal for terminal in root.iter("Terminal") if (terminal.get("terminalKind"), terminal.get("matchingRule")) == (kind, rule)]
        return {
            bus.get("name"): {member.get("memberName"): self.variables[member.get("variableName")].valueReference for member in bus}
            for bus in buses
        }

    def _access(self, action, name):
        variable = self.variables[name]
        kind = "Int64" if variable.type == "Enumeration" else variable.type
        return getattr(self.fmu, action + kind), [variable.valueReference]

    def __getitem__(self, name):
        call, reference = self._access("get", name)
        return call(reference)[0]

    def __setitem__(self, name, value):
        call, reference = self._access("set", name)
        call(reference, [value])

    def pose(self, name="pose"):
        return [self[f"{name}.{component}"] for component in ("x", "y", "z", "roll", "pitch", "yaw")]

    def initialize(self):
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, length):
        """Whether there is something to send. A triggered clock ticks at communication points only."""
        event, terminate, early, self.time = self.fmu.doStep(self.time, length)
        assert not terminate and not early
        return event

    def send(self, bus):
        """What it sends to the bus in this event."""
        members = self.buses[bus]
        if not self.fmu.getClock([members["Tx_Clock"]])[0]:
            return b""
        data = self.fmu.getBinary([members["Tx_Data"]])[0]
        assert not self.fmu.getClock([members["Tx_Clock"]])[0], "a clock ticks once"
        return data or b""

    def receive(self, bus, data):
        if data:
            members = self.buses[bus]
            self.fmu.setClock([members["Rx_Clock"]], [True])
            self.fmu.setBinary([members["Rx_Data"]], [data])

    def close(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Direct:
    """What one node sends the other has at once."""

    def pass_on(self, _time, sent):
        return list(reversed(sent))


class Silent:
    """Nothing passes."""

    def pass_on(self, _time, sent):
        return [b""] * len(sent)


class Late:
    """All that is sent comes so much later, at once."""

    def __init__(self, until):
        self.until, self.waiting = until, [b"", b""]

    def pass_on(self, time, sent):
        self.waiting = [waiting + data for waiting, data in zip(self.waiting, sent)]
        if time < self.until:
            return [b"", b""]
        passed, self.waiting = list(reversed(self.waiting)), [b"", b""]
        return passed


class Bus:
    """A bus simulation of two nodes: the lowest identifier first, each frame as long as its bits take, and confirmed."""

    def __init__(self):
        self.rates, self.queues, self.free, self.carried = [None, None], [[], []], 0.0, 0
        self.identifiers = []

    def pass_on(self, time, sent):
        for node, data in enumerate(sent):
            for code, content in operations(data):
                if code == CONFIGURATION and content[0] == CAN_BAUDRATE:
                    self.rates[node] = struct.unpack_from("<I", content, 1)[0]
                elif code == TRANSMIT:
                    self.queues[node].append((time, content))
        received = [b"", b""]
        while (chosen := self._arbitrate(time)) is not None:
            node, content = chosen
            received[1 - node] += operation(TRANSMIT, content)
            received[node] += operation(CONFIRM, content[:4])
        return received

    def _arbitrate(self, time):
        """The next frame that is through by now."""
        waiting = [(queue[0][1][:4][::-1], node) for node, queue in enumerate(self.queues) if queue]
        if not waiting:
            return None
        _, node = min(waiting)
        asked, content = self.queues[node][0]
        assert self.rates[0] == self.rates[1] and self.rates[0]
        bits = 47 + 8 * (len(content) - 8)
        done = max(self.free, asked) + bits / self.rates[0]
        if done > time:
            return None
        self.queues[node].pop(0)
        self.free, self.carried = done, self.carried + 1
        return node, content


class Pair:
    """Controller and rig, on their buses; a line with a memory is for one bus."""

    def __init__(self, folder, step, line=None, **options):
        self.controller, self.rig = (Node(folder / f"CableRobotCan{name}.fmu", **options) for name in ("Controller", "Rig"))
        self.nodes, self.length, self.line = [self.controller, self.rig], step, line or Direct()
        self.trace, self.count = [], 0
        for node in self.nodes:
            node.initialize()
        self._exchange()

    def step(self):
        self.count += 1
        if any([node.step(self.length) for node in self.nodes]) or not isinstance(self.line, Direct):
            for node in self.nodes:
                node.fmu.enterEventMode()
            self._exchange()

    def _exchange(self):
        """One event of all, which are in Event Mode."""
        for bus in self.controller.buses:
            sent = [node.send(bus) for node in self.nodes]
            self.trace.append((self.count, sent))
            for node, data in zip(self.nodes, self.line.pass_on(self.count * self.length, sent)):
                node.receive(bus, data)
        for node in self.nodes:
            needs_update, *_ = node.fmu.updateDiscreteStates()
            assert not needs_update
            node.fmu.enterStepMode()

    @property
    def state(self):
        return STATE[self.controller["state"]]

    def run(self, seconds):
        for _ in range(round(seconds / self.length)):
            self.step()

    def run_until(self, state, seconds):
        """Steps until the bridge is in this state; the states on the way."""
        seen = [self.state]
        for _ in range(round(seconds / self.length)):
            if self.state == state:
                return seen
            self.step()
            if self.state != seen[-1]:
                seen.append(self.state)
        raise AssertionError(f"{seen}, fault: {self.controller['fault']}")

    def start(self):
        """From power-on until the controller pulls; the states on the way."""
        self.controller["home"] = True
        seen = self.run_until("Ready", 30.0)
        self.controller["enable"] = True
        return seen + self.run_until("Enabled", 1.0)[1:]

    def go_to(self, x, y, z):
        for name, value in zip("xyz", (x, y, z)):
            self.controller[f"goalPose.{name}"] = value

    def frames(self):
        """(step, sender, frame) of all that was sent."""
        return [
            (step, sender, frame(content))
            for step, sent in self.trace
            for sender, data in (("rig", sent[1]), ("controller", sent[0]))
            for code, content in operations(data)
            if code == TRANSMIT
        ]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for node in self.nodes:
            node.close()
