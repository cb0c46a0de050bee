"""What the page says of the law that shares the load (C18), tried on proofs that the program wrote: at random motions at
the ends of the tube (D1) is solved in plain floats, and its tensions are compared with what the file claims of them.
"""
import json
import random
from pathlib import Path

import pytest
from flint import ctx

import margins as page
from check_proof import check, prepare
from test_check_proof import (apply, invert, jets, product, put, refused, remade, sealed, several, transpose,
                              value)
from test_disturbances import (corner, cross, minus, norm, plus, pulls_along, rotation, shared, spin, stiffness, tensions,
                               times)

PROOF = Path(__file__).parents[1] / "docs/proofs/eight-margins.json"


def decoded(x):
    """The file's values as floats."""
    if isinstance(x, dict):
        return {key: y if key in ("format", "verdict", "sha256") else decoded(y) for key, y in x.items()}
    if isinstance(x, list):
        return [decoded(y) for y in x]
    return float.fromhex(x) if isinstance(x, str) else x


def shown(rig, span, tau, q, dq, a):
    """The tensions of the unknowns of a motion, those whose equations hold exactly."""
    directions, lengths = pulls_along(rig, q)
    v = transpose([times(l, d + cross(c["attachment"], d)) for c, d, l in zip(rig["cables"], directions, lengths)])
    back, (omega, alpha), inertia = transpose(rotation(q[3:])), spin(q, dq, a), rig["inertia"]
    force = apply(back, minus(times(rig["mass"], minus(a[:3], rig["gravity"])), rig["disturbance"][:3]))
    turn = minus(plus(apply(inertia, alpha), cross(omega, apply(inertia, omega))), apply(back, rig["disturbance"][3:]))
    y = apply(invert(product(v, span["basis"])), minus(force + turn, apply(v, span["base"])))
    off = max(abs(x - value(c, tau)) / e for x, c, e in zip(y, span["solution"], span["error"]))
    return [l * x for l, x in zip(lengths, plus(span["base"], apply(span["basis"], y)))], off


def gap(rig, margins, intrusion, span, q, found):
    """What 2. of (C18) says of this motion alone: by how much the law's tensions differ from those `found` at most, N."""
    z, most = span["multipliers"], 0.0
    room = margins["lawMargin"] - intrusion
    for c, d, u in zip(rig["cables"], pulls_along(rig, q)[0], found):
        reference = c["least"] + min(rig["mass"] * norm(rig["gravity"]), (c["greatest"] - c["least"]) / 2)
        best = reference + sum(x * y for x, y in zip(z, d + cross(c["attachment"], d)))
        x = min(max(best, c["least"] + room), c["greatest"] - room)
        most += (u - x) * ((u + x) / 2 - best)
    return (2 * most) ** 0.5


def attacked(proof, draw, count):
    """Largest shares of what the file claims that motions at the ends of the tube take, by name; none may exceed 1."""
    ctx.prec = 128
    rig, step, margins = [proof["problem"][name] for name in ("rig", "step", "margins")]
    tube = proof["tube"]
    play = [[float(x.rad()) for x in kind] for kind in page.make_tube(prepare(rig, step), margins, tube).play]
    step = step | {"eta": step["eta"] * (1 + 1e-7)}     # `jets` is of different gains
    worst = dict.fromkeys(("error", "distance", "intrusion", "bounds", "pull", "stiffness", "gap"), 0.0)
    for _ in range(count):
        span = draw.choice(proof["spans"])
        first, last = span["from"], span.get("to")
        tau = draw.choice((-1, 1, draw.uniform(-1, 1))) if last else 0.0
        t = (first + last) / 2 + tau * (last - first) / 2 if last else first + draw.choice((0.0, draw.expovariate(1.0)))
        closed = list(map(list, zip(*jets(step, t))))
        q, dq, a = [plus(x, corner(draw, room)) for x, room in zip(closed, play)]
        place = plus(closed[0], corner(draw, play[0]))
        law, (found, off) = tensions(rig, q, dq, a, margins["lawMargin"]), shown(rig, span, tau, q, dq, a)
        lengths = pulls_along(rig, q)[1]
        outside = [max(c["least"] + margins["lawMargin"] - u, u - c["greatest"] + margins["lawMargin"], 0.0)
                   for c, u in zip(rig["cables"], law)]
        middles = [(x + y) / 2 for x, y in zip(span["least"], span["greatest"])]
        bounds = [(abs(u - m) + margins["friction"]) / (y - m) for u, m, y in zip(law, middles, span["greatest"])]
        k = stiffness(rig, place, law)
        shares = {"error": off, "distance": norm(minus(found, law)) / span["distance"],
                  "gap": norm(minus(found, law)) / gap(rig, margins, tube["intrusion"], span, q, found),
                  "intrusion": norm(outside) / tube["intrusion"], "bounds": max(bounds), "pull": sum(law) / tube["pull"],
                  "stiffness": max(abs(x) / y for xs, ys in zip(k, tube["stiffness"]) for x, y in zip(xs, ys))}
        worst = {name: max(x, shares[name]) for name, x in worst.items()}
    return worst


def test_numbers_read_and_written_again_are_accepted():
    proof = decoded(json.loads(PROOF.read_text()))
    assert check(sealed(proof)).verdict == "admissible"


def test_the_law_is_as_near_as_the_file_claims():
    worst = attacked(decoded(json.loads(PROOF.read_text())), random.Random(1), 200)
    assert max(worst.values()) <= 1 + 1e-6, worst
    assert min(worst[name] for name in ("gap", "bounds", "pull", "stiffness")) > 0.2, worst


def test_the_law_has_no_better_neighbours():
    """(D1) as solved here: no change that keeps the wrench makes the objective less."""
    draw = random.Random(2)
    proof = decoded(json.loads(PROOF.read_text()))
    rig, margin = proof["problem"]["rig"], 60.0
    reference = [c["least"] + min(rig["mass"] * norm(rig["gravity"]), (c["greatest"] - c["least"]) / 2) for c in rig["cables"]]
    def cost(u):
        excess = [max(c["least"] + margin - x, x - c["greatest"] + margin, 0.0) for c, x in zip(rig["cables"], u)]
        return norm(minus(u, reference)) ** 2 / 2 + 5e7 * norm(excess) ** 2
    left = 0
    for _ in range(20):
        q = plus([0.0, 0.0, 1.8, 0.0, 0.0, 0.0], corner(draw, [0.9, 0.6, 0.5, 0.1, 0.1, 0.2]))
        u = tensions(rig, q, [0.0] * 6, [0.0] * 6, margin)
        left += min(x - c["least"] for x, c in zip(u, rig["cables"])) < margin
        columns = [d + cross(c["attachment"], d) for c, d in zip(rig["cables"], pulls_along(rig, q)[0])]
        square = invert(product(transpose(columns), columns))
        for _ in range(20):
            change = corner(draw, [draw.random() for _ in u])
            change = minus(change, apply(columns, apply(square, apply(transpose(columns), change))))
            for size in 1e-6, 1e-3, 0.1:
                other = plus(u, times(size, change))
                if all(c["least"] <= x <= c["greatest"] for x, c in zip(other, rig["cables"])):
                    assert cost(other) >= cost(u) - 1e-9 * cost(u)
    assert left > 0


def part_of(x):
    return lambda value: value * x


def no_room(proof):
    """Friction and intrusion that are together more than the law's margin."""
    margins, tube = proof["problem"]["margins"], proof["tube"]
    margins["friction"] = margins["lawMargin"] - tube["intrusion"] / 2


SPAN, TUBE, MARGINS, CABLES = ("spans", 1), ("tube",), ("problem", "margins"), ("problem", "rig", "cables")
CHANGES = [
    # what is changed before the hash is made, condition
    ("distance nought", put(*SPAN, "distance", 0.0), "C18"),
    ("distance negative", put(*SPAN, "distance", lambda x: -x), "C18"),
    ("distance of a fifth", put(*SPAN, "distance", part_of(0.2)), "C18"),
    ("distance of a fifth, at the end", put("spans", -1, "distance", part_of(0.2)), "C18"),
    ("distance without bounds", put(*SPAN, "distance", part_of(1e3)), "C8"),
    ("multipliers nought", put(*SPAN, "multipliers", [0.0] * 6), "C18"),
    ("multipliers turned round", put(*SPAN, "multipliers", lambda z: [-x for x in z]), "C18"),
    ("a multiplier of a torque bent", put("spans", -1, "multipliers", 3, lambda x: x + 1e3), "C18"),
    ("intrusion nought", put(*TUBE, "intrusion", 0.0), "C18"),
    ("intrusion of a half", put(*TUBE, "intrusion", part_of(0.5)), "C18"),
    ("intrusion of all the margin", put(*TUBE, "intrusion", lambda x: 0.5003), "C18"),
    ("friction takes the margin", no_room, "C18"),
    ("a law that keeps nothing", put(*MARGINS, "lawMargin", 0.0), "C18"),
    ("a law that keeps more", put(*MARGINS, "lawMargin", 60.0), "C18"),
    ("a law that keeps more than there is", put(*MARGINS, "lawMargin", 300.0), "C18"),
    ("a reference without greatest tension", put(*CABLES, 3, "greatest", float("inf")), "C18"),
    ("a bound that friction takes", several(put(*SPAN, "least", lambda x: [y + 0.011 for y in x]), remade), "C8"),
    ("a bound of the tensions shown", several(put(*SPAN, "greatest", 2, part_of(0.8)), remade), "C8"),
    ("pull of the tensions shown", put(*TUBE, "pull", part_of(0.7)), "C16"),
    ("stiffness of the tensions shown", put(*TUBE, "stiffness", lambda k: [[0.3 * x for x in row] for row in k]), "C16"),
    ("intrusion negative", put(*TUBE, "intrusion", -0.01), "C2"),
    ("law's margin negative", put(*MARGINS, "lawMargin", -0.5), "C2"),
    ("no law's margin", lambda proof: proof["problem"]["margins"].pop("lawMargin"), "C1"),
    ("no intrusion", lambda proof: proof["tube"].pop("intrusion"), "C1"),
    ("no distance", lambda proof: proof["spans"][1].pop("distance"), "C1"),
    ("no multipliers", lambda proof: proof["spans"][-1].pop("multipliers"), "C1"),
    ("distance without margins", lambda proof: [proof.pop("tube"), proof["problem"].pop("margins")], "C1"),
]


@pytest.mark.parametrize("name, change, condition", CHANGES, ids=[c[0] for c in CHANGES])
def test_shares_that_are_bent_are_refused(name, change, condition):
    proof = decoded(json.loads(PROOF.read_text()))
    change(proof)
    assert refused(sealed(proof)) == condition
