"""MinimumTime beside what people would use instead, on the same moves with the same limits, in one run: writes docs/benchmarks.md.

    cargo build --bin cable-robot && cargo fmu build
    python3 -m venv target/peers && target/peers/bin/pip install --requirement benches/peers/requirements.txt
    target/peers/bin/python benches/peers/compare.py
"""

import json
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import ruckig
import toppra
import toppra.algorithm
import toppra.constraint

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "fmpy-tests"))
import python_robot  # noqa: E402
from robot_fmu import ClosedLoop, Slave, fmu_path, pose_names  # noqa: E402

LEAST, GREATEST = 0.5, 40.0  # N, what every method is to keep
SPARE = 0.1  # N, what our planner leaves besides
SAMPLES = 2000  # of a motion, where tensions are looked at
SEED = 1
GIVEN = 1000  # steps of 0.1 ms until the goal is given: the controller then knows that it started at rest
NORMALS = np.array([[np.cos(a), np.sin(a)] for a in np.radians([150, 90, -90, 210, 30, -30])])

toppra.setup_logging("ERROR")


def tensions(pose, rates, accelerations):
    """Eq. (1) solved for the tensions, in numpy and independent of the Rust code."""
    roll, pitch, yaw = pose[3:]
    cp, sp, cy, sy = np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    e = np.array([[cy * cp, -sy, 0], [sy * cp, cy, 0], [-sp, 0, 1]])
    dp, dy = rates[4], rates[5]
    de = np.array([[-sy * cp * dy - cy * sp * dp, -cy * dy, 0], [cy * cp * dy - sy * sp * dp, -sy * dy, 0], [-cp * dp, 0, 0]])
    r = python_robot.rotation(roll, pitch, yaw)
    omega, alpha = e @ rates[3:], e @ accelerations[3:] + de @ rates[3:]
    inertia = r @ python_robot.INERTIA @ r.T
    force = python_robot.M * (accelerations[:3] - [0, 0, python_robot.G])
    torque = inertia @ alpha + np.cross(omega, inertia @ omega)
    return np.linalg.solve(python_robot.wrench_matrix(pose[:3], r), np.concatenate([force, torque]))


def extremes(motion, duration):
    """The smallest and the greatest tension of a motion t -> (pose, rates, accelerations), also between its grid points."""
    looked_at = np.array([tensions(*motion(t)) for t in np.linspace(0, duration, SAMPLES)])
    return looked_at.min(), looked_at.max()


def ours(start, goal, rig):
    """Through the command line for the time, and through the FMU, on its own reference, for the motion and for what a decision costs."""
    command = [ROOT / "target/debug/cable-robot", "plan", "--rig", rig, "--planner", "minimum-time", "--json"]
    answer = subprocess.run([*command, "--from", ",".join(map(str, start)), "--to", ",".join(map(str, goal))], capture_output=True)
    planned = json.loads(answer.stdout)
    if not planned["reachable"]:
        return None
    with Slave(fmu_path(3, "CableRobotController")) as controller:
        for name, value in {"plannerNumber": 3, "minTension": LEAST - SPARE, "maxTension": GREATEST + SPARE}.items():
            controller[name] = value
        for name in ("encoderPose", "goalPose"):
            controller.set(pose_names(name), start)
        controller.initialize()
        h, took, rows = 1e-4, [], []
        for k in range(round(planned["duration"] / h) + GIVEN + 10):
            if k == GIVEN:
                controller.set(pose_names("goalPose"), goal)
            begun = time.perf_counter()
            controller.step(h, k * h)
            took.append(time.perf_counter() - begun)
            names = pose_names("reference") + pose_names("referenceVelocity") + pose_names("referenceAcceleration")
            pose, rates, accelerations = controller.get(names).reshape(3, 6)
            rows.append(tensions(pose, rates, accelerations))
            controller.set(pose_names("encoderPose"), pose)
        # The first step in which the reference moves is the one after the plan was made.
        decision = next(k for k, row in enumerate(rows) if not np.allclose(row, rows[0]))
        planning = took[decision] - np.median(took)
        return planned["duration"], np.min(rows), np.max(rows), planning


def by_toppra(scheme):
    def plan(start, goal, _):
        begun = time.perf_counter()
        path = toppra.SplineInterpolator([0, 1], np.array([start, goal]))
        bounds = np.concatenate([np.full(6, GREATEST), np.full(6, -LEAST)])
        sides = np.vstack([np.eye(6), -np.eye(6)])
        limits = toppra.constraint.SecondOrderConstraint(tensions, lambda q: sides, lambda q: bounds, 6, discretization_scheme=scheme)
        instance = toppra.algorithm.TOPPRA(
            [limits], path, gridpoints=np.linspace(0, 1, 201), parametrizer="ParametrizeConstAccel"
        )
        trajectory = instance.compute_trajectory(0, 0)
        planning = time.perf_counter() - begun
        if trajectory is None:
            return None
        motion = lambda t: (trajectory(t), trajectory(t, 1), trajectory(t, 2))
        return trajectory.duration, *extremes(motion, trajectory.duration), planning

    return plan


def by_ruckig(start, goal, _):
    """It knows limits of the axes only: the same acceleration for all of them, the greatest with which the tensions are kept, by halving."""
    moving = [k for k in range(6) if start[k] != goal[k]]
    planner, best = ruckig.Ruckig(len(moving)), None
    below, above = 0.0, 40.0
    for _ in range(20):
        most = 0.5 * (below + above)
        asked = ruckig.InputParameter(len(moving))
        asked.current_position, asked.target_position = start[moving], goal[moving]
        asked.max_velocity = [1e3] * len(moving)
        asked.max_acceleration = [most] * len(moving)
        asked.synchronization = ruckig.Synchronization.Phase
        trajectory = ruckig.Trajectory(len(moving))
        begun = time.perf_counter()
        planner.calculate(asked, trajectory)
        planning = time.perf_counter() - begun

        def motion(t):
            found = np.zeros((3, 6))
            found[0] = start
            for row, values in enumerate(trajectory.at_time(t)[:3]):
                found[row, moving] = values
            return found

        least, greatest = extremes(motion, trajectory.duration)
        if least >= LEAST and greatest <= GREATEST:
            below, best = most, (trajectory.duration, least, greatest, planning)
        else:
            above = most
    return best


METHODS = {
    "MinimumTime": ours,
    "toppra, Interpolation": by_toppra(toppra.constraint.DiscretizationType.Interpolation),
    "toppra, Collocation": by_toppra(toppra.constraint.DiscretizationType.Collocation),
    "ruckig": by_ruckig,
}


def pose(rng, height, turn):
    while True:
        point = rng.uniform(-0.25, 0.25, 2)
        if (NORMALS @ point < 0.18).all():
            return np.array([*point, rng.uniform(1 - height, 1 + height), *rng.uniform(-turn, turn, 3)])


def moves():
    rng = np.random.default_rng(SEED)
    yield "the paper's move", [(np.array([0, 0, 1.0, 0, 0, 0]), np.array([0.15, 0.15, 1.0, 0, 0, 0]))]
    yield "100 level moves", [(pose(rng, 0, 0), pose(rng, 0, 0)) for _ in range(100)]
    yield "20 moves in space", [(pose(rng, 0.3, 0), pose(rng, 0.3, 0)) for _ in range(20)]
    yield "20 turned moves", [(pose(rng, 0.2, 0.15), pose(rng, 0.2, 0.15)) for _ in range(20)]


def table(name, pairs, rig):
    found = {method: [] for method in METHODS}
    for k, (start, goal) in enumerate(pairs):
        print(f"\r{name}: {k + 1} of {len(pairs)}  ", end="", file=sys.stderr)
        for method, plan in METHODS.items():
            found[method].append(plan(start, goal, rig))
    print(file=sys.stderr)
    yield f"\n## {name[0].upper() + name[1:]}\n\n"
    yield "| | time, ours = 1 (median) | planning, ours = 1 (median) | smallest tension (N) | greatest (N) | planned |\n|---|---|---|---|---|---|\n"
    for method, rows in found.items():
        both = [(row, own) for row, own in zip(rows, found["MinimumTime"]) if row and own]
        if not both:
            yield f"| {method} | - | - | - | - | 0 of {len(pairs)} |\n"
            continue
        ratio = lambda column: np.median([row[column] / own[column] for row, own in both])
        least, greatest = min(row[1] for row, _ in both), max(row[2] for row, _ in both)
        yield f"| {method} | {ratio(0):.4f} | {ratio(3):.0f} | {least:.3f} | {greatest:.3f} | {sum(map(bool, rows))} of {len(pairs)} |\n"
    own = [row for row in found["MinimumTime"] if row]
    yield f"\nOurs: {np.median([row[0] for row in own]):.4f} s, planned in {1e6 * np.median([row[3] for row in own]):.0f} µs (medians).\n"


def closed_loop():
    """The paper's move in closed loop through the packed FMUs, from rest to rest."""
    yield "\n## The paper's move in closed loop\n\nThrough the packed FMUs at 1 kHz with Table I: seconds from the goal, given to a robot at rest, until it rests there.\n\n| planner | s | smallest tension (N) |\n|---|---|---|\n"
    for name, number in (("Bounded, the paper's chain", 1), ("Exact", 2), ("MinimumTime", 3)):
        with ClosedLoop(3, goal=[0, 0, 1, 0, 0, 0], controller={"plannerNumber": number}) as loop:
            least = np.inf
            for _ in range(100):
                loop.step()
            loop.goal = [0.15, 0.15, 1.0, 0, 0, 0]
            loop.step()
            while not loop.controller["atGoal"]:
                loop.step()
                least = min(least, loop.controller.get([f"motorTension[{i}]" for i in range(1, 7)]).min())
            yield f"| {name} | {(loop.count - 100) * loop.h:.3f} | {least:.3f} |\n"


HEAD = f"""# Benchmarks

Written by `benches/peers/compare.py`, whose first lines say how to run it. Moves of Table I's robot from rest to rest, straight, seed {SEED}; every method is to keep all tensions between {LEAST} and {GREATEST:.0f} N
(ours is told {LEAST - SPARE} and {GREATEST + SPARE}, since it leaves {SPARE} N besides). Tensions are looked at at {SAMPLES} instants of each motion, ours at every 0.1 ms, by inverse dynamics in numpy, which also is toppra's model. Planning is of one
run on one machine, {platform.machine()}, ours through the FMU in Python (the step that takes up the goal, less an ordinary one), toppra with 201 points, of ruckig one call. ruckig knows limits of the axes only: it gets the greatest acceleration, the same for all
axes, with which the tensions are kept, found by halving with the inverse dynamics.
"""


def main():
    text = HEAD
    with tempfile.TemporaryDirectory() as folder:
        rig = Path(folder) / "rig.toml"
        whole = (ROOT / "rigs/paper.toml").read_text()
        lines = [line for line in whole.splitlines()]
        change = {"min =": f"min = {LEAST - SPARE}", "max =": f"max = {GREATEST + SPARE}"}
        rig.write_text("\n".join(next((new for old, new in change.items() if line.startswith(old)), line) for line in lines))
        for name, pairs in moves():
            text += "".join(table(name, pairs, rig))
    text += "".join(closed_loop())
    (ROOT / "docs/benchmarks.md").write_text(text)
    print("docs/benchmarks.md")


if __name__ == "__main__":
    main()
