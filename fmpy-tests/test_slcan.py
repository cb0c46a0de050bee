"""Our slcan against python-can's: frames through a pseudo-terminal, on which tests/programs/slcan_peer.rs sends all of them back."""

import re
import subprocess
from pathlib import Path

import can
import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def bus():
    command = "cargo test --quiet --workspace --test slcan_peer echo_until_hang_up -- --ignored --exact --nocapture"
    with subprocess.Popen(command.split(), cwd=ROOT, stdout=subprocess.PIPE, text=True) as peer:
        device = next(found[1] for line in peer.stdout if (found := re.search(r"device (\S+)", line)))
        with can.Bus(interface="slcan", channel=device, bitrate=1_000_000, sleep_after_open=0) as bus:
            yield bus
        peer.stdout.read()
    assert peer.returncode == 0, "the hang-up was not seen as a link removed"


def numbered(k: int) -> can.Message:
    """A frame of every length in turn, some of them remote."""
    length, remote = k % 9, k % 50 == 0
    data = None if remote else bytes((k * 7 + i) % 256 for i in range(length))
    return can.Message(arbitration_id=k % 0x800, is_extended_id=False, is_remote_frame=remote, dlc=length, data=data)


def test_two_thousand_frames_come_back_as_they_were_sent(bus):
    for first in range(0, 2000, 20):
        sent = [numbered(k) for k in range(first, first + 20)]
        for message in sent:
            bus.send(message)
        for message in sent:
            back = bus.recv(timeout=20)
            assert back is not None and back.equals(message, timestamp_delta=None, check_channel=False), back


def test_a_frame_with_a_29_bit_identifier_is_passed_over(bus):
    bus.send(can.Message(arbitration_id=0x181, is_extended_id=True, data=[1]))
    bus.send(numbered(1))
    assert bus.recv(timeout=20).equals(numbered(1), timestamp_delta=None, check_channel=False)
