"""Tests of check_proof.py with proofs made here, in floats, with formulas other than the checker's.

The maker writes each quantity in another form than the page does: the motion as two exponentials,
angular velocities from derivatives of R, pulleys in the base frame with angles.
"""
import hashlib
import json
import math
import os
import random
import subprocess
import sys

import pytest

from check_proof import Refused, check
from proof_file import spelling

HERE = os.path.dirname(os.path.abspath(__file__))


# --- The model in floats -------------------------------------------------------------------

def jets(step, t):
    """Coordinates and their first two derivatives: [(q, q', q'')], of different gains; or of a function of time."""
    if callable(step):
        return step(t)
    slow, fast = sorted((step["lambda"], step["eta"]))
    found = []
    for start, place, v in zip(step["start"], step["setPoint"], step["rates"]):
        e = start - place
        if len(found) > 2:
            e = math.remainder(e, math.tau)
        a, b = (fast * e + v) / (fast - slow), -(slow * e + v) / (fast - slow)
        x, y = a * math.exp(-slow * t), b * math.exp(-fast * t)
        found.append((place + x + y, -slow * x - fast * y, slow ** 2 * x + fast ** 2 * y))
    return found


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def plus(*matrices):
    return [[sum(entries) for entries in zip(*rows)] for rows in zip(*matrices)]


def transpose(a):
    return [list(row) for row in zip(*a)]


def turns(angle, axis):
    """Rotation about an axis (0 to 2) and its first two derivatives."""
    x, dx, ddx = angle
    s, c = math.sin(x), math.cos(x)
    found = []
    for p, q, unit in (c, s, 1), (-s * dx, c * dx, 0), (-c * dx * dx - s * ddx, -s * dx * dx + c * ddx, 0):
        matrix = [[0.0] * 3 for _ in range(3)]
        matrix[axis][axis] = unit
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix[i][i] = matrix[j][j] = p
        matrix[i][j], matrix[j][i] = -q, q
        found.append(matrix)
    return found


def compose(a, b):
    """Product of matrices with first two derivatives."""
    middle = product(a[1], b[1])
    return [product(a[0], b[0]), plus(product(a[1], b[0]), product(a[0], b[1])),
            plus(product(a[2], b[0]), middle, middle, product(a[0], b[2]))]


def apply(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector)) for row in matrix]


def cross(a, b):
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def leaving(cable, end):
    """Where the cable to `end` leaves its anchor, base frame."""
    if "pulley" not in cable:
        return cable["anchor"]
    r, k = cable["pulley"]["radius"], cable["pulley"]["axis"]
    away = [x - a for x, a in zip(end, cable["anchor"])]
    height = sum(x * y for x, y in zip(away, k))
    out = [x - height * y for x, y in zip(away, k)]
    e = math.hypot(*out)
    angle = math.atan2(height, e - r) + math.acos(r / math.hypot(height, e - r))
    return [a + r * (1 + math.cos(angle)) * x / e + r * math.sin(angle) * y
            for a, x, y in zip(cable["anchor"], out, k)]


def state(problem, t):
    """V (6 rows), lengths and w, platform's frame."""
    rig, q = problem["rig"], jets(problem["step"], t)
    r, dr, ddr = compose(compose(turns(q[5], 2), turns(q[4], 1)), turns(q[3], 0))
    back = transpose(r)
    columns, lengths = [], []
    for cable in rig["cables"]:
        end = [x[0] + y for x, y in zip(q, apply(r, cable["attachment"]))]
        v = apply(back, [a - x for a, x in zip(leaving(cable, end), end)])
        columns.append(v + cross(cable["attachment"], v))
        lengths.append(math.hypot(*v))
    spin, acceleration = product(back, dr), plus(product(back, ddr), product(transpose(dr), dr))
    spin, acceleration = [[m[2][1], m[0][2], m[1][0]] for m in (spin, acceleration)]
    f, n = rig["disturbance"][:3], rig["disturbance"][3:]
    force = apply(back, [rig["mass"] * (x[2] - g) - y for x, g, y in zip(q, rig["gravity"], f)])
    torque = [a + b - c for a, b, c in zip(apply(rig["inertia"], acceleration),
                                           cross(spin, apply(rig["inertia"], spin)), apply(back, n))]
    return transpose(columns), lengths, force + torque


# --- The maker -----------------------------------------------------------------------------

def invert(a):
    """Inverse of a matrix (Gauss and Jordan)."""
    n = len(a)
    rows = [list(row) + [float(i == j) for j in range(n)] for i, row in enumerate(a)]
    for i in range(n):
        best = max(range(i, n), key=lambda j: abs(rows[j][i]))
        rows[i], rows[best] = rows[best], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for j in range(n):
            if j != i:
                rows[j] = [x - rows[j][i] * y for x, y in zip(rows[j], rows[i])]
    return [row[n:] for row in rows]


def instant_solution(problem, base, basis, t):
    """V B, w - V sigma, the unknowns y and the lengths."""
    v, lengths, w = state(problem, t)
    matrix = product(v, basis)
    right = [x - y for x, y in zip(w, apply(v, base))]
    y = apply(invert(matrix), right)
    off = [b - x for b, x in zip(right, apply(matrix, y))]
    return matrix, right, [a + b for a, b in zip(y, apply(invert(matrix), off))], lengths


def value(c, x):
    return sum(a * x ** k for k, a in enumerate(c))


def make_span(problem, t1, t2, room=4):
    """A span; `t2` None for the last."""
    n = len(problem["rig"]["cables"])
    last = t2 is None
    middle, half = (t1, 0.0) if last else ((t1 + t2) / 2, (t2 - t1) / 2)
    span = {"from": t1} if last else {"from": t1, "to": t2}
    if n > 6:
        v, lengths, _ = state(problem, 1e3 if last else middle)
        span["base"], span["basis"] = [20 / x for x in lengths], transpose(v)
    base, basis = span.get("base", [0.0] * 6), span.get("basis", [[float(i == j) for j in range(6)] for i in range(6)])
    matrix, _, limit, _ = instant_solution(problem, base, basis, 1e3 if last else middle)
    span["inverse"] = invert(matrix)
    if last:
        span["solution"] = [[x] for x in limit]
        times = [(t1 + 0.05 * k, 0.0) for k in range(100)] + [(1e3, 0.0)]
    else:
        nodes = [math.cos(math.pi * (k + 0.5) / 6) for k in range(6)]
        inverse = invert([[x ** k for k in range(6)] for x in nodes])
        samples = [instant_solution(problem, base, basis, middle + half * x)[2] for x in nodes]
        span["solution"] = [apply(inverse, y) for y in zip(*samples)]
        times = [(middle + half * k / 20, k / 20) for k in range(-20, 21)]
    found = [(x, *instant_solution(problem, base, basis, t)) for t, x in times]
    worst, rho = [0.0] * 6, [0.0] * 6
    for x, matrix, right, _, _ in found:
        guess = [value(c, x) for c in span["solution"]]
        r = apply(span["inverse"], [b - a for b, a in zip(right, apply(matrix, guess))])
        defect = product(span["inverse"], matrix)
        worst = [max(a, abs(b)) for a, b in zip(worst, r)]
        rho = [max(old, sum(abs((k == j) - a) for j, a in enumerate(row)))
               for k, (old, row) in enumerate(zip(rho, defect))]
    assert max(rho) < 0.9
    span["error"] = [room * (a + b * max(worst) / (1 - max(rho))) + 1e-12 for a, b in zip(worst, rho)]
    pulls = [[l * (s + sum(b * value(c, x) for b, c in zip(row, span["solution"])))
              for l, s, row in zip(lengths, base, basis)] for x, _, _, _, lengths in found]
    slack = [max(f[4][i] for f in found) * sum(abs(b) * e for b, e in zip(basis[i], span["error"])) * 1.02 + 1e-9
             for i in range(n)]
    wide = [(max(p) - min(p)) * 0.01 for p in zip(*pulls)]
    span["least"] = [min(p) - s - x for p, s, x in zip(zip(*pulls), slack, wide)]
    span["greatest"] = [max(p) + s + x for p, s, x in zip(zip(*pulls), slack, wide)]
    return span


def make_rig(n, pulley=False):
    rig = {"mass": 6.0, "inertia": [[0.2, 0.01, 0.0], [0.01, 0.25, 0.0], [0.0, 0.0, 0.3]],
           "gravity": [0.0, 0.0, 9.81], "disturbance": [0.0] * 6, "cables": []}
    for i in range(n):
        corner = i // 2
        a = 2 * math.tau * corner / n + (i % 2 - 0.5) * 0.1
        b = 2 * math.tau * (corner + i % 2 - 0.5) / n - (i % 2 - 0.5) * 0.1
        cable = {"anchor": [1.2 * math.cos(a), 1.2 * math.sin(a), 0.0],
                 "attachment": [0.3 * math.cos(b), 0.3 * math.sin(b), -0.05 if n == 6 else 0.1 * (-1) ** i],
                 "least": 0.5, "greatest": 200.0}
        if pulley:
            cable["pulley"] = {"radius": 0.03, "axis": [0.0, 0.0, 1.0]}
        rig["cables"].append(cable)
    return rig


def make_step():
    return {"start": [0.0, 0.0, 1.0, 0.02, -0.03, 0.1], "rates": [0.05, 0.0, -0.02, 0.0, 0.1, 0.0],
            "setPoint": [0.1, 0.05, 0.9, 0.0, 0.0, 0.0], "lambda": 2.0, "eta": 3.0}


def coded(value):
    """The values of a file with floats as the format spells them."""
    if isinstance(value, dict):
        return {key: coded(x) for key, x in value.items()}
    if isinstance(value, list):
        return [coded(x) for x in value]
    if isinstance(value, float):
        return "inf" if value == math.inf else spelling(value)
    return value


def sealed(proof):
    """The file's text, hash and the least and greatest of all spans made right."""
    proof = coded(proof)
    text = json.dumps(proof["problem"], sort_keys=True, separators=(",", ":"))
    proof["sha256"] = hashlib.sha256(text.encode()).hexdigest()
    return json.dumps(proof)


def make_admissible(n, pulley=False, ends=(0.0, 0.15, 0.3, 0.5, 0.7, 0.9, 1.2, 1.5, 2.0, 2.5, 3.0)):
    problem = {"rig": make_rig(n, pulley), "step": make_step()}
    spans = [make_span(problem, a, b) for a, b in zip(ends, ends[1:] + (None,))]
    return {"format": "cable-robot proof", "version": 1, "problem": problem, "verdict": "admissible",
            "least": min(min(s["least"]) for s in spans), "greatest": max(max(s["greatest"]) for s in spans),
            "spans": spans}


def make_overloaded(t=0.3):
    """Not admissible, six cables."""
    problem = {"rig": make_rig(6), "step": make_step()}
    unit = [[float(i == j) for j in range(6)] for i in range(6)]
    matrix, _, y, lengths = instant_solution(problem, [0.0] * 6, unit, t)
    pull = y[2] * lengths[2]
    problem["rig"]["cables"][2]["greatest"] = pull - 0.5
    return {"format": "cable-robot proof", "version": 1, "problem": problem, "verdict": "not admissible",
            "instant": {"time": t, "cable": 3, "inverse": invert(matrix), "solution": [[x] for x in y],
                        "error": [1e-11] * 6, "least": pull - 1e-10, "greatest": pull + 1e-10}}


def make_short(unlimited=False, t=0.2):
    """Not admissible, eight cables: too weak, or (without limits) to push down what flies up."""
    problem = {"rig": make_rig(8), "step": make_step()}
    for cable in problem["rig"]["cables"]:
        cable["greatest"] = math.inf if unlimited else 5.0
    if unlimited:
        problem["rig"]["disturbance"][2] = -100.0
    v, lengths, w = state(problem, t)
    z = w[:3] + [0.0] * 3
    c = [x / y for x, y in zip(apply(transpose(v), z), lengths)]
    most = sum(x * (0.5 if x < 0 else 5.0) for x in c)
    shortfall = (sum(a * b for a, b in zip(z, w)) - most) / sum(map(abs, c)) - 1e-9
    return {"format": "cable-robot proof", "version": 1, "problem": problem, "verdict": "not admissible",
            "instant": {"time": t, "multipliers": z, "shortfall": shortfall}}


# --- Tests ---------------------------------------------------------------------------------

SIX, PULLEYS, EIGHT = make_admissible(6), make_admissible(6, pulley=True), make_admissible(8)
OVERLOADED, SHORT, UNLIMITED = make_overloaded(), make_short(), make_short(unlimited=True)
ALL = {"six": SIX, "pulleys": PULLEYS, "eight": EIGHT, "overloaded": OVERLOADED, "short": SHORT, "unlimited": UNLIMITED}


def refused(text):
    with pytest.raises(Refused) as found:
        check(text)
    assert type(found.value.message) is str and found.value.message
    return found.value.condition


@pytest.mark.parametrize("name", ALL)
def test_honest_proofs_are_accepted(name):
    verdict = check(sealed(ALL[name]))
    assert verdict.verdict == ALL[name]["verdict"]
    assert len(verdict.sha256) == 64


def test_equal_gains_and_disturbances_are_accepted():
    problem = {"rig": make_rig(6), "step": make_step() | {"eta": 2.0 + 2 ** -40}}
    problem["rig"]["disturbance"] = [1.0, -2.0, 3.0, 0.05, 0.1, -0.1]
    problem["step"]["start"][5] += 2 * math.tau
    spans = [make_span(problem, 0.3 * k, 0.3 * (k + 1) if k < 10 else None, room=20) for k in range(11)]
    for span in spans:      # room for the maker, which divides by the difference of the gains
        span["error"] = [x + 1e-3 for x in span["error"]]
        span["least"], span["greatest"] = [x - 0.01 for x in span["least"]], [x + 0.01 for x in span["greatest"]]
    problem["step"]["eta"] = 2.0
    proof = SIX | {"problem": problem, "spans": spans, "least": min(min(s["least"]) for s in spans),
                   "greatest": max(max(s["greatest"]) for s in spans)}
    assert check(sealed(proof)).verdict == "admissible"


def put(*path_and_value):
    """A change of a proof: sets (or computes, from what was) the value at a path."""
    *path, last, value = path_and_value
    def change(proof):
        for key in path:
            proof = proof[key]
        proof[last] = value(proof[last]) if callable(value) else value
    return change


def several(*changes):
    return lambda proof: [change(proof) for change in changes]


def remade(proof):
    proof["least"] = min(min(s["least"]) for s in proof["spans"])
    proof["greatest"] = max(max(s["greatest"]) for s in proof["spans"])


RIG, STEP, INSTANT = ("problem", "rig"), ("problem", "step"), ("instant",)
CHANGES = [
    # name, proof, what is changed before the hash is made, condition
    ("no mass", SIX, put(*RIG, "mass", 0.0), "C2"),
    ("inertia not symmetric", SIX, put(*RIG, "inertia", 0, 2, 0.01), "C2"),
    ("negative inertia", SIX, put(*RIG, "inertia", 1, 1, -0.25), "C2"),
    ("five cables", SIX, put(*RIG, "cables", lambda c: c[:5]), "C2"),
    ("limits crossed", SIX, put(*RIG, "cables", 1, "least", 300.0), "C2"),
    ("axis too long", PULLEYS, put(*RIG, "cables", 1, "pulley", "axis", 2, 1.000001), "C2"),
    ("no radius", PULLEYS, put(*RIG, "cables", 1, "pulley", "radius", 0.0), "C2"),
    ("gain negative", SIX, put(*STEP, "eta", -3.0), "C2"),
    ("pitch beyond a right angle", SIX, put(*STEP, "start", 4, 1.6), "C4"),
    ("pitch swings beyond a right angle", SIX, put(*STEP, "rates", 4, 12.0), "C4"),
    ("yaw turns more than half a turn", SIX, put(*STEP, "rates", 5, -30.0), "C4"),
    ("late start", SIX, put("spans", 0, "from", 0.01), "C5"),
    ("gap", SIX, put("spans", 3, "to", lambda x: x - 1e-9), "C5"),
    ("span of no length", SIX, put("spans", 3, "from", 0.7), "C5"),
    ("span dropped", SIX, lambda p: p["spans"].pop(4), "C5"),
    ("last span too early", SIX, lambda p: p["spans"][-1].update({"from": 0.4}), "C5"),
    ("last span dropped", SIX, lambda p: p["spans"].pop(), "C1"),
    ("pulley as large as the rig", PULLEYS, put(*RIG, "cables", 0, "pulley", "radius", 1.5), "C6"),
    ("polynomial bent", SIX, put("spans", 2, "solution", 3, 1, lambda x: x + 1e-4), "C7"),
    ("polynomial bent, eight", EIGHT, put("spans", 2, "solution", 3, 5, lambda x: x + 1e-4), "C7"),
    ("constant bent", SIX, put("spans", -1, "solution", 0, 0, lambda x: x + 0.5), "C7"),
    ("error too small", SIX, put("spans", 5, "error", 2, lambda x: x / 50), "C7"),
    ("error negative", SIX, put("spans", 5, "error", 2, lambda x: -x), "C7"),
    ("inverse nought", SIX, put("spans", 1, "inverse", [[0.0] * 6] * 6), "C7"),
    ("basis singular", EIGHT, put("spans", 1, "basis", [[1.0] * 6] * 8), "C7"),
    ("another mass", SIX, put(*RIG, "mass", 6.01), "C7"),
    ("another anchor", EIGHT, put(*RIG, "cables", 7, "anchor", 2, 0.001), "C7"),
    ("another disturbance", SIX, put(*RIG, "disturbance", 5, 0.01), "C7"),
    ("another set point", SIX, put(*STEP, "setPoint", 0, 0.11), "C7"),
    ("bound too high", SIX, several(put("spans", 0, "least", 2, lambda x: x + 0.2), remade), "C8"),
    ("bound too low", EIGHT, several(put("spans", 4, "greatest", 5, lambda x: x - 0.2), remade), "C8"),
    ("bound too high at the end", PULLEYS, several(put("spans", -1, "least", 0, lambda x: x + 0.9), remade), "C8"),
    ("beyond the upper limit", SIX, put(*RIG, "cables", 0, "greatest", 14.0), "C9"),
    ("at the lower limit", SIX, put(*RIG, "cables", 4, "least", min(s["least"][4] for s in SIX["spans"])), "C9"),
    ("least of all wrong", SIX, put("least", lambda x: x - 1e-9), "C10"),
    ("greatest of all wrong", EIGHT, put("greatest", lambda x: x + 1e-9), "C10"),
    ("time negative", OVERLOADED, put(*INSTANT, "time", -0.3), "C11"),
    ("no such cable", OVERLOADED, put(*INSTANT, "cable", 7), "C1"),
    ("wrong instant", OVERLOADED, put(*INSTANT, "time", 0.3001), "C7"),
    ("another solution", OVERLOADED, put(*INSTANT, "solution", 2, 0, lambda x: x + 1e-9), "C7"),
    ("bounds of another cable", OVERLOADED, several(put(*INSTANT, "cable", 1), put(
        *RIG, "cables", 0, "greatest", OVERLOADED["problem"]["rig"]["cables"][2]["greatest"])), "C8"),
    ("bound too high, instant", OVERLOADED, put(*INSTANT, "least", lambda x: x + 1e-6), "C8"),
    ("nothing wrong with the tension", OVERLOADED, put(*RIG, "cables", 2, "greatest", 50.0), "C12"),
    ("time negative, eight", SHORT, put(*INSTANT, "time", -0.3), "C13"),
    ("Farkas' vector bent", SHORT, put(*INSTANT, "multipliers", 2, lambda x: -x), "C13"),
    ("Farkas' vector nought", SHORT, put(*INSTANT, "multipliers", [0.0] * 6), "C13"),
    ("shortfall too large", SHORT, put(*INSTANT, "shortfall", lambda x: x + 1e-8), "C13"),
    ("wrong instant, eight", SHORT, put(*INSTANT, "time", 0.4), "C13"),
    ("strong enough", SHORT, lambda p: [c.update(greatest=50.0) for c in p["problem"]["rig"]["cables"]], "C13"),
    ("without a limit and pulled", UNLIMITED, put(*INSTANT, "multipliers", lambda z: [-x for x in z]), "C13"),
]


@pytest.mark.parametrize("name, proof, change, condition", CHANGES, ids=[c[0] for c in CHANGES])
def test_what_is_bent_is_refused(name, proof, change, condition):
    proof = json.loads(json.dumps(proof))
    change(proof)
    assert refused(sealed(proof)) == condition


def test_bounds_just_beyond_dense_samples_are_refused():
    """The claims of each span are moved inside the tensions that samples of it show."""
    rng = random.Random(5)
    for _ in range(6):
        proof = json.loads(json.dumps(SIX))
        k, i, side = rng.randrange(10), rng.randrange(6), rng.choice(["least", "greatest"])
        span = proof["spans"][k]
        found = []
        for j in range(401):
            t = span["from"] + (span["to"] - span["from"]) * j / 400
            unit = [[float(a == b) for b in range(6)] for a in range(6)]
            _, _, y, lengths = instant_solution(proof["problem"], [0.0] * 6, unit, t)
            found.append(y[i] * lengths[i])
        span[side][i] = min(found) + 1e-6 if side == "least" else max(found) - 1e-6
        remade(proof)
        assert refused(sealed(proof)) == "C8"


def test_bounds_close_to_what_large_errors_allow_are_accepted():
    proof = json.loads(json.dumps(PULLEYS))
    span = proof["spans"][3]
    span["error"] = [0.5] * 6
    middle, half = (span["from"] + span["to"]) / 2, (span["to"] - span["from"]) / 2
    points = [(state(proof["problem"], middle + half * x / 100)[1], x / 100) for x in range(-100, 101)]
    for i in range(6):
        found = [(lengths[i] * value(span["solution"][i], x), lengths[i] * 0.5) for lengths, x in points]
        span["least"][i] = min(a - b for a, b in found) - 1e-4
        span["greatest"][i] = max(a + b for a, b in found) + 1e-4
    remade(proof)
    assert check(sealed(proof)).verdict == "admissible"


FILES = [
    ("version", lambda t: t.replace('"version": 1', '"version": 2')),
    ("version as text", lambda t: t.replace('"version": 1', '"version": "1"')),
    ("version true", lambda t: t.replace('"version": 1', '"version": true')),
    ("foreign", lambda t: t.replace("cable-robot proof", "another proof")),
    ("list", lambda t: f"[{t}]"),
    ("empty", lambda t: ""),
    ("not a number", lambda t: t.replace('"mass": "0x1.8p+2"', '"mass": NaN')),
    ("decimal number", lambda t: t.replace('"mass": "0x1.8p+2"', '"mass": 6.0')),
    ("number with zeros", lambda t: t.replace('"mass": "0x1.8p+2"', '"mass": "0x1.80p+2"')),
    ("number too large", lambda t: t.replace('"mass": "0x1.8p+2"', '"mass": "0x1p+9999"')),
    ("infinite mass", lambda t: t.replace('"mass": "0x1.8p+2"', '"mass": "inf"')),
    ("minus nought", lambda t: t.replace('"0x0p+0"', '"-0x0p+0"', 1)),
    ("mass twice", lambda t: t.replace('"mass"', '"mass": "0x1.8p+2", "mass"')),
    ("more", lambda t: t.replace('"mass"', '"colour": "red", "mass"')),
    ("less", lambda t: t.replace('"mass": "0x1.8p+2", ', "")),
    ("deep", lambda t: "[" * 100000),
    ("long number", lambda t: t.replace('"version": 1', '"version": ' + "1" * 5000)),
    ("surrogate", lambda t: t.replace('"0x1.8p+2"', '"\\ud800"', 1)),
    ("verdict", lambda t: t.replace('"verdict": "admissible"', '"verdict": "not admissible"')),
    ("large", lambda t: t + " " * 10_000_000),
]


@pytest.mark.parametrize("name, change", FILES, ids=[f[0] for f in FILES])
def test_other_files_are_refused(name, change):
    text = sealed(SIX)
    assert change(text) != text
    assert refused(change(text)) == "C1"


def test_another_problem_or_hash_is_refused():
    text = sealed(SIX)
    other = json.loads(sealed(EIGHT))["sha256"]
    assert refused(json.dumps(json.loads(text) | {"sha256": other})) == "C3"
    assert refused(text.replace('"mass": "0x1.8p+2"', '"mass": "0x1.8000000000001p+2"')) == "C3"


def test_broken_files_are_refused_without_other_exceptions():
    rng = random.Random(3)
    text = sealed(OVERLOADED)
    for _ in range(100):
        assert refused(text[:rng.randrange(len(text))]) == "C1"
    for _ in range(400):
        broken = bytearray(text.encode())
        broken[rng.randrange(len(broken))] = rng.randrange(256)
        try:
            check(bytes(broken))
        except Refused:
            pass


def test_command(tmp_path):
    good, bad, cut = tmp_path / "good.json", tmp_path / "bad.json", tmp_path / "cut.json"
    good.write_text(sealed(SHORT))
    bad.write_text(sealed(OVERLOADED).replace('"time"', '"hour"'))
    cut.write_text(sealed(OVERLOADED)[:1000])
    def run(*names):
        return subprocess.run([sys.executable, os.path.join(HERE, "check_proof.py"), *map(str, names)],
                              capture_output=True, text=True)
    done = run(good)
    assert done.returncode == 0 and "accepted: not admissible" in done.stdout and not done.stderr
    done = run(good, bad, cut, tmp_path / "none.json")
    assert done.returncode == 1 and not done.stderr
    lines = done.stdout.splitlines()
    assert ["REFUSED" in line for line in lines] == [False, True, True, True]
    assert "C1" in lines[1] and "hour" in lines[1] and "line 1" in lines[2]
    assert run().returncode == 2 and run("--help").returncode == 2
