"""Tests of (C16), (C17) and what else margins ask, with proofs made here, in floats, from random motions in the tube.

The maker samples: tensions, lengths and K (by differences) of motions at the ends of the tube, and claims some more.
"""
import functools
import json
import math
import random

import pytest

from check_proof import check
from test_check_proof import OVERLOADED, SHORT, jets, make_admissible, put, refused, remade, sealed, several, value
from test_disturbances import WRONG, corner, floats, measures, plus, pulls_along, settle, tensions

SMALL = {name: x / 4 for name, x in WRONG.items()}


def motions(problem, play, times, draw):
    """Samples (t, q, tensions) at ends of the tube."""
    found = []
    for t in times:
        q, dq, ddq = [plus(x, corner(draw, room)) for x, room in zip(map(list, zip(*jets(problem["step"], t))), play)]
        found.append((t, q, tensions(problem["rig"], q, dq, ddq)))
    return found


def roomy(claim, more=0.25):
    """What is claimed of the tube where samples show this: `error` lets tensions differ by more than they do."""
    most = max(max(row) for row in claim["stiffness"])
    found = {"pull": (1 + more) * claim["pull"], "shortest": 0.95 * claim["shortest"],
             "stiffness": [[(1 + more) * x + more * most for x in row] for row in claim["stiffness"]]}
    return found | ({"sideways": 0.95 * claim["sideways"]} if "sideways" in claim else {})


@functools.cache
def made(pulley=False):
    """Text of an honest proof with margins, before its numbers are coded."""
    draw, proof = random.Random(3), make_admissible(6, pulley)
    problem = proof["problem"]
    problem["margins"], play = SMALL, [[0.0] * 6] * 3
    for _ in range(3):
        seen = motions(problem, play, [0.1 * k for k in range(40)] + [1e3], draw)
        claim = roomy(measures(problem, [sample[1:] for sample in seen]))
        tube, _ = settle(problem, SMALL, claim)
        play = [[float(x.rad()) for x in kind] for kind in tube.play]
    proof["tube"] = tube.claim
    for span in proof["spans"]:
        first, last = span["from"], span.get("to")
        middle, half = (first + last) / 2 if last else 0.0, (last - first) / 2 if last else math.inf
        times = [first + (last - first) * k / 30 for k in range(31)] if last else [first + 0.1 * k for k in range(40)] + [1e3]
        off, pulls, longest = [0.0] * 6, [], 0.0
        for t, q, u in motions(problem, play, times, draw):
            lengths = pulls_along(problem["rig"], q)[1]
            guess = [value(c, (t - middle) / half) for c in span["solution"]]
            off = [max(o, abs(x / l - g)) for o, x, l, g in zip(off, u, lengths, guess)]
            pulls.append(u)
            longest = max(longest, *lengths)
        span["error"] = [8 * x + e for x, e in zip(off, span["error"])]
        wide = [max(p) - min(p) + SMALL["friction"] + longest * e for p, e in zip(zip(*pulls), span["error"])]
        span["least"] = [min(p) - x for p, x in zip(zip(*pulls), wide)]
        span["greatest"] = [max(p) + x for p, x in zip(zip(*pulls), wide)]
    remade(proof)
    return json.dumps(proof)


def bent(change, pulley=False):
    proof = json.loads(made(pulley))
    change(proof)
    return refused(sealed(proof))


def part_of(x):
    return lambda value: value * x


TUBE, MARGINS, SPANS = ("tube",), ("problem", "margins"), ("spans",)
CHANGES = [
    # name, pulleys, what is changed before the hash is made, condition
    ("D halved", False, put(*TUBE, "disturbance", lambda d: [x / 2 for x in d]), "C17"),
    ("one D smaller", True, put(*TUBE, "disturbance", 4, part_of(0.97)), "C17"),
    ("D nought", False, put(*TUBE, "disturbance", [0.0] * 6), "C17"),
    ("the tube is left", False, put(*TUBE, "disturbance", lambda d: [6 * x for x in d]), "C7"),
    ("pull of less than the weight takes", False, put(*TUBE, "pull", part_of(0.75)), "C16"),
    ("pull of less than the weight takes, pulleys", True, put(*TUBE, "pull", part_of(0.75)), "C16"),
    ("shortest longer than a cable", False, put(*TUBE, "shortest", part_of(1.06)), "C16"),
    ("sideways farther than a cable", True, put(*TUBE, "sideways", part_of(1.06)), "C16"),
    ("stiffness that does not hold", False, put(*TUBE, "stiffness", 2, 5, part_of(0.6)), "C16"),
    ("stiffness that does not hold, place", False, put(*TUBE, "stiffness", 1, 0, part_of(0.6)), "C16"),
    ("stiffness that does not hold, pulleys", True, put(*TUBE, "stiffness", 0, 3, part_of(0.6)), "C16"),
    ("no stiffness", False, put(*TUBE, "stiffness", [[0.0] * 6] * 3), "C16"),
    ("stiffness without bounds", False, put(*TUBE, "stiffness", [[1e9] * 6] * 3), "C17"),
    ("shortest within the accuracy", False, put(*TUBE, "shortest", 1e-6), "C17"),
    ("sideways within the pulley", True, put(*TUBE, "sideways", 0.03), "C17"),
    ("inertia that may be nought", False, several(put("problem", "rig", "inertia", 0, 1, 0.24), put("problem", "rig", "inertia", 1, 0, 0.24),
                                                  put(*MARGINS, "mass", 0.1)), "C17"),
    ("another start within the angles", False, put("problem", "step", "start", 4, math.pi / 2 - 0.005), "C4"),
    ("bound narrowed", False, several(put(*SPANS, 3, "least", 2, lambda x: x + 2.5), remade), "C8"),
    ("bound narrowed above, pulleys", True, several(put(*SPANS, -1, "greatest", 0, lambda x: x - 2.5), remade), "C8"),
    ("error of the closed form", False, put(*SPANS, 3, "error", lambda e: [x / 20 for x in e]), "C7"),
    ("negative D", False, put(*TUBE, "disturbance", 2, -1.0), "C2"),
    ("negative shortest", False, put(*TUBE, "shortest", -100.0), "C2"),
    ("shortest nought", False, put(*TUBE, "shortest", 0.0), "C2"),
    ("negative sideways", True, put(*TUBE, "sideways", -1.0), "C2"),
    ("negative stiffness", False, put(*TUBE, "stiffness", 0, 0, -1.0), "C2"),
    ("negative margin", False, put(*MARGINS, "friction", -0.01), "C2"),
    ("all of the mass", False, put(*MARGINS, "mass", 1.0), "C2"),
    ("more than six cables", False, put("problem", "rig", "cables", lambda c: c + c[:1]), "C1"),
    ("law's margin of six cables", False, put(*MARGINS, "lawMargin", 0.5), "C1"),
    ("intrusion of six cables", False, put(*TUBE, "intrusion", 0.1), "C1"),
    ("no tube", False, lambda proof: proof.pop("tube"), "C1"),
    ("a tube without margins", False, lambda proof: proof["problem"].pop("margins"), "C1"),
    ("a margin missing", False, lambda proof: proof["problem"]["margins"].pop("delay"), "C1"),
    ("a margin more", False, put(*MARGINS, "luck", 1.0), "C1"),
    ("more in the tube", False, put(*TUBE, "length", 1.0), "C1"),
    ("sideways without pulleys", False, put(*TUBE, "sideways", 1.0), "C1"),
    ("no sideways", True, lambda proof: proof["tube"].pop("sideways"), "C1"),
    ("five numbers of D", False, put(*TUBE, "disturbance", lambda d: d[:5]), "C1"),
    ("stiffness of one row", False, put(*TUBE, "stiffness", lambda k: k[:1]), "C1"),
] + [(f"{name} raised", pulley, put(*MARGINS, name, part_of(4)), "C17") for name in SMALL for pulley in (False, True)]


@pytest.mark.parametrize("name, pulley, change, condition", CHANGES, ids=[c[0] for c in CHANGES])
def test_margins_that_are_bent_are_refused(name, pulley, change, condition):
    assert bent(change, pulley) == condition


@pytest.mark.parametrize("pulley", [False, True])
def test_an_honest_proof_with_margins_is_accepted(pulley):
    assert check(sealed(json.loads(made(pulley)))).verdict == "admissible"


def test_margins_of_nought_prove_what_the_closed_form_does():
    proof = make_admissible(6)
    claim = measures(proof["problem"], [sample[1:] for sample in motions(proof["problem"], [[0.0] * 6] * 3, [0.1 * k for k in range(40)], random.Random(1))])
    proof["problem"]["margins"] = dict.fromkeys(SMALL, 0.0)
    proof["tube"] = roomy(claim) | {"disturbance": [0.0] * 6}
    assert check(sealed(proof)).verdict == "admissible"


def test_friction_that_the_bounds_ignore_is_refused():
    """Friction that only the bounds see: D has room for it."""
    proof = json.loads(made())
    for span in proof["spans"]:
        span["least"], span["greatest"] = [x + 4 for x in span["least"]], [x - 4 for x in span["greatest"]]
    remade(proof)
    assert refused(sealed(proof)) == "C8"


def test_a_margin_that_is_no_number_is_refused():
    text = sealed(json.loads(made()))
    friction = json.loads(text)["problem"]["margins"]["friction"]
    for other in ('NaN', '"nan"', '"inf"', '0.001', 'null'):
        assert refused(text.replace(f'"friction": "{friction}"', f'"friction": {other}')) == "C1"


def test_margins_of_what_is_not_admissible_say_nothing_more():
    for proof, more in (OVERLOADED, {}), (SHORT, {"lawMargin": 0.2}):
        proof = json.loads(json.dumps(proof))
        proof["problem"]["margins"] = SMALL | more
        assert check(sealed(proof)).verdict == "not admissible"
        proof["tube"] = json.loads(made())["tube"]
        assert refused(sealed(proof)) == "C1"
