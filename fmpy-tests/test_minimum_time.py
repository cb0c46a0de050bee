"""The planner MinimumTime through the packed FMU: on the plant FMU, and on a plant written in Python."""

import numpy as np
import pytest

import python_robot
from robot_fmu import STATUS, ClosedLoop, Slave, cable_names, fmu_path, pose_names

GOAL = np.array([0.15, 0.15, 1.0])
PLANNERS = {"Bounded": 1, "Exact": 2, "MinimumTime": 3}
# Planned for Table I and a least tension of 0: `cable-robot plan --planner minimum-time --from 0,0,1 --to 0.15,0.15,1`.
PLANNED = 0.5587


def time_to_goal(version, planner):
    """Seconds from the goal of the paper's move, given to a robot at rest, until it rests there; no cable may go slack on the way."""
    with ClosedLoop(version, goal=[0, 0, 1, 0, 0, 0], controller={"plannerNumber": planner}) as loop:
        for _ in range(100):
            loop.step()
        loop.goal = [*GOAL, 0, 0, 0]
        loop.step()
        while not loop.controller["atGoal"]:
            loop.step()
            assert loop.slack() == [] and loop.count < 10_000
        return (loop.count - 100) * loop.h


def test_the_papers_move_is_made_in_the_time_that_was_planned(version):
    took = {name: time_to_goal(version, number) for name, number in PLANNERS.items()}
    print(took)
    assert took["MinimumTime"] <= 1.02 * PLANNED + 2e-3
    assert took["Exact"] > 4 * took["MinimumTime"] and took["Bounded"] > 12 * took["MinimumTime"]


def test_the_law_follows_the_reference_on_a_plant_written_in_python(version):
    plant = python_robot.Plant()
    with Slave(fmu_path(version, "CableRobotController")) as controller:
        controller["plannerNumber"] = 3
        controller["minTension"] = 0.5
        controller.set(pose_names("goalPose"), [*GOAL, 0, 0, 0])
        controller.set(pose_names("encoderPose"), plant.pose())
        controller.initialize()
        smallest, farthest = np.inf, 0.0
        for k in range(1000):
            controller.set(pose_names("encoderPose"), plant.pose())
            controller.step(1e-3, k * 1e-3)
            tensions = controller.get(cable_names("motorTension"))
            smallest = min(smallest, tensions.min())
            reference = controller.get(pose_names("reference"))
            farthest = max(farthest, np.linalg.norm(plant.position - reference[:3]))
            plant.step(tensions, 1e-3)
        assert STATUS[controller["status"]] == "AtGoal"
        assert np.allclose(reference[:3], GOAL) and np.linalg.norm(plant.position - GOAL) < 1e-4
        print(f"smallest tension {smallest:.4f} N, at most {1e3 * farthest:.3f} mm from the reference")
        assert smallest > 0.55 and farthest < 1e-3


@pytest.mark.parametrize("goal", [[0.1, -0.05, 0.9, 0.0, 0.1, 0.3], [-0.12, 0.1, 1.2, 0.0, 0.0, -0.2]])
def test_a_turn_is_made_and_taken_back_on_the_way(version, goal):
    with ClosedLoop(version, goal=goal, controller={"plannerNumber": 3}) as loop:
        for _ in range(200):
            loop.step()
        assert np.linalg.norm(loop.controller.get(pose_names("referenceVelocity"))) > 0.1
        loop.goal = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        for _ in range(1500):
            loop.step()
            assert loop.slack() == []
        assert loop.controller["atGoal"]
        assert np.allclose(loop.plant.get(pose_names("encoderPose")), loop.goal, atol=1e-3)
