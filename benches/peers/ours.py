"""The packed FMUs of a rig: what MinimumTime plans, and the closed loops of the three planners."""

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import motion
from rig import rates_to_omega

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "fmpy-tests"))
from robot_fmu import FMU_FOLDER, Slave, pose_names  # noqa: E402

PROGRAM = ROOT / "target/debug/cable-robot"

SPARE = 0.0017  # of the weight: what our planners leave besides the limits, so that theirs are so much wider
PLANNERS = {"Bounded": 1, "Exact": 2, "MinimumTime": 3}
FINE, STEP = 1e-4, 1e-3  # s, of a plan that is read out, of a closed loop
SETTLED = 0.1  # s until the goal is given: the controller then knows that it started at rest
LONGEST = 25.0  # s of a closed loop
REPEATS = 7  # of a step whose time is taken
REFERENCE = [name for kind in ("reference", "referenceVelocity", "referenceAcceleration") for name in pose_names(kind)]


class Ours:
    def __init__(self, rig, folder):
        """Packs the FMUs of a rig with its limits, made wider by what is left besides."""
        self.rig, self.folder = rig, folder
        folder.mkdir()
        spare = SPARE * rig.weight
        change = {"min =": f"min = {rig.least - spare}", "max =": f"max = {rig.greatest + spare}"}
        lines = rig.path.read_text().splitlines()
        lines = [next((new for old, new in change.items() if line.startswith(old)), line) for line in lines]
        (folder / "rig.toml").write_text("\n".join(lines))
        command = [PROGRAM, "fmu", "--rig", folder / "rig.toml", "--output", folder, "--library", FMU_FOLDER]
        subprocess.run(command, check=True, capture_output=True)

    def slave(self, model):
        return Slave(self.folder / f"fmi3/CableRobot{model}.fmu")

    def controller(self, planner, start, **parameters):
        """In initialisation, at rest at the start."""
        controller = self.slave("Controller")
        for name, value in {"plannerNumber": PLANNERS[planner], **parameters}.items():
            controller[name] = value
        controller.enter_initialization()
        for name in ("encoderPose", "goalPose"):
            controller.set(pose_names(name), start)
        return controller

    def duration(self, start, goal):
        """s, of the plan of the command line; None where there is none."""
        command = [PROGRAM, "plan", "--rig", self.folder / "rig.toml", "--planner", "minimum-time", "--json"]
        places = [f"--{name}={','.join(map(repr, map(float, pose)))}" for name, pose in (("from", start), ("to", goal))]
        planned = json.loads(subprocess.run([*command, *places], capture_output=True).stdout)
        return planned["duration"] if planned["reachable"] else None

    def decision(self, planner, start, goal):
        """s of CPU of the step that takes up a goal, less that of the one before."""
        given = round(SETTLED / STEP)
        with self.controller(planner, start) as controller:
            controller.exit_initialization()
            for k in range(given - 1):
                controller.step(STEP, k * STEP)
            before = timed(controller, STEP, (given - 1) * STEP)
            controller.set(pose_names("goalPose"), goal)
            return timed(controller, STEP, given * STEP) - before

    def plan(self, start, goal):
        """MinimumTime, read out of its own reference, which the platform follows exactly."""
        duration = self.duration(start, goal)
        if duration is None:
            return None
        given = round(SETTLED / FINE)
        with self.controller("MinimumTime", start) as controller:
            controller.exit_initialization()
            rows = []
            for k in range(given + round(duration / FINE) + 10):
                if k == given:
                    controller.set(pose_names("goalPose"), goal)
                controller.step(FINE, k * FINE)
                rows.append(controller.get(REFERENCE))
                controller.set(pose_names("encoderPose"), rows[-1][:6])
        q, v, a = np.array(rows).reshape(-1, 3, 6).swapaxes(0, 1)
        moving = np.flatnonzero((v != 0).any(axis=1))
        if abs(len(moving) * FINE - duration) > 5 * FINE:
            raise RuntimeError(f"the FMU moves for {len(moving) * FINE:.4f} s, the command line plans {duration:.4f} s")
        shown = slice(moving[0] - 1, moving[-1] + 2)
        times = FINE * np.arange(len(q[shown]))
        wrench = self.rig.wrench(q[shown], v[shown], a[shown])
        return motion.found(self.rig, goal, times, q[shown], wrench, duration, self.decision("MinimumTime", start, goal))

    def closed_loop(self, planner, start, goal):
        """Controller and plant, connected, from when the goal is given to a robot at rest; None where it is not reached."""
        if planner == "Bounded" and self.rig.cables > 6:
            return None  # The FMU refuses it: it is for the paper's shape.
        with self.controller(planner, start) as controller, self.slave("Plant") as plant:
            plant.set(pose_names("initialPose"), start)
            plant.enter_initialization()
            pulls = [f"motorTension[{i + 1}]" for i in range(self.rig.cables)]
            plant.set(pulls, controller.get(pulls))
            controller.exit_initialization()
            plant.exit_initialization()
            seen = pose_names("encoderPose") + [f"{name}.{axis}" for name in ("velocity", "angularVelocity") for axis in "xyz"]
            rows = [plant.get(seen)]
            given = round(SETTLED / STEP)
            for k in range(round(LONGEST / STEP)):
                if k == given:
                    controller.set(pose_names("goalPose"), goal)
                controller.set(pose_names("encoderPose"), rows[-1][:6])
                controller.step(STEP, k * STEP)
                plant.set(pulls, controller.get(pulls))
                plant.step(STEP, k * STEP)
                rows.append(plant.get(seen))
                if k > given and (controller["atGoal"] or controller["statusNumber"] > 4):
                    break
        rows = np.array(rows[given:])
        q, omega = rows[:, :6], rows[:, 9:]
        v = np.concatenate([rows[:, 6:9], np.linalg.solve(rates_to_omega(q), omega[..., None])[..., 0]], axis=1)
        return motion.simulated(self.rig, goal, STEP, q, v, self.decision(planner, start, goal))


def timed(controller, h, at):
    """s of CPU of a step, which is taken: the median of some repetitions from the same state."""
    state, spent = controller.save(), []
    for _ in range(REPEATS):
        controller.restore(state)
        begun = time.thread_time()
        controller.step(h, at)
        spent.append(time.thread_time() - begun)
    return np.median(spent)
