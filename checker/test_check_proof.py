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
import time

import pytest

from check_proof import Refused, check, spelling

HERE = os.path.dirname(os.path.abspath(__file__))


# --- The model in floats -------------------------------------------------------------------

def jets(step, t):
    """Coordinates and their first two derivatives: [(q, q', q'')], of different gains."""
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


def make_span(problem, t1, t2, room=1.5):
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
