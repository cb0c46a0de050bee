"""The moves that are compared: random, from rest to rest, the same in each run."""

import numpy as np

SEED = 1
NORMALS = np.array([[np.cos(a), np.sin(a)] for a in np.radians([150, 90, -90, 210, 30, -30])])
APOTHEM = 0.18  # m, of the hexagon that poses are drawn from; that of the static workspace is 0.225 m


def pose(rng, height, turn):
    """Of the paper's rig, where it can rest."""
    while True:
        point = rng.uniform(-0.25, 0.25, 2)
        if (NORMALS @ point < APOTHEM).all():
            return np.array([*point, rng.uniform(1 - height, 1 + height), *rng.uniform(-turn, turn, 3)])


def pairs(rng, count, *extent):
    return [(pose(rng, *extent), pose(rng, *extent)) for _ in range(count)]


def of_the_papers_rig():
    """Title and moves."""
    rng = np.random.default_rng(SEED)
    return {
        "The paper's move": [(np.array([0, 0, 1.0, 0, 0, 0]), np.array([0.15, 0.15, 1.0, 0, 0, 0]))],
        "Level moves": pairs(rng, 100, 0, 0),
        "Moves in space": pairs(rng, 20, 0.3, 0),
        "Turned moves": pairs(rng, 20, 0.2, 0.15),
    }


KINDS = {"level": (0, 0), "space": (0.3, 0), "turned": (0.2, 0.15)}  # of moves of the paper's rig: height (m) and turn (rad)


def of_all_kinds(count):
    """Kind, number, start and goal, one of each kind in turn; more moves begin with the same ones."""
    most = -(-count // len(KINDS))
    drawn = {kind: pairs(np.random.default_rng([SEED, k]), most, *extent) for k, (kind, extent) in enumerate(KINDS.items())}
    return [(kind, k, *drawn[kind][k]) for k in range(most) for kind in KINDS][:count]


def of_cogiro(rig):
    """Turned and in space, about the home of the rig with eight cables."""
    rng = np.random.default_rng(SEED)
    extent = np.array([2.0, 1.5, 0.5, 0.1, 0.1, 0.1])
    any_pose = lambda: rig.home + rng.uniform(-extent, extent)
    return {"CoGiRo, eight cables": [(any_pose(), any_pose()) for _ in range(20)]}
