"""Six drives and six load cells on a CAN bus, after CiA 301 and CiA 402, with python-can and canopen.

Written against the standards, to be a second opinion on what the bridge sends: nothing here was derived from the project's own
codec or its simulated drives. From the fieldbus file come node numbers, scaling and the load cells' objects only.
"""

import os
import select
import struct
import threading
import time
import tty
from contextlib import contextmanager

import canopen
from canopen.objectdictionary import ODArray, ODRecord, ODVariable, datatypes as types
from canopen.sdo import SdoAbortedError

# Abort codes of CiA 301, table 22.
VALUE_OUT_OF_RANGE = 0x06090030
NOT_MAPPABLE = 0x06040041
MAPPING_TOO_LONG = 0x06040042
DEVICE_STATE = 0x08000022

# Emergency codes of CiA 301, table 26.
HEARTBEAT_LOST = 0x8130
PDO_TOO_SHORT = 0x8210

OPERATIONAL = "OPERATIONAL"
CYCLIC_SYNCHRONOUS_TORQUE = 10
INVALID = 1 << 31  # of a COB-ID: the PDO does not exist
DUMMIES = (types.INTEGER8, types.INTEGER16, types.INTEGER32, types.UNSIGNED8, types.UNSIGNED16, types.UNSIGNED32)


class Node(canopen.LocalNode):
    """What CiA 301 asks of every node: NMT with boot-up, SDO server, SYNC, one PDO each way, heartbeat both ways, EMCY."""

    def __init__(self, number: int, device_type: int, objects: list):
        super().__init__(number, dictionary(number, device_type, objects))
        self.lock = threading.RLock()
        self.is_running = False  # power on
        self.aborts = {}  # (index, subindex) -> abort code: writing fails
        self.written, self.read = [], []  # what the master wrote and read, in its order
        self.received = {}  # COB-ID -> data, waiting for SYNC
        self.heard = {}  # node -> when its heartbeat came
        self.add_write_callback(self.on_write)
        self.add_read_callback(lambda index, subindex, od: self.read.append((index, subindex)))

    def power_on(self, network: canopen.Network):
        network.add_node(self)
        # canopen's own handler would let a heartbeat pass that looks like a second boot-up.
        network.unsubscribe(0x000, self.nmt.on_command)
        network.subscribe(0x000, self.on_nmt)
        network.subscribe(0x080, self.on_sync)
        self.is_running = True
        self.boot()

    def boot(self):
        """Back to the defaults of the profile's communication area, and the boot-up message."""
        for index in [index for index in self.data_store if index < 0x2000]:
            del self.data_store[index]
        self.heard.clear()
        self.nmt.stop_heartbeat()
        self.nmt.state = "INITIALISING"
        self.nmt.state = "PRE-OPERATIONAL"

    def on_nmt(self, _id, data, _time):
        command, number = data[:2]
        with self.lock:
            if self.is_running and number in (0, self.id):
                if command in (129, 130):
                    self.reset()
                else:
                    self.nmt.on_command(_id, data, _time)
                    self.start_process_data()

    def reset(self):
        self.boot()

    def start_process_data(self):
        if not self.value(0x1400, 1) & INVALID:
            self.network.subscribe(self.value(0x1400, 1) & 0x7FF, self.on_process_data)
        if watched := self.watched():
            self.network.subscribe(0x700 + watched[0], self.on_heartbeat)

    def on_process_data(self, identifier, data, _time):
        with self.lock:
            if self.nmt.state == OPERATIONAL and identifier == self.value(0x1400, 1) & 0x7FF:
                self.received[identifier] = bytes(data)

    def on_sync(self, _id, _data, _time):
        with self.lock:
            if self.is_running and self.nmt.state == OPERATIONAL:
                self.take_over()
                self.sample()
                self.transmit()

    def take_over(self):
        """Received PDOs become values at SYNC: transmission type 1."""
        mapping = self.mapping(0x1600)
        for data in self.received.values():
            at = 0
            if len(data) < sum(size for *_, size in mapping):
                self.emcy.send(PDO_TOO_SHORT, 0x10)
                continue
            for index, subindex, size in mapping:
                if index >= 0x2000:  # others are dummies
                    self.data_store.setdefault(index, {})[subindex] = data[at : at + size]
                at += size
        self.received.clear()

    def sample(self):
        """Measures."""

    def transmit(self):
        identifier, kind = self.value(0x1800, 1), self.value(0x1800, 2)
        if not identifier & INVALID and kind == 1:
            data = b"".join(self.get_data(index, subindex) for index, subindex, _ in self.mapping(0x1A00))
            self.network.send_message(identifier & 0x7FF, data)

    def mapping(self, index: int) -> list:
        """Index, subindex and bytes of every object in a PDO."""
        entries = [self.value(index, k) for k in range(1, self.value(index, 0) + 1)]
        return [(entry >> 16, entry >> 8 & 0xFF, (entry & 0xFF) // 8) for entry in entries]

    def on_write(self, index, subindex, od, data):
        self.written.append((index, subindex))
        if (index, subindex) in self.aborts:
            raise SdoAbortedError(self.aborts[index, subindex])
        if index in (0x1600, 0x1A00):
            self.check_mapping(index, subindex, int.from_bytes(data, "little"))
        if index in (0x1400, 0x1800) and subindex == 1:
            before, after = self.value(index, 1), int.from_bytes(data, "little")
            if not (before | after) & INVALID and before != after:
                raise SdoAbortedError(VALUE_OUT_OF_RANGE)  # its identifier may not change while it exists

    def check_mapping(self, index, subindex, value):
        """CiA 301, 7.5.2.36: off, cleared, mapped, counted, on; anything else is refused."""
        if not self.value(index - 0x200, 1) & INVALID:
            raise SdoAbortedError(DEVICE_STATE)
        if subindex == 0:
            bits = sum(self.value(index, k) & 0xFF for k in range(1, value + 1))
            if bits > 64:
                raise SdoAbortedError(MAPPING_TOO_LONG)
        elif self.value(index, 0) != 0:
            raise SdoAbortedError(DEVICE_STATE)
        else:
            mapped = self.object_dictionary.get_variable(value >> 16, value >> 8 & 0xFF)
            is_dummy = value >> 16 in DUMMIES and index == 0x1600
            is_mappable = mapped is not None and (mapped.pdo_mappable or is_dummy)
            if not is_mappable or len(mapped) != value & 0xFF:
                raise SdoAbortedError(NOT_MAPPABLE)

    def watched(self):
        """Node whose heartbeat is consumed, and the time it may be silent, s."""
        value = self.value(0x1016, 1)
        return (value >> 16 & 0x7F, (value & 0xFFFF) / 1000) if value & 0xFFFF else None

    def on_heartbeat(self, identifier, _data, _time):
        with self.lock:
            self.heard[identifier - 0x700] = time.monotonic()

    def power_off(self):
        with self.lock:
            self.is_running = False
            self.nmt.stop_heartbeat()
            self.network.unsubscribe(self.sdo.rx_cobid, self.sdo.on_request)

    def look_at_the_clock(self):
        with self.lock:
            watched = self.watched() if self.is_running else None
            if watched and time.monotonic() - self.heard.get(watched[0], float("inf")) > watched[1]:
                del self.heard[watched[0]]
                self.on_heartbeat_lost()

    def on_heartbeat_lost(self):
        """The profile says what happens."""

    def value(self, index: int, subindex: int = 0) -> int | float:
        return self.object_dictionary.get_variable(index, subindex).decode_raw(self.get_stored(index, subindex))

    def get_stored(self, index, subindex) -> bytes:
        stored = self.data_store.get(index, {}).get(subindex)
        variable = self.object_dictionary.get_variable(index, subindex)
        return variable.encode_raw(variable.default) if stored is None else stored

    def put(self, index: int, value: int | float, subindex: int = 0):
        encoded = self.object_dictionary.get_variable(index, subindex).encode_raw(value)
        self.data_store.setdefault(index, {})[subindex] = encoded


class Drive(Node):
    """CiA 402: the state machine of figure 2, cyclic synchronous torque, and a heartbeat that is missed."""

    def __init__(self, number: int, entry: dict):
        rated = round(1000 * entry["rated_torque"])
        super().__init__(
            number,
            0x00020192,
            [
                (0x603F, types.UNSIGNED16, 0, "ro"),
                (0x6040, types.UNSIGNED16, 0, "rw"),
                (0x6041, types.UNSIGNED16, 0, "ro"),
                (0x605A, types.INTEGER16, 0, "rw"),
                (0x6060, types.INTEGER8, 0, "rw"),
                (0x6061, types.INTEGER8, 0, "ro"),
                (0x6064, types.INTEGER32, 10_000 * number, "ro"),
                (0x6071, types.INTEGER16, 0, "rw"),
                (0x6072, types.UNSIGNED16, 1000, "rw"),
                (0x6076, types.UNSIGNED32, rated, "rw"),
                (0x6077, types.INTEGER16, 0, "ro"),
                (0x6502, types.UNSIGNED32, 1 << (CYCLIC_SYNCHRONOUS_TORQUE - 1), "ro"),
            ],
        )
        self.entry = entry
        self.state = "Switch on disabled"
        self.states = [self.state]
        self.control = 0
        self.is_stubborn = False  # never changes its mode
        self.show()

    # Status word, CiA 402 table 30; bit 4 voltage, bit 9 remote.
    STATUS = {
        "Switch on disabled": 0x240,
        "Ready to switch on": 0x231,
        "Switched on": 0x233,
        "Operation enabled": 0x237,
        "Quick stop active": 0x217,
        "Fault": 0x218,
    }

    def take_over(self):
        super().take_over()
        self.obey(self.value(0x6040))
        self.show()

    def on_write(self, index, subindex, od, data):
        super().on_write(index, subindex, od, data)
        if index == 0x6060:
            mode = int.from_bytes(data, "little", signed=True)
            if mode != 0 and not (mode > 0 and self.value(0x6502) >> (mode - 1) & 1):
                raise SdoAbortedError(VALUE_OUT_OF_RANGE)
            if not self.is_stubborn:
                self.put(0x6061, mode)

    def obey(self, control: int):
        """The commands of CiA 402, table 28."""
        rising, self.control = control & ~self.control, control
        if self.state == "Fault":
            if rising & 0x80:
                self.put(0x603F, 0)
                self.emcy.reset()
                self.enter("Switch on disabled")
        elif not control & 0x02:
            self.enter("Switch on disabled")  # disable voltage
        elif not control & 0x04:
            # Quick stop. Option 2: slow down, which takes no time at rest, then switch on disabled.
            is_moving = self.state == "Operation enabled" and self.value(0x605A) in (5, 6, 7, 8)
            self.enter("Quick stop active" if is_moving else "Switch on disabled")
        elif not control & 0x01:
            self.enter("Ready to switch on")  # shutdown; from Switch on disabled as well
        elif self.state in ("Ready to switch on", "Switched on", "Operation enabled"):
            self.enter("Operation enabled" if control & 0x08 else "Switched on")

    def enter(self, state: str):
        if state != self.state:
            self.state = state
            self.states.append(state)

    def show(self):
        is_pulling = self.state == "Operation enabled" and self.value(0x6061) == CYCLIC_SYNCHRONOUS_TORQUE
        limit = self.value(0x6072)
        self.put(0x6077, max(-limit, min(limit, self.value(0x6071))) if is_pulling else 0)
        self.put(0x6041, self.STATUS[self.state])

    def fail(self, code: int):
        """A fault reaction that takes no time, and its emergency message."""
        with self.lock:
            self.enter("Fault")
            self.put(0x603F, code)
            self.show()
            self.emcy.send(code, 1)

    def on_heartbeat_lost(self):
        self.fail(HEARTBEAT_LOST)

    def reset(self):
        self.put(0x6060, 0)
        self.put(0x6061, 0)
        self.put(0x6040, 0)
        self.put(0x6071, 0)
        self.control = 0
        if self.state != "Fault":
            self.enter("Switch on disabled")
        self.show()
        self.boot()

    def pull(self) -> float:
        """Tension of the cable, N: torque at the motor in per mille of the rated one, through gear and pulley."""
        entry = self.entry
        torque = self.value(0x6077) / 1000 * entry["rated_torque"]
        return entry["direction"] * torque * entry["gear"] / entry["pulley_radius"]


class Amplifier(Node):
    """Load cells of one node, each in the object that the fieldbus file names."""

    TYPES = {"i16": types.INTEGER16, "i32": types.INTEGER32, "f32": types.REAL32}

    def __init__(self, number: int, cells: list):
        """`cells`: entry of the fieldbus file, and the drive that pulls at the same cable."""
        self.cells = cells
        objects = [(cell["index"], self.TYPES[cell["encoding"]], 0, "ro", cell["subindex"]) for cell, _ in cells]
        super().__init__(number, 0x00020194, objects)

    def sample(self):
        for cell, drive in self.cells:
            reading = (drive.pull() - cell["offset"]) / cell["scale"]
            self.put(cell["index"], reading if cell["encoding"] == "f32" else round(reading), cell["subindex"])


def dictionary(number: int, device_type: int, objects: list) -> canopen.ObjectDictionary:
    """Object dictionary of a node: what CiA 301 has, with its default identifiers, and `objects`."""
    od = canopen.ObjectDictionary()

    def variable(index, kind, default, access="rw", subindex=0):
        entry = ODVariable(f"{index:04X}:{subindex:02X}", index, subindex)
        entry.data_type, entry.access_type, entry.default = kind, access, default
        entry.pdo_mappable = index >= 0x2000
        return entry

    def record(index, *members):
        entry = ODRecord(f"{index:04X}", index)
        for member in members:
            entry.add_member(variable(index, *member))
        od.add_object(entry)

    od.add_object(variable(0x1000, types.UNSIGNED32, device_type, "ro"))
    od.add_object(variable(0x1001, types.UNSIGNED8, 0, "ro"))
    watched = ODArray("1016", 0x1016)
    watched.add_member(variable(0x1016, types.UNSIGNED8, 1, "ro"))
    watched.add_member(variable(0x1016, types.UNSIGNED32, 0, "rw", 1))
    od.add_object(watched)
    od.add_object(variable(0x1017, types.UNSIGNED16, 0))
    record(0x1018, (types.UNSIGNED8, 1, "ro"), (types.UNSIGNED32, 0, "ro", 1))
    for communication, mapping, identifier in ((0x1400, 0x1600, 0x200), (0x1800, 0x1A00, 0x180)):
        record(
            communication,
            (types.UNSIGNED8, 2, "ro"),
            (types.UNSIGNED32, identifier + number, "rw", 1),
            (types.UNSIGNED8, 255, "rw", 2),
        )
        record(mapping, (types.UNSIGNED8, 0), *((types.UNSIGNED32, 0, "rw", k) for k in range(1, 9)))
    for index in DUMMIES:
        od.add_object(variable(index, index, 0))
    for index, kind, default, access, *subindex in objects:
        if not any(subindex):
            od.add_object(variable(index, kind, default, access))
        elif index in od:
            od[index].add_member(variable(index, kind, default, access, *subindex))
        else:
            record(index, (types.UNSIGNED8, 8, "ro"), (kind, default, access, *subindex))
    return od


class Lab:
    """The nodes of a fieldbus file whose platform stands on its stand: no cable moves, each load cell feels its motor."""

    def __init__(self, rig: dict):
        self.drives = [Drive(entry["node"], entry) for entry in rig["drives"]]
        cells = list(zip(rig["load_cells"], self.drives))
        numbers = sorted({cell["node"] for cell, _ in cells})
        self.amplifiers = [Amplifier(n, [pair for pair in cells if pair[0]["node"] == n]) for n in numbers]
        self.nodes = [*self.drives, *self.amplifiers]

    @contextmanager
    def powered(self, device: str):
        """On the bus behind this serial device."""
        network, end = canopen.Network(), threading.Event()
        network.connect(interface="slcan", channel=device, bitrate=1_000_000, sleep_after_open=0)

        def clock():
            while not end.wait(0.005):
                for node in self.nodes:
                    node.look_at_the_clock()

        watch = threading.Thread(target=clock)
        watch.start()
        try:
            for node in self.nodes:
                node.power_on(network)
            yield self
        finally:
            end.set()
            watch.join()
            for node in self.nodes:
                node.nmt.stop_heartbeat()
            network.disconnect()


@contextmanager
def null_modem():
    """Two serial devices, joined. They stay when a program that has one of them open dies."""
    ends = [os.openpty(), os.openpty()]
    for _, device in ends:
        tty.setraw(device)
    (a, _), (b, _) = ends
    stop, stopper = os.pipe()

    def carry():
        while stop not in (ready := select.select([a, b, stop], [], [])[0]):
            for master in ready:
                os.write(b if master == a else a, os.read(master, 4096))

    carrier = threading.Thread(target=carry)
    carrier.start()
    try:
        yield os.ttyname(ends[0][1]), os.ttyname(ends[1][1])
    finally:
        os.write(stopper, b"x")
        carrier.join()
        for descriptor in (*ends[0], *ends[1], stop, stopper):
            os.close(descriptor)
