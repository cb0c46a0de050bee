"""Tests of motions in pieces (motions.py), made here in floats with formulas other than the checker's: s by exponentials, spans by the maker of test_check_proof.py."""
import cmath
import json
import math

import pytest
from flint import arb, ctx

import motions
from check_proof import check
from test_check_proof import coded, make_rig, make_span, put, refused, remade, sealed, several

WAY = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.1, 0.05, -0.1, 0.02, -0.03, 0.1], [0.0, 0.02, 0.01, 0.0, 0.01, 0.0],
       [0.003, 0.0, 0.0, 0.001, 0.0, 0.002]]


def part(beta=0.0, jerk=0.0, way=WAY, begin=0.2, s=0.3, rate=0.7, acceleration=-0.4):
    return {"way": way, "begin": begin, "s": s, "rate": rate, "acceleration": acceleration, "beta": beta, "jerk": jerk}


def along(fields, t):
    """s, s', s'' of a part."""
    s, v, a, beta, j = (fields[name] for name in ("s", "rate", "acceleration", "beta", "jerk"))
    if beta == 0:
        return s + v * t + a * t ** 2 / 2 + j * t ** 3 / 6, v + a * t + j * t ** 2 / 2, a + j * t
    k = cmath.sqrt(beta)        # s - s0 + a/beta = p e^(kt) + q e^(-kt)
    p, q = (a / beta + v / k) / 2, (a / beta - v / k) / 2
    x, y = p * cmath.exp(k * t), q * cmath.exp(-k * t)
    return (s - a / beta + x + y).real, (k * (x - y)).real, (beta * (x + y)).real


def jets(piece, t):
    """[(q, q', q'')] of a piece."""
    found = []
    for i, offset in enumerate(piece["offset"]):
        total = [offset, 0.0, 0.0]
        for fields in piece["parts"]:
            s, ds, dds = along(fields, t)
            x, c = s - fields["begin"], [row[i] for row in fields["way"]]
            slope = sum(k * y * x ** (k - 1) for k, y in enumerate(c) if k > 0)
            bend = sum(k * (k - 1) * y * x ** (k - 2) for k, y in enumerate(c) if k > 1)
            for n, y in enumerate((sum(y * x ** k for k, y in enumerate(c)), slope * ds, slope * dds + bend * ds ** 2)):
                total[n] += y
        found.append(tuple(total))
    return found


PARTS = {"beta above": part(beta=5.0), "beta below": part(beta=-7.0), "jerk": part(jerk=3.0), "straight": part(way=WAY[:2]),
         "still": part(rate=0.0, acceleration=0.0), "beta tiny": part(beta=-1e-5)}


@pytest.mark.parametrize("name", PARTS)
def test_coordinates_are_those_of_the_closed_form(name):
    piece = {"duration": 0.6, "offset": [0.01, 0.0, -0.2, 0.0, 0.5, 0.0], "parts": [PARTS[name], part(beta=2.0, way=WAY[:1])]}
    ctx.prec, ctx.cap = 128, 9
    (balls,) = motions.prepare({"pieces": [piece]})
    for time, tolerance in (arb(0.25), 1e-10), (arb(0.25, 0.05), None):
        found = motions.coordinates(balls, time, arb(0.05))
        for x in -1.0, -0.3, 0.8:
            for series, expected in zip(zip(*found), jets(piece, 0.25 + 0.05 * x)):
                for y, number in zip(series, expected):
                    if tolerance:       # the series in its middle
                        assert abs(float(sum((c * arb(x) ** n for n, c in enumerate(y.coeffs())), arb(0))) - number) < 1e-7
                    else:               # its first coefficient over all of the span
                        assert y[0].lower() - 1e-9 <= number <= y[0].upper() + 1e-9


def test_a_tiny_beta_loses_nothing():
    """cosh - 1 over beta, where beta is beyond the rounding of 128 bits."""
    ctx.prec, ctx.cap = 128, 3
    (piece,) = motions.prepare({"pieces": [{"duration": 1.0, "offset": [0.0] * 6, "parts": [part(beta=1e-200, way=WAY[:2])]}]})
    q, _, _ = motions.coordinates(piece, arb(0.5), arb(1))
    assert float(q[0][0].rad()) < 1e-30
    assert math.isclose(float(q[0][0]), 0.1 * (0.3 - 0.2 + 0.35 - 0.05), rel_tol=1e-12)


# --- A motion from rest to rest: begun with a jerk, braked by a spring, braked evenly; the second part only lifts ---

LIFT = [[0.0] * 6, [0.0, 0.0, -0.05, 0.0, 0.0, 0.0]]
WAY_BACK = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.3, 0.1, -0.1, 0.05, -0.05, 0.2], [0.0, 0.05, 0.02, 0.0, 0.03, 0.0]]
DURATIONS = 0.4, 0.5, 0.25


def make_motion():
    pieces, states = [], [(0.0, 0.0), (0.0, 0.0)]
    for number, duration in enumerate(DURATIONS):
        parts = []
        for k, (way, (s, v)) in enumerate(zip((WAY_BACK, LIFT), states)):
            brake = -v / duration
            how = [{"acceleration": 1.5, "jerk": -2.0}, {"acceleration": -0.2, "beta": -3.0}, {"acceleration": brake}][number]
            if k == 1:
                how = [{"acceleration": 1.0}, {"acceleration": 0.1, "beta": 0.5}, {"acceleration": brake}][number]
            parts.append(part(way=way, begin=0.05, **{"s": s, "rate": v} | {"acceleration": 0.0} | how))
        states = [along(fields, duration)[:2] for fields in parts]
        pieces.append({"duration": duration, "offset": [0.0, 0.0, 0.01, 0.0, 0.0, 0.02], "parts": parts})
    return pieces


def make_proof(n, pulley=False):
    pieces, rig, spans = make_motion(), make_rig(n, pulley), []
    for number, piece in enumerate(pieces, 1):
        problem = {"rig": rig, "step": lambda t, piece=piece: jets(piece, t)}
        cuts = [piece["duration"] * k / 3 for k in range(3)] + [piece["duration"]]
        spans += [{"piece": number, **make_span(problem, a, b)} for a, b in zip(cuts, cuts[1:])]
    rest = [(q, 0.0, 0.0) for q, _, _ in jets(pieces[-1], pieces[-1]["duration"])]
    spans.append(make_span({"rig": rig, "step": lambda t: rest}, 0.0, None))
    del spans[-1]["from"]
    proof = {"format": "cable-robot proof", "version": 1, "problem": {"rig": rig, "motion": {"pieces": pieces}},
             "verdict": "admissible", "jump": [1e-14, 1e-13], "spans": spans}
    remade(proof)
    return proof


SIX, PULLEYS, EIGHT = make_proof(6), make_proof(6, pulley=True), make_proof(8)


@pytest.mark.parametrize("proof", [SIX, PULLEYS, EIGHT], ids=["six", "pulleys", "eight"])
def test_honest_proofs_of_motions_are_accepted(proof):
    assert check(sealed(proof)).verdict == "admissible"


def of_all_pieces(change):
    """A change of each part of the same number, so that the pieces still join."""
    return lambda proof: [change(piece["parts"][0]) for piece in proof["problem"]["motion"]["pieces"]]


def without(*numbers):
    return lambda proof: proof.update(spans=[span for k, span in enumerate(proof["spans"], 1) if k not in numbers])


PIECES = ("problem", "motion", "pieces")
PART = (*PIECES, 1, "parts", 0)
CHANGES = [
    # name, proof, what is changed before the hash is made, condition
    ("a step besides", SIX, put("problem", "step", {}), "C1"),
    ("no motion", SIX, lambda p: p["problem"].pop("motion"), "C1"),
    ("not admissible", SIX, put("verdict", "not admissible"), "C1"),
    ("no jump", SIX, lambda p: p.pop("jump"), "C1"),
    ("no piece", SIX, put(*PIECES, []), "C1"),
    ("no part", SIX, put(*PIECES, 0, "parts", []), "C1"),
    ("five parts", SIX, put(*PIECES, 0, "parts", lambda parts: parts[:1] * 5), "C1"),
    ("a way of five", SIX, put(*PART, "way", lambda way: way[:1] * 5), "C1"),
    ("a span of no piece", SIX, lambda p: p["spans"][2].pop("piece"), "C1"),
    ("a piece that is no whole number", SIX, put("spans", 2, "piece", "0x1p+0"), "C1"),
    ("the rest of a piece", SIX, put("spans", -1, "piece", 3), "C1"),
    ("the rest from a time on", SIX, put("spans", -1, "from", 0.0), "C1"),
    ("the rest not constant", SIX, put("spans", -1, "solution", 0, lambda c: [*c, 0.0]), "C1"),
    ("no rest", SIX, without(10), "C1"),
    ("beta and jerk", SIX, put(*PART, "jerk", 0.1), "C2"),
    ("no duration", SIX, put(*PIECES, 1, "duration", 0.0), "C2"),
    ("no mass", SIX, put("problem", "rig", "mass", 0.0), "C2"),
    ("a late start", SIX, put("spans", 0, "from", 1e-9), "C14"),
    ("a late start of a piece", SIX, put("spans", 3, "from", 1e-9), "C14"),
    ("the first span dropped", SIX, without(1), "C14"),
    ("a span dropped within", SIX, without(5), "C14"),
    ("the last span of a piece dropped", SIX, without(6), "C14"),
    ("the last span of all dropped", SIX, without(9), "C14"),
    ("a piece dropped", SIX, without(4, 5, 6), "C14"),
    ("the last piece dropped", SIX, without(7, 8, 9), "C14"),
    ("only the rest", SIX, without(*range(1, 10)), "C14"),
    ("a gap", SIX, put("spans", 4, "to", lambda x: x - 1e-9), "C14"),
    ("a span of no length", SIX, put("spans", 4, "to", SIX["spans"][4]["from"]), "C14"),
    ("piece 0", SIX, lambda p: [span.update(piece=0) for span in p["spans"][:3]], "C14"),
    ("piece 4", SIX, lambda p: [span.update(piece=4) for span in p["spans"][6:9]], "C14"),
    ("the pieces in another order", SIX, lambda p: p["spans"].insert(0, p["spans"].pop(3)), "C14"),
    ("back to the piece before", SIX, lambda p: p["spans"].insert(4, p["spans"].pop(2)), "C14"),
    ("a piece longer", SIX, put(*PIECES, 1, "duration", lambda x: x + 1e-9), "C14"),
    ("a piece shorter", SIX, put(*PIECES, 1, "duration", lambda x: x - 1e-9), "C15"),
    ("no jump of coordinates allowed", SIX, put("jump", 0, 0.0), "C15"),
    ("no jump of rates allowed", EIGHT, put("jump", 1, 0.0), "C15"),
    ("a coefficient bent", SIX, put(*PART, "way", 1, 3, lambda x: x + 1e-9), "C15"),
    ("an offset bent", SIX, put(*PIECES, 2, "offset", 4, 1e-9), "C15"),
    ("a rate bent", SIX, put(*PART, "rate", lambda x: x + 1e-9), "C15"),
    ("moving at the beginning", SIX, put(*PIECES, 0, "parts", 1, "rate", 1e-9), "C15"),
    ("moving at the end", SIX, put(*PIECES, 2, "parts", 0, "acceleration", lambda x: x + 1e-9), "C15"),
    ("a coefficient bent of all pieces", SIX, of_all_pieces(lambda part: put("way", 1, 3, lambda x: x + 1e-3)(part)), "C7"),
    ("a coefficient bent of all pieces, pulleys", PULLEYS, of_all_pieces(lambda part: put("way", 2, 2, 0.021)(part)), "C7"),
    ("an acceleration and nothing to show for it", SIX, several(put(*PIECES, 1, "parts", 0, "acceleration", 3.0), put("jump", [9.0, 9.0])), "C7"),
    ("another beta", SIX, several(put(*PART, "beta", 3.0), put("jump", [9.0, 9.0])), "C7"),
    ("another jerk", EIGHT, several(put(*PIECES, 0, "parts", 0, "jerk", -1.9), put("jump", [9.0, 9.0])), "C7"),
    ("a longer last piece, so another rest", SIX, several(put(*PIECES, 2, "duration", 0.2), put("jump", [9.0, 9.0])), "C7"),
    ("a polynomial bent", EIGHT, put("spans", 4, "solution", 3, 1, lambda x: x + 1e-3), "C7"),
    ("the rest bent", SIX, put("spans", -1, "solution", 0, 0, lambda x: x + 0.5), "C7"),
    ("a bound too high", SIX, several(put("spans", 4, "least", 2, lambda x: x + 0.3), remade), "C8"),
    ("a bound of the rest too high", SIX, several(put("spans", -1, "least", 2, lambda x: x + 0.3), remade), "C8"),
    ("at the lower limit", SIX, put("problem", "rig", "cables", 4, "least", min(s["least"][4] for s in SIX["spans"])), "C9"),
    ("least of all wrong", PULLEYS, put("least", lambda x: x - 1e-9), "C10"),
]


@pytest.mark.parametrize("name, proof, change, condition", CHANGES, ids=[c[0] for c in CHANGES])
def test_what_is_bent_of_a_motion_is_refused(name, proof, change, condition):
    proof = json.loads(json.dumps(proof))
    change(proof)
    assert refused(sealed(proof)) == condition


def test_another_motion_under_the_old_hash_is_refused():
    proof = json.loads(sealed(SIX))
    proof["problem"]["motion"]["pieces"][1]["duration"] = coded(0.51)
    assert refused(json.dumps(proof)) == "C3"


def test_the_jump_of_a_step_is_refused():
    step = {"start": [0.0] * 6, "rates": [0.0] * 6, "setPoint": [0.0] * 6, "lambda": 2.0, "eta": 3.0}
    proof = json.loads(json.dumps(SIX)) | {"problem": {"rig": SIX["problem"]["rig"], "step": step}}
    assert refused(sealed(proof)) == "C1"
