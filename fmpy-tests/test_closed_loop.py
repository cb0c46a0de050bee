"""The paper's manoeuvre (Section VI) in plain fmpy, on the plant FMU and on a plant written in Python."""

import numpy as np
import pytest

import python_robot
from robot_fmu import STATUS, ClosedLoop, Slave, cable_names, fmu_path, pose_names

SET_POINTS = [0.0855, 0.1266, 0.1464, 0.15]


def test_four_set_points_and_positive_tensions(version):
    with ClosedLoop(version) as loop:
        sequence, smallest = [], np.inf
        for _ in range(12_000):
            loop.step()
            if loop.controller["setPointIndex"] > len(sequence):
                sequence.append(loop.controller.get(["setPoint.x", "setPoint.y"]))
            smallest = min(smallest, loop.controller.get(cable_names("motorTension")).min())
            assert loop.slack() == []
        assert np.allclose(sequence, [[x, x] for x in SET_POINTS], atol=5e-5)
        assert STATUS[loop.controller["status"]] == "AtGoal" and loop.controller["atGoal"]
        tensions = loop.controller.get(cable_names("motorTension"))
        assert tensions.argmin() == 4 and abs(tensions[4] - 1.05) < 5e-3
        assert smallest > 1.0
        assert np.allclose(tensions, python_robot.static_tensions([0.15, 0.15, 1.0]), atol=5e-3)


def test_controller_drives_a_plant_written_in_python(version):
    plant = python_robot.Plant()
    with Slave(fmu_path(version, "CableRobotController")) as controller:
        controller.set(pose_names("goalPose"), [0.15, 0.15, 1.0, 0, 0, 0])
        controller.set(pose_names("encoderPose"), plant.pose())
        controller.initialize()
        sequence, worst_velocity = [], 0.0
        for k in range(12_000):
            controller.set(pose_names("encoderPose"), plant.pose())
            controller.step(1e-3, k * 1e-3)
            tensions = controller.get(cable_names("motorTension"))
            assert tensions.min() > 0.0
            estimate = controller.get(pose_names("estimatedVelocity"))[:3]
            worst_velocity = max(worst_velocity, np.linalg.norm(estimate - plant.velocity))
            if controller["setPointIndex"] > len(sequence):
                sequence.append(controller["setPoint.x"])
            plant.step(tensions, 1e-3)
        assert np.allclose(sequence, SET_POINTS, atol=5e-5)
        assert controller["atGoal"]
        assert worst_velocity < 1e-3, worst_velocity


def test_negative_control_a_step_past_the_planner_slackens_a_cable(version):
    """The law alone, asked for more than the workspace gives: what the planner is there to prevent."""
    with Slave(fmu_path(version, "CableRobotPlant")) as plant:
        plant.set(cable_names("motorTension"), python_robot.static_tensions([0.0, 0.0, 1.0]))
        plant.initialize()
        slack = set()
        for k in range(300):
            pose = plant.get(pose_names("encoderPose"))
            velocity = plant.get(["velocity.x", "velocity.y", "velocity.z"])
            plant.set(cable_names("motorTension"), python_robot.law(pose[:3], velocity, np.array([0.3, 0.3, 1.0])))
            plant.step(1e-3, k * 1e-3)
            slack |= {cable for cable in range(1, 7) if plant[f"slack[{cable}]"]}
        assert 5 in slack


def test_the_same_step_inside_the_domain_does_not(version):
    """The negative control's own control: a step that (15) admits keeps every cable taut under the same bare law."""
    with Slave(fmu_path(version, "CableRobotPlant")) as plant:
        plant.set(cable_names("motorTension"), python_robot.static_tensions([0.0, 0.0, 1.0]))
        plant.initialize()
        for k in range(3000):
            pose = plant.get(pose_names("encoderPose"))
            velocity = plant.get(["velocity.x", "velocity.y", "velocity.z"])
            plant.set(cable_names("motorTension"), python_robot.law(pose[:3], velocity, np.array([0.0855, 0.0855, 1.0])))
            plant.step(1e-3, k * 1e-3)
            assert not any(plant[f"slack[{cable}]"] for cable in range(1, 7))


def test_fmi_2_and_fmi_3_give_the_same_bits():
    rig = {"friction": 0.2, "motorLag": 0.005, "loadCellNoise": 0.1, "encoderResolution": 1e-5}
    with ClosedLoop(2, plant=rig) as two, ClosedLoop(3, plant=rig) as three:
        names = cable_names("motorTension") + pose_names("estimatedPose") + pose_names("estimatedVelocity")
        for _ in range(2000):
            two.step()
            three.step()
            assert two.controller.get(names).tobytes() == three.controller.get(names).tobytes()
            measured = cable_names("measuredTension")
            assert two.plant.get(measured).tobytes() == three.plant.get(measured).tobytes()


def test_plant_fmu_and_python_plant_move_alike(version):
    python = python_robot.Plant()
    tensions = python_robot.static_tensions([0.02, -0.01, 1.0])
    with Slave(fmu_path(version, "CableRobotPlant")) as plant:
        plant.set(cable_names("motorTension"), tensions)
        plant.initialize()
        for k in range(500):
            plant.step(1e-3, k * 1e-3)
            python.step(tensions, 1e-3)
        assert np.allclose(plant.get(pose_names("encoderPose")), python.pose(), atol=1e-9)


@pytest.mark.parametrize("h", [2e-3, 1e-2, 5e-2])
def test_other_communication_steps_arrive_too(version, h):
    with ClosedLoop(version, h=h) as loop:
        for _ in range(round(12 / h)):
            loop.step()
            assert loop.slack() == []
        assert loop.controller["atGoal"]


def test_the_exact_planner_takes_the_papers_move_in_one_set_point(version):
    with ClosedLoop(version, controller={"planner": 2}) as loop:
        while not loop.controller["atGoal"]:
            loop.step()
            assert loop.slack() == [] and loop.count < 3000
        assert loop.controller["setPointIndex"] == 1


def test_the_exact_planner_rises_and_moves_aside_at_once(version):
    with ClosedLoop(version, goal=(-0.1, 0.05, 0.8, 0, 0, 0), controller={"planner": 2, "lambda": 5.0}) as loop:
        for _ in range(5000):
            loop.step()
            assert loop.slack() == []
        assert loop.controller["atGoal"]
        assert np.allclose(loop.plant.get(pose_names("encoderPose"))[:3], [-0.1, 0.05, 0.8], atol=1e-3)
