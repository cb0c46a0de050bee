"""Each method's motion of a move as a `problem` of docs/proof.md, numbers as doubles: an exact function of time, with the points at which its maker looked at the limits."""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

import ipopt
import motion
import parametrized

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/debug/cable-robot"
FREE = {"level": (0, 1, 2), "space": (0, 1, 2), "turned": tuple(range(6))}  # what the free optimum may move, by the kind of a move


@dataclass
class Asked:
    """`problems` that follow each other, each from where the one before ends; `own`: rows (piece from 0, s in it) of the first one, None where all time is claimed."""

    problems: list
    duration: float | None  # s
    own: list | None = None


def rig_entry(rig):
    """`problem.rig`."""
    cables = [
        {"anchor": anchor, "attachment": arm, "least": rig.least, "greatest": rig.greatest}
        for anchor, arm in zip(rig.anchors.tolist(), rig.arms.tolist())
    ]
    inertia, gravity = rig.inertia.tolist(), [0.0, 0.0, rig.gravity]
    return {"mass": rig.mass, "inertia": inertia, "gravity": gravity, "disturbance": [0.0] * 6, "cables": cables}


def asked(rig, pieces, own):
    duration = sum(piece["duration"] for piece in pieces)
    return Asked([{"rig": rig_entry(rig), "motion": {"pieces": pieces}}], duration, own)


def along(way, duration, s, rate, acceleration):
    """A piece of constant s'' on a way, coefficients (up to 4, 6)."""
    values = {"begin": 0.0, "s": s, "rate": rate, "acceleration": acceleration, "beta": 0.0, "jerk": 0.0}
    part = {"way": [list(map(float, row)) for row in way], **{name: float(value) for name, value in values.items()}}
    return {"duration": float(duration), "offset": [0.0] * 6, "parts": [part]}


def in_time(duration, *coefficients):
    """A piece whose coordinates are polynomials of the time in it."""
    return along(coefficients, duration, 0.0, 1.0, 0.0)


def ends(pieces):
    return [(k, t) for k, piece in enumerate(pieces) for t in (0.0, piece["duration"])]


def toppra(scheme):
    """The path is the straight way, as it was given; s(t) as `ParametrizeConstAccel` evaluates it."""

    def plan(rig, start, goal, _):
        found = parametrized.toppras(rig, start, goal, scheme)
        if found is None:
            return None
        times, places, rates, accelerations = found._ts, found._ss, found._velocities, found._us
        pieces = [along([start, goal - start], *row) for row in zip(np.diff(times), places, rates, accelerations)]
        own = ends(pieces) if scheme == parametrized.INTERPOLATION else [(k, 0.0) for k in range(len(pieces))]
        return asked(rig, pieces, own)

    return plan


def ruckig(rig, start, goal, _):
    """The pieces of its profiles, each coordinate's its own; the samples that its acceleration was found with, none of which may be beyond a limit."""
    kept = lambda found: found.smallest >= rig.least and found.greatest <= rig.greatest
    _, trajectory = parametrized.fastest_by_ruckig(rig, start, goal, kept)
    if trajectory is None:
        return None
    profiles, moving = trajectory.profiles[0], np.flatnonzero(start != goal)
    # Synchronised in phase, the profiles begin and end their pieces together, up to rounding.
    cuts = np.unique(np.round(np.concatenate([np.cumsum([0.0, *profile.t]) for profile in profiles]), 12))
    pieces = [_of_profiles(profiles, moving, start, a, b) for a, b in pairwise(cuts)]
    begins = np.concatenate([[0.0], np.cumsum([piece["duration"] for piece in pieces])])
    samples = np.linspace(0, trajectory.duration, motion.SAMPLES[rig.cables])
    which = np.clip(np.searchsorted(begins, samples, side="right") - 1, 0, len(pieces) - 1)
    return asked(rig, pieces, [(int(k), float(min(t - begins[k], pieces[k]["duration"]))) for k, t in zip(which, samples)])


def _of_profiles(profiles, moving, start, begin, end):
    coefficients = np.zeros((4, 6))
    coefficients[0] = start
    for profile, j in zip(profiles, moving):
        times = np.cumsum([0.0, *profile.t])
        # The phase that is on in the middle; where the cut is off its begin by rounding only, the begin is meant.
        k = int(np.searchsorted(times, 0.5 * (begin + end), side="right")) - 1
        if not np.isclose(times[k], begin, atol=1e-9):
            raise ValueError(f"ruckig's coordinates are not in phase: {times} and {begin}")
        coefficients[:, j] = profile.p[k], profile.v[k], profile.a[k] / 2, profile.j[k] / 6
    return in_time(end - begin, *coefficients)


def casadi_on_the_way(rig, start, goal, _):
    solved = ipopt.pieces_on_the_way(rig, start, goal)
    if solved is None:
        return None
    found = solved[1]
    rows = zip(np.diff(found.ends), found.places, found.speeds, found.accelerations)
    pieces = [along([start, goal - start], *row) for row in rows]
    return asked(rig, pieces, ends(pieces))


def casadi_free(rig, start, goal, kind):
    free = list(FREE[kind])
    solved = ipopt.from_rest(rig, start, goal, tuple(free))
    if solved is None:
        return None
    found, pieces = solved[3], []
    for duration, place, speed, acceleration in zip(np.diff(found.ends), found.places, found.speeds, found.accelerations):
        coefficients = np.zeros((3, 6))
        coefficients[0] = start
        coefficients[:, free] = place, speed, acceleration / 2
        pieces.append(in_time(duration, *coefficients))
    return asked(rig, pieces, ends(pieces))


def ours(planner):
    """What `plan --proof` writes: of the law's planners a problem for each step from rest to a set point, of MinimumTime one motion."""

    def plan(rig, start, goal, _):
        with tempfile.TemporaryDirectory() as folder:
            limited = Path(folder) / "rig.toml"
            change = {"min =": f"min = {rig.least}", "max =": f"max = {rig.greatest}"}
            lines = rig.path.read_text().splitlines()
            limited.write_text("\n".join(next((new for old, new in change.items() if line.startswith(old)), line) for line in lines))
            places = [f"--{name}={','.join(map(repr, map(float, pose)))}" for name, pose in (("from", start), ("to", goal))]
            proofs = Path(folder) / "proofs"
            run = subprocess.run([PROGRAM, "plan", "--rig", limited, "--planner", planner, *places, "--proof", proofs], capture_output=True, text=True)
            if run.returncode == 3:
                return None  # it says that the goal is out of its reach
            if run.returncode != 0:
                raise RuntimeError(run.stderr)
            files = sorted(proofs.iterdir(), key=lambda path: (len(path.name), path.name))
            problems = [doubles(json.loads(path.read_text())["problem"]) for path in files]
        moved = problems[0].get("motion")
        return Asked(problems, moved and sum(piece["duration"] for piece in moved["pieces"]))

    return plan


def doubles(value):
    """Of a proof file."""
    if isinstance(value, dict):
        return {key: doubles(x) for key, x in value.items()}
    if isinstance(value, list):
        return [doubles(x) for x in value]
    return float.fromhex(value)


METHODS = {
    "toppra, Collocation": toppra(parametrized.COLLOCATION),
    "toppra, Interpolation": toppra(parametrized.INTERPOLATION),
    "ruckig": ruckig,
    "CasADi + ipopt, on the way": casadi_on_the_way,
    "CasADi + ipopt, free": casadi_free,
    "Bounded (the paper's chain)": ours("bounded"),
    "Exact": ours("exact"),
    "MinimumTime": ours("minimum-time"),
}


def worst(rig, problem, own):
    """Of points (piece, s) of a motion without beta and jerk the ones with the smallest and the greatest tension, by numpy."""
    rows = []
    for k, t in own:
        piece = problem["motion"]["pieces"][k]
        q, v, a = np.array(piece["offset"]), np.zeros(6), np.zeros(6)
        for part in piece["parts"]:
            rate, bend = part["rate"] + part["acceleration"] * t, part["acceleration"]
            sigma = part["s"] - part["begin"] + part["rate"] * t + 0.5 * part["acceleration"] * t * t
            c = np.concatenate([np.array(part["way"]), np.zeros((4 - len(part["way"]), 6))])
            slope = c[1] + sigma * (2 * c[2] + 3 * sigma * c[3])
            q = q + c[0] + sigma * (c[1] + sigma * (c[2] + sigma * c[3]))
            v = v + slope * rate
            a = a + slope * bend + (2 * c[2] + 6 * sigma * c[3]) * rate**2
        rows.append((q, v, a))
    tensions = rig.tensions(*np.array(rows).swapaxes(0, 1))
    return own[tensions.min(axis=1).argmin()], own[tensions.max(axis=1).argmax()]
