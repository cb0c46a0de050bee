"""The packed controller FMU on a plant in MuJoCo: Table I with an inertia that a body can have, and the rig with eight cables."""

import tomllib

import numpy as np
import pytest

import mujoco_robot
import python_robot
from robot_fmu import FMU_FOLDER, STATUS, Slave, fmu_path, packed, pose_names

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
    rig = tomllib.loads((FMU_FOLDER.parent.parent / "rigs/eight.toml").read_text())
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
