"""docs/orbit.md once more, from its formulas: tensions of the full inverse dynamics, and a law written here on the packed plant."""

import re
from pathlib import Path

import numpy as np
import pytest

import python_robot
from robot_fmu import Slave, cable_names, fmu_path, pose_names

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "orbit.md").read_text()
CENTRE = np.array([0.0, 0.0, 1.0])
# The circle of the page.
RADIUS, RATE, START, TURNS = 0.4, 2.75, 2.5, 3
TURN = 2 * np.pi / RATE
STOP = START + TURNS * TURN
H = 1e-3


def printed(pattern):
    return float(re.search(pattern, PAGE)[1])


def ramp(t, begin, state, to):
    """b, b', b'' of (O3), or of a stop: the polynomial of degree 5 from a state to rest, by its six conditions."""
    powers = np.arange(6)
    rows = lambda s: [s**powers, powers * s ** np.maximum(powers - 1, 0), powers * (powers - 1) * s ** np.maximum(powers - 2, 0)]
    scale = START ** np.arange(3)
    wanted = np.concatenate([np.array(state) * scale, [to, 0, 0]])
    polynomial = np.polynomial.Polynomial(np.linalg.solve(np.array(rows(0.0) + rows(1.0)), wanted))
    s = np.clip((t - begin) / START, 0, 1)
    return [derivative(s) / k for derivative, k in zip([polynomial, polynomial.deriv(), polynomial.deriv(2)], scale)]


def motion(t, stop=STOP):
    """Place, velocity, acceleration of (O2) in the plane, as complex numbers."""
    t = np.asarray(t, float)
    up = ramp(t, 0.0, [0, 0, 0], 1.0)
    down = ramp(t, stop, [float(b) for b in ramp(np.float64(stop), 0.0, [0, 0, 0], 1.0)], 0.0)
    b, db, ddb = (np.where(t < stop, x, y) for x, y in zip(up, down))
    e = RADIUS * np.exp(1j * RATE * (t - START))
    w = 1j * RATE
    return b * e, (db + w * b) * e, (ddb + 2 * w * db + w * w * b) * e


def tensions(place, acceleration):
    position = CENTRE + [place.real, place.imag, 0]
    force = python_robot.M * (np.array([acceleration.real, acceleration.imag, 0]) - [0, 0, python_robot.G])
    return np.linalg.solve(python_robot.wrench_matrix(position, np.eye(3)), np.concatenate([force, np.zeros(3)]))


def smallest(times, stop=STOP):
    place, _, acceleration = motion(times, stop)
    return min(tensions(p, a).min() for p, a in zip(place, acceleration))


def test_the_tensions_are_those_of_the_page():
    rest = tensions(0.4j, 0j).min()
    assert rest == pytest.approx(printed(r"at rest at \(0, 0.4, 1\) \| (-[\d.]+) N"), abs=1e-3)
    whole = smallest(np.linspace(0, STOP + START, 8001))
    assert whole == pytest.approx(printed(r"smallest tension on the way: ([\d.]+) N"), abs=1e-3)


def test_every_stop_keeps_what_is_proved():
    proved = printed(r"every tension between ([\d.]+) and")
    stops = [smallest(np.linspace(s, s + START, 120), s) for s in START + TURN * np.arange(24) / 24]
    early = [smallest(np.linspace(s, s + START, 120), s) for s in START - TURN * np.arange(1, 25) / 24]
    print(min(stops), min(early))
    assert min(stops + early) >= proved > min(stops + early) - 0.2


def run(plant, push):
    """The law on the plant, with its true state: the smallest tension commanded, and how far from the centre it ends, m."""
    least, gain = np.inf, 3.0
    steps = round((STOP + START + 2) / H)
    place, velocity, _ = motion(H * (np.arange(steps) + 0.5))
    _, edges, _ = motion(H * np.arange(steps + 1))
    acceleration = np.diff(edges) / H
    vector = lambda z: np.array([z.real, z.imag, 0])
    for k in range(steps):
        pose = plant.get(pose_names("encoderPose"))
        rates = plant.get([f"velocity.{axis}" for axis in "xyz"])
        # For the middle of the step, as the platform goes on.
        error = pose[:3] + 0.5 * H * rates - CENTRE - vector(place[k])
        rate_error = rates + 0.5 * H * vector(acceleration[k]) - vector(velocity[k])
        commanded = vector(acceleration[k]) - gain * rate_error - gain * (rate_error + gain * error)
        force = python_robot.M * (commanded - [0, 0, python_robot.G])
        matrix = python_robot.wrench_matrix(pose[:3], python_robot.rotation(*pose[3:]))
        omega = plant.get([f"angularVelocity.{axis}" for axis in "xyz"])
        torque = python_robot.INERTIA @ (-2 * gain * omega - gain * gain * pose[3:])
        pull = np.linalg.solve(matrix, np.concatenate([force, torque]))
        least = min(least, pull.min())
        plant.set(cable_names("motorTension"), pull)
        plant.set([f"disturbanceForce.{axis}" for axis in "xyz"], push(k * H))
        plant.step(H, k * H)
    return least, np.linalg.norm(plant.get(pose_names("encoderPose"))[:3] - CENTRE)


def started(version):
    plant = Slave(fmu_path(version, "CableRobotPlant"))
    plant.set(cable_names("motorTension"), python_robot.static_tensions(CENTRE))
    plant.initialize()
    return plant


def test_a_law_written_here_goes_round_outside_on_the_packed_plant(version):
    with started(version) as plant:
        least, away = run(plant, lambda _: np.zeros(3))
    print(least, away)
    assert least > 0.9 and abs(least - printed(r"smallest tension on the way: ([\d.]+) N")) < 0.02 and away < 1e-5


def test_a_push_on_the_way_up_in_the_worst_of_12_directions_slackens_no_cable():
    def pushed(angle):
        force = np.array([np.cos(angle), np.sin(angle), 0])
        with started(3) as plant:
            return run(plant, lambda t: force if 1.0 <= t < 1.2 else 0 * force)[0]

    worst = min(pushed(2 * np.pi * k / 12) for k in range(12))
    print(worst)
    assert worst > 0.9
