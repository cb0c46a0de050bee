"""The packed controller FMU on a plant in MuJoCo: Table I with an inertia that a body can have, and the rig with eight cables. Way points and orbits are in no FMU: their
references come from `cable-robot simulate`, and a law written here follows them."""

import csv
import subprocess
import tomllib

import numpy as np
import pytest

import mujoco_robot
import python_robot
from robot_fmu import FMU_FOLDER, STATUS, Slave, fmu_path, packed, pose_names

ROOT = FMU_FOLDER.parent.parent

# A flat body: I3 = I1 + I2. Table I's 0.075 breaks the triangle inequality, and MuJoCo refuses it.
INERTIA = np.diag([0.018, 0.018, 0.036])
STEP = 1e-3


def paper():
    return mujoco_robot.Plant(python_robot.ANCHORS, python_robot.ATTACHMENTS, python_robot.M, INERTIA, [0, 0, 1])


def drive(controller, plant, cables, goals):
    """Goals as (seconds, pose). The smallest and the greatest tension commanded, and the farthest from the reference, m."""
    smallest, greatest, farthest, count = np.inf, 0.0, 0.0, 0
    tension_names = [f"motorTension[{i}]" for i in range(1, cables + 1)]
    for seconds, goal in goals:
        controller.set(pose_names("goalPose"), goal)
        for _ in range(round(seconds / STEP)):
            controller.set(pose_names("encoderPose"), plant.pose())
            controller.step(STEP, count * STEP)
            tensions = controller.get(tension_names)
            smallest, greatest = min(smallest, tensions.min()), max(greatest, tensions.max())
            away = plant.position - controller.get(pose_names("reference"))[:3]
            farthest = max(farthest, np.linalg.norm(away))
            plant.step(tensions, STEP)
            count += 1
    return smallest, greatest, farthest


def test_tendons_pull_as_cables_do():
    """Held by the static tensions of the wrench matrix, the platform stays."""
    plant = paper()
    assert np.allclose(plant.lengths(), np.linalg.norm(python_robot.ANCHORS - [0, 0, 1] - python_robot.ATTACHMENTS, axis=1))
    for _ in range(100):
        plant.step(python_robot.static_tensions([0.0, 0.0, 1.0]), STEP)
    assert np.linalg.norm(plant.position - [0, 0, 1]) < 1e-9


@pytest.mark.parametrize("planner", [2, 3])
def test_the_papers_move_turns_and_interrupted_moves(version, planner):
    plant = paper()
    with Slave(fmu_path(version, "CableRobotController")) as controller:
        for name, value in {"plannerNumber": planner, "I3": INERTIA[2, 2], "minTension": 0.5, "maxTension": 60.0}.items():
            controller[name] = value
        controller.set(pose_names("encoderPose"), plant.pose())
        controller.initialize()
        slow = 3.0 if planner == 2 else 0.8
        goals = [
            (slow, [0.15, 0.15, 1.0, 0, 0, 0]),
            (0.2, [-0.1, 0.1, 0.8, 0, 0, 0]),
            (0.3, [0.1, -0.1, 1.2, 0, 0, 0.3]),
            (2 * slow, [0.0, -0.15, 0.9, 0, 0.1, -0.2]),
            (2 * slow, [0.0, 0.0, 1.0, 0, 0, 0]),
        ]
        smallest, greatest, farthest = drive(controller, plant, 6, goals)
        print(f"tensions {smallest:.3f} to {greatest:.2f} N, {1e3 * farthest:.3f} mm from the reference")
        assert smallest > 0.55 and greatest < 60.0
        assert planner == 2 or farthest < 1e-3
        assert STATUS[controller["status"]] == "AtGoal"
        assert np.linalg.norm(plant.position - [0, 0, 1]) < 2e-3


def test_eight_cables(tmp_path):
    rig = tomllib.loads((ROOT / "rigs/eight.toml").read_text())
    anchors, attachments = (np.array([cable[end] for cable in rig["cables"]]) for end in ("anchor", "attachment"))
    platform, home = rig["platform"], np.array(rig["home"])
    arms = attachments - platform["center_of_mass"]
    plant = mujoco_robot.Plant(anchors, arms, platform["mass"], np.diag(platform["inertia"]), home)
    with Slave(packed(tmp_path) / "fmi3/CableRobotController.fmu") as controller:
        controller["plannerNumber"] = 3
        controller.set(pose_names("encoderPose"), plant.pose())
        controller.initialize()
        goals = [
            (0.25, [*(home + [0.4, 0.3, -0.2]), 0, 0, 0.1]),
            (2.0, [*(home + [-0.4, 0.2, 0.1]), 0, 0.1, 0]),
            (2.0, [*home, 0, 0, 0]),
        ]
        smallest, greatest, farthest = drive(controller, plant, 8, goals)
        print(f"tensions {smallest:.3f} to {greatest:.2f} N, {1e3 * farthest:.3f} mm from the reference")
        assert smallest > rig["tension"]["min"] and farthest < 2e-3
        assert STATUS[controller["status"]] == "AtGoal"


def lifted(version, lift):
    """Seconds from the goal of the paper's move, given to a robot at rest, until it rests there, the smallest tension and how far it rose, m."""
    plant, smallest, highest = paper(), np.inf, 0.0
    with Slave(fmu_path(version, "CableRobotController")) as controller:
        parameters = {"plannerNumber": 3, "I3": INERTIA[2, 2], "minTension": 0.5, "maxTension": 40.0, "lift": lift}
        for name, value in parameters.items():
            controller[name] = value
        for name in ("encoderPose", "goalPose"):
            controller.set(pose_names(name), plant.pose())
        controller.initialize()
        for k in range(1000):
            if k == 100:
                controller.set(pose_names("goalPose"), [0.15, 0.15, 1.0, 0, 0, 0])
            controller.set(pose_names("encoderPose"), plant.pose())
            controller.step(STEP, k * STEP)
            tensions = controller.get([f"motorTension[{i}]" for i in range(1, 7)])
            smallest, highest = min(smallest, tensions.min()), max(highest, 1.0 - plant.position[2])
            plant.step(tensions, STEP)
            if k > 100 and controller["atGoal"]:
                return (k - 100) * STEP, smallest, highest
    raise AssertionError("the goal was not reached")


def test_a_lift_is_a_tenth_sooner(version):
    straight, bent = lifted(version, 0.0), lifted(version, 0.2)
    print(straight, bent)
    assert bent[0] < 0.92 * straight[0] and straight[2] < 1e-3 and 0.02 < bent[2] < 0.2
    assert min(straight[1], bent[1]) > 0.55


def references(folder, scenario):
    """Places and velocities that `cable-robot simulate` led its own plant along, a row a millisecond."""
    inertia = "inertia = [0.018, 0.018, 0.075]"
    rig = (ROOT / "rigs/paper.toml").read_text()
    assert inertia in rig
    (folder / "rig.toml").write_text(rig.replace(inertia, f"inertia = {np.diag(INERTIA).tolist()}"))
    (folder / "scenario.toml").write_text(f'title = "A reference"\nrig = "rig.toml"\n{scenario}')
    command = [ROOT / "target/debug/cable-robot", "simulate", folder / "scenario.toml", "--output", folder / "run"]
    subprocess.run(command, check=True, capture_output=True)
    with open(folder / "run/run.csv") as file:
        # A row has what the controller answered at the start of the step that led there.
        rows = [[float(row[f"controller.{kind}.{axis}"]) for kind in ("reference", "referenceVelocity") for axis in "xyz"] for row in list(csv.DictReader(file))[1:]]
    return np.array(rows).reshape(-1, 2, 3)


def followed(plant, rows, gain=3.0):
    """The law on the plant, with its true state, no orientation: smallest tension commanded, farthest from the reference, m."""
    smallest, farthest = np.inf, 0.0
    for (place, velocity), (next_place, next_velocity) in zip(rows, rows[1:]):
        turned = plant.pose()[3:]
        rates, omega = plant.data.qvel[:3].copy(), plant.data.qvel[3:].copy()
        farthest = max(farthest, np.linalg.norm(plant.position - place))
        # For the middle of the step, as the platform goes on.
        rate_error = rates + 0.5 * STEP * (next_velocity - velocity) / STEP - 0.5 * (velocity + next_velocity)
        error = plant.position + 0.5 * STEP * rates - 0.5 * (place + next_place)
        commanded = (next_velocity - velocity) / STEP - gain * rate_error - gain * (rate_error + gain * error)
        force = python_robot.M * (commanded - [0, 0, python_robot.G])
        torque = INERTIA @ (-2 * gain * omega - gain * gain * turned)
        matrix = python_robot.wrench_matrix(plant.position, python_robot.rotation(*turned))
        tensions = np.linalg.solve(matrix, np.concatenate([force, torque]))
        smallest = min(smallest, tensions.min())
        plant.step(tensions, STEP)
    return smallest, farthest


def test_way_points_are_passed_without_a_stop(tmp_path):
    ways = [[0.1, 0.0, 0.9], [0.15, 0.05, 1.0]]
    rows = references(
        tmp_path,
        f"""
duration = 1.2
[[goals]]
time = 0.1
pose = [0.15, 0.15, 1.0]
through = {ways}
[controller]
planner = "minimum-time"
min_tension = 0.5
""",
    )
    for way in ways:
        nearest = np.linalg.norm(rows[:, 0] - way, axis=1).argmin()
        assert np.linalg.norm(rows[nearest, 0] - way) < 1e-3 and np.linalg.norm(rows[nearest, 1]) > 0.1
    smallest, farthest = followed(paper(), rows)
    print(f"smallest tension {smallest:.3f} N, {1e3 * farthest:.3f} mm from the reference")
    assert np.allclose(rows[-1, 0], [0.15, 0.15, 1.0]) and smallest > 0.5 and farthest < 1e-3


def test_a_circle_outside_the_static_workspace(tmp_path):
    rows = references(tmp_path, 'duration = 8.0\n[orbit]\nshape = "circle"\nradius = 0.40\nrate = 2.75\nturns = 1.0\nstart = 2.5')
    outside = rows[:, 0][np.linalg.norm(rows[:, 0, :2], axis=1) > 0.39]
    assert len(outside) > 2000 and min(python_robot.static_tensions(place).min() for place in outside[::50]) < -5
    smallest, farthest = followed(paper(), rows)
    print(f"smallest tension {smallest:.3f} N, {1e3 * farthest:.3f} mm from the reference")
    assert smallest > 2.5 and farthest < 1e-3
