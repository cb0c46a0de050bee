"""Checks proof files (version 1) of cable-suspended robots in ball arithmetic.

    python check_proof.py FILE...

Written from the description of the format alone; (C1) to (C13) are its conditions.
A real number is an `arb`, a ball that holds it. A function of time is an `arb_series`,
its Taylor coefficients, each a ball. Units: m, kg, s, N, N m, rad.
"""
import functools
import hashlib
import json
import math
import sys
from collections import namedtuple
from fractions import Fraction

from flint import arb, arb_mat, arb_poly, arb_series, ctx, fmpq, fmpq_poly

BITS = 128        # of the midpoints of all balls
ORDER = 10        # of the remainder of the Taylor models over spans,
COARSE = 3        # and of the models of V B
CUTS = 8          # of a Taylor model, to bound it
HALVINGS = 9      # of a span at most, before it is refused
RESTS = 60        # pieces of 1/mu that the last span is cut in at most
SIZE = 10_000_000  # bytes of a file at most

Verdict = namedtuple("Verdict", "verdict bounds sha256")
Problem = namedtuple("Problem", "mass inertia gravity force torque cables place error rates slow fast gap")
Cable = namedtuple("Cable", "anchor attachment radius axis")
Unknowns = namedtuple("Unknowns", "basis levers beside guess spread")
Functions = namedtuple("Functions", "vectors lengths forces pulls")


class Refused(Exception):
    """The proof is refused: `condition` is "C1" to "C13"."""

    def __init__(self, condition, message):
        super().__init__(f"{condition}: {message}")
        self.condition, self.message = condition, message


class Undecided(Refused):
    """Not proved of a piece of time as a whole; parts of it may be."""


def demand(holds, condition, message):
    if not holds:
        raise Refused(condition, message)


# --- The file: (C1), (C2), (C3) ------------------------------------------------------------

NUMBER, LIMIT, COUNT, TEXT, ANY = "a number", "a number or \"inf\"", "an integer", "a string", "anything"


def array(inner, least, greatest=None):
    """The shape of an array of `least` (to `greatest`) times `inner`."""
    return inner, least, least if greatest is None else greatest


VECTOR, SIX = array(NUMBER, 3), array(NUMBER, 6)
SQUARE = array(SIX, 6)
CABLE = {"anchor": VECTOR, "attachment": VECTOR, "least": NUMBER, "greatest": LIMIT,
         "pulley?": {"radius": NUMBER, "axis": VECTOR}}
RIG = {"mass": NUMBER, "inertia": array(VECTOR, 3), "gravity": VECTOR, "disturbance": SIX,
       "cables": array(CABLE, 0, SIZE)}
STEP = {"start": SIX, "rates": SIX, "setPoint": SIX, "lambda": NUMBER, "eta": NUMBER}
FRAME = {"format": TEXT, "version": COUNT, "problem": {"rig": RIG, "step": STEP}, "sha256": TEXT, "verdict": TEXT}


def span_shape(n, last):
    """The shape of a span of n cables."""
    shape = {"from": NUMBER, "inverse": SQUARE, "solution": array(array(NUMBER, 1, 1 if last else 6), 6),
             "error": SIX, "least": array(NUMBER, n), "greatest": array(NUMBER, n)}
    if not last:
        shape["to"] = NUMBER
    if n > 6:
        shape.update(base=array(NUMBER, n), basis=array(SIX, n))
    return shape


def instant_shape(n):
    """The shape of an instant of n cables."""
    if n > 6:
        return {"time": NUMBER, "multipliers": SIX, "shortfall": NUMBER}
    return {"time": NUMBER, "cable": COUNT, "inverse": SQUARE, "solution": array(array(NUMBER, 1), 6),
            "error": SIX, "least": NUMBER, "greatest": NUMBER}


def spelling(x):
    """The one spelling of a double."""
    mantissa, exponent = (x + 0.0).hex().split("p")
    return f"{mantissa.rstrip('0').rstrip('.')}p{exponent}"


def read_number(value, shape, where):
    """A number, or where nothing limits it infinity."""
    if shape == LIMIT and value == "inf":
        return math.inf
    try:
        number = float.fromhex(value)
        if math.isfinite(number) and spelling(number) == value:
            return number
    except (TypeError, ValueError, OverflowError):
        pass
    raise Refused("C1", f"{where}: expected {shape} as printf(\"%a\") spells it, found {brief(value)}")


def read(value, shape, where):
    """`value` of the JSON text as `shape` says, with its numbers as floats."""
    if shape in (NUMBER, LIMIT):
        return read_number(value, shape, where)
    if isinstance(shape, dict):
        demand(isinstance(value, dict), "C1", f"{where}: expected an object, found {brief(value)}")
        names = {name.rstrip("?"): name for name in shape}
        for key in value:
            demand(key in names, "C1", f"{where}: unexpected field {brief(key)}")
        for key, name in names.items():
            demand(key in value or name != key, "C1", f"{where}: field \"{key}\" is missing")
        return {key: read(value[key], shape[names[key]], f"{where}.{key}") for key in value}
    if isinstance(shape, tuple):
        inner, least, greatest = shape
        demand(isinstance(value, list) and least <= len(value) <= greatest, "C1",
               f"{where}: expected an array of {least if least == greatest else f'{least} to {greatest}'}, "
               f"found {brief(value)}")
        return [read(entry, inner, f"{where}[{k}]") for k, entry in enumerate(value)]
    demand(shape == ANY or type(value) is {COUNT: int, TEXT: str}[shape], "C1",
           f"{where}: expected {shape}, found {brief(value)}")
    return value


def brief(value):
    """A value of the file for a message."""
    if isinstance(value, (list, dict)):
        return f"{'an array' if isinstance(value, list) else 'an object'} of {len(value)}"
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:36] + "..."


def unique(pairs):
    """A JSON object, no key of which may come twice."""
    found = dict(pairs)
    demand(len(found) == len(pairs), "C1", "an object has the same key twice")
    return found


def read_file(text):
    """The proof in `text`, numbers as floats; (C1) to (C3)."""
    try:
        if isinstance(text, str):
            text = text.encode()
        demand(len(text) <= SIZE, "C1", f"expected at most {SIZE} bytes, found {len(text)}")
        raw = json.loads(text.decode(), object_pairs_hook=unique)
    except json.JSONDecodeError as fault:
        raise Refused("C1", f"not JSON: {fault.msg}, line {fault.lineno}, column {fault.colno}") from None
    except (ValueError, RecursionError) as fault:
        raise Refused("C1", f"not JSON: {str(fault)[:100]}") from None
    demand(isinstance(raw, dict), "C1", f"expected an object, found {brief(raw)}")
    for key, expected in ("format", "cable-robot proof"), ("version", 1):
        demand(type(raw.get(key)) is type(expected) and raw[key] == expected, "C1",
               f"{key}: expected {brief(expected)}, found {brief(raw.get(key))}")
    verdict = raw.get("verdict")
    demand(verdict in ("admissible", "not admissible"), "C1",
           f"verdict: expected \"admissible\" or \"not admissible\", found {brief(verdict)}")
    head = {"instant": ANY} if verdict != "admissible" else {
        "least": NUMBER, "greatest": NUMBER, "spans": array(ANY, 1, SIZE)}
    proof = read(raw, FRAME | head, "file")
    check_rig(proof["problem"])
    text = json.dumps(raw["problem"], sort_keys=True, separators=(",", ":"))
    found = hashlib.sha256(text.encode()).hexdigest()
    demand(proof["sha256"] == found, "C3", f"the problem's sha256 is {found}, the file says {brief(proof['sha256'])}")
    n = len(proof["problem"]["rig"]["cables"])
    if verdict == "admissible":
        last = len(proof["spans"])
        proof["spans"] = [read(span, span_shape(n, k == last), f"span {k}")
                          for k, span in enumerate(proof["spans"], 1)]
    else:
        proof["instant"] = read(proof["instant"], instant_shape(n), "instant")
    return proof


def check_rig(problem):
    """(C2), exact."""
    rig, step = problem["rig"], problem["step"]
    inertia = rig["inertia"]
    demand(6 <= len(rig["cables"]) <= 16, "C2", f"expected 6 to 16 cables, found {len(rig['cables'])}")
    demand(rig["mass"] > 0, "C2", f"expected mass > 0, found {rig['mass']}")
    for i in range(3):
        demand(inertia[i][i] > 0, "C2", f"inertia: expected a positive diagonal, found {inertia[i][i]}")
        demand(all(inertia[i][j] == inertia[j][i] for j in range(3)), "C2", "inertia: expected a symmetric matrix")
    for i, cable in enumerate(rig["cables"], 1):
        demand(0 <= cable["least"] < cable["greatest"], "C2",
               f"cable {i}: expected 0 <= least < greatest, found {cable['least']}, {cable['greatest']}")
        if "pulley" in cable:
            radius, axis = cable["pulley"]["radius"], cable["pulley"]["axis"]
            demand(radius > 0, "C2", f"cable {i}: expected a radius > 0, found {radius}")
            demand(abs(sum(Fraction(k) ** 2 for k in axis) - 1) <= Fraction(1, 10 ** 12), "C2",
                   f"cable {i}: expected an axis of length 1, found {axis}")
    for gain in "lambda", "eta":
        demand(step[gain] > 0, "C2", f"expected {gain} > 0, found {step[gain]}")


# --- The motion ----------------------------------------------------------------------------

def reduced(angle):
    """The angle less the multiple of 2 pi that brings it into [-pi, pi], rad."""
    turns = (angle / (2 * arb.pi()) + 0.5).floor().unique_fmpz()
    demand(turns is not None, "C4", f"an angle of {float(angle)} is too large or at half a turn")
    return angle - 2 * arb.pi() * turns


def prepare(problem):
    """The problem in balls."""
    def balls(numbers):
        return [arb(x) for x in numbers]
    rig, step = problem["rig"], problem["step"]
    cables = []
    for cable in rig["cables"]:
        pulley = cable.get("pulley", {"radius": 0.0, "axis": []})
        cables.append(Cable(balls(cable["anchor"]), balls(cable["attachment"]),
                            arb(pulley["radius"]), balls(pulley["axis"])))
    place = balls(step["setPoint"])
    error = [x - p for x, p in zip(balls(step["start"]), place)]
    slow, fast = sorted((step["lambda"], step["eta"]))
    return Problem(arb(rig["mass"]), [balls(row) for row in rig["inertia"]], balls(rig["gravity"]),
                   balls(rig["disturbance"][:3]), balls(rig["disturbance"][3:]), cables, place,
                   error[:3] + [reduced(x) for x in error[3:]], balls(step["rates"]),
                   arb(slow), arb(fast), arb(fast) - arb(slow))


def check_angles(problem):
    """(C4)."""
    slow, gap = problem.slow, problem.gap
    for j, name in (3, "roll"), (4, "pitch"), (5, "yaw"):
        e, v = problem.error[j], problem.rates[j]
        extremes = [arb(0), e]
        k = v + problem.fast * e        # the error is e exp(-Mt) + k phi
        if not v == 0 and not k / v <= 0:
            if k / v > 0:
                rate = slow * k / v
                time = 1 / rate if gap == 0 else (gap / rate).log1p() / gap
                _, quick, phi = decays(problem, time)
                extremes.append(e * quick + k * phi)
            else:                       # k may be 0: phi is below 1/mu
                bound = abs(e) + abs(k) / slow
                extremes += [bound, -bound]
        for x in extremes:
            demand(abs(x) < arb.pi(), "C4", f"{name}: expected an error within pi, found {float(x)}")
            if name == "pitch":
                pitch = reduced(problem.place[j]) + x
                demand(abs(pitch) < arb.pi() / 2, "C4", f"expected a pitch within pi/2, found {float(pitch)}")


def decays(problem, time):
    """exp(-mu t), exp(-M t) and phi (s) at a time (s) that is a ball."""
    slow = (-problem.slow * time).exp()
    integral = time if problem.gap == 0 else -(-problem.gap * time).expm1() / problem.gap
    return slow, (-problem.fast * time).exp(), slow * integral


def decays_rest(problem, time):
    """What `decays` gives, over all t >= time (s), where time >= 1/mu."""
    slow = (-problem.slow * time).exp()
    most = slow * (time if problem.gap == 0 else time.min(1 / problem.gap))
    return [arb(0).union(x) for x in (slow, (-problem.fast * time).exp(), most)]


def coordinates(problem, start, scale):
    """The coordinates and their first and second derivatives in t (m, rad, s), as series in x,
    where t is a time at which `decays` are `start` and scale x (s) more.

    The k-th derivative of phi is -(-1)^k (S_k exp(-M t) - mu^k phi), S_k = (M^k - mu^k)/(M - mu);
    f follows from f' = -mu M phi. So each coefficient is tight where `start` is wide.
    """
    slow, fast = problem.slow, problem.fast
    decay, quick, phi = start
    series, power, s, factor = [], arb(1), arb(0), arb(-1)
    ctx.cap += 2
    for k in range(ctx.cap):
        series.append((s * quick - power * phi) * factor)
        s, power, factor = fast * s + power, slow * power, -factor * scale / (k + 1)
    phi = arb_series(series)
    f = (-slow * fast * scale) * phi.integral() + (decay + slow * phi[0])
    q = [p + e * f + v * phi for p, e, v in zip(problem.place, problem.error, problem.rates)]
    rate = 1 / scale
    dq = [x.derivative() * rate for x in q]
    ddq = [x.derivative() * rate for x in dq]
    ctx.cap -= 2
    return q, dq, ddq


# --- The equations -------------------------------------------------------------------------

def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def root(x):
    """Square root of a series, tighter than its method where its coefficients are wide."""
    return (x.log() * 0.5).exp()


def positive(x, what):
    """(C6): `x`, a series, is positive throughout."""
    if not x[0] > 0:
        raise Undecided("C6", f"{what} > 0 is not proved: {interval(x[0])}")
    return x


def equations(problem, start, scale):
    """v and l of each cable (m) and w (N, N m), platform's frame; (C6)."""
    q, dq, ddq = coordinates(problem, start, scale)
    (sa, ca), (sb, cb), (sc, cc) = [x.sin_cos() for x in q[3:]]
    scsb, ccsb = sc * sb, cc * sb
    turn = [[cc * cb, sc * cb, -sb],                               # columns of R: rows of its transpose
            [ccsb * sa - sc * ca, scsb * sa + cc * ca, cb * sa],
            [ccsb * ca + sc * sa, scsb * ca - cc * sa, cb * ca]]
    def platform(vector):
        return [dot(row, vector) for row in turn]
    vectors, lengths = [], []
    for i, cable in enumerate(problem.cables, 1):
        v = platform([a - x for a, x in zip(cable.anchor, q)])
        v = [x - b for x, b in zip(v, cable.attachment)]
        if cable.axis:
            v = round_pulley(v, cable.radius, platform(cable.axis), i)
        lengths.append(root(positive(dot(v, v), f"length of cable {i} squared")))
        vectors.append(v)
    da, db, dc = dq[3:]
    dda, ddb, ddc = ddq[3:]
    spin = [da - dc * sb, db * ca + dc * (cb * sa), dc * (cb * ca) - db * sa]
    d = ddc * cb - dc * (db * sb)
    dspin = [dda - ddc * sb - dc * (db * cb),
             ddb * ca + d * sa + da * spin[2], d * ca - ddb * sa - da * spin[1]]
    momentum, rate = [[dot(row, x) for row in problem.inertia] for x in (spin, dspin)]
    force = platform([problem.mass * (a - g) - f for a, g, f in zip(ddq, problem.gravity, problem.force)])
    outer = platform(problem.torque)
    torque = [a + b - c for a, b, c in zip(rate, cross(spin, momentum), outer)]
    return vectors, lengths, force + torque


def round_pulley(a, r, axis, i):
    """v of a cable whose anchor has a pulley (m); (C6)."""
    height = -dot(a, axis)
    out = [-x - height * k for x, k in zip(a, axis)]
    e = root(positive(dot(out, out), f"e of cable {i} squared"))
    p = e - r
    square = p * p + height * height
    s = root(positive(square - r * r, f"d^2 - r^2 of cable {i}"))
    cosine, sine = (p * r - height * s) / square, (height * r + p * s) / square
    along, up = r * (1 + cosine) / e, r * sine
    return [x + along * y + up * k for x, y, k in zip(a, out, axis)]


# --- Pieces of time: (C6), (C7), (C8) --------------------------------------------------------

def interval(ball):
    """The ends of a ball, for a message."""
    return f"[{float(ball.lower()):.17g}, {float(ball.upper()):.17g}]"


def largest(balls):
    """The greatest of some balls."""
    most = balls[0]
    for ball in balls[1:]:
        most = most.max(ball)
    return most


def smallest(balls):
    """The least of some balls."""
    return -largest([-x for x in balls])


def unknowns(problem, span):
    """What a span's or an instant's fields say: B (None of six cables, where it is 1); C L_i, where
    L_i v_i = (v_i, b_i x v_i); C and -C L_i side by side; polynomials in tau of s for y = y-hat (N/m);
    and by how much s may differ from them (N/m)."""
    inverse = arb_mat(span["inverse"])
    levers = [inverse * arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -z, y], [z, 0, -x], [-y, x, 0]])
              for x, y, z in (cable.attachment for cable in problem.cables)]
    beside = arb_mat([row + [-x for lever in levers for x in lever.tolist()[k]]
                      for k, row in enumerate(inverse.tolist())])
    guess = [arb_poly(c) for c in span["solution"]]
    spread = [arb(e) for e in span["error"]]
    if "basis" not in span:
        return Unknowns(None, levers, beside, guess, spread)
    basis = arb_mat(span["basis"])
    rows = basis.tolist()
    guess = [base + sum(b * g for b, g in zip(row, guess)) for base, row in zip(span["base"], rows)]
    return Unknowns(basis, levers, beside, guess, [sum(abs(b) * e for b, e in zip(row, spread)) for row in rows])


def functions(problem, start, scale, s):
    """The functions of time that a piece is judged by, where s (N/m) is the guess."""
    vectors, lengths, w = equations(problem, start, scale)
    forces = [x * y for v, y in zip(vectors, s) for x in v]
    return Functions(vectors, lengths, w + forces, [a * b for a, b in zip(lengths, s)])


def models(middle, whole, order):
    """Taylor models of functions of x in [-1, 1], one a row.

    A row has the Taylor coefficients at x = 0 below `order`, from `middle`, and last that of the remainder
    (Lagrange's), from `whole`: a ball that holds the coefficient of that order at every x.
    """
    rows = []
    for a, b in zip(middle, whole):
        a, b = a.coeffs(), b.coeffs()
        rows.append(a[:order] + [0] * (order - len(a)) + (b[order:order + 1] or [0]))
    return arb_mat(rows)


@functools.cache
def bernstein(order, cuts):
    """Matrix from a polynomial's coefficients on [-1, 1] to those of Bernstein's form on each of so many
    parts of it: the polynomial is between the least and the greatest of them."""
    columns = []
    for cut in range(cuts if order > 0 else 1):
        line = fmpq_poly([fmpq(2 * cut, cuts) - 1, fmpq(2, cuts)])
        powers = [line ** k for k in range(order + 1)]
        for j in range(order + 1):
            weights = [fmpq(math.comb(j, i), math.comb(order, i)) for i in range(j + 1)]
            columns.append([arb(sum((p[i] * x for i, x in enumerate(weights)), fmpq(0))) for p in powers])
    return arb_mat(columns).transpose()


def judge(span, given, numbers, middle, whole):
    """(C7), and (C8) of the cables `numbers` (from 0), in a piece of time."""
    order = ctx.cap - 1
    residual = given.beside * models(middle.forces, whole.forces, order) * bernstein(order, CUTS)
    r = [largest([abs(x).upper() for x in row]) for row in residual.tolist()]
    coarse = min(order, COARSE)
    table = arb_mat([(lever * models(a, b, coarse)).entries()     # V B, columns down, rows across, transformed by C
                     for lever, a, b in zip(given.levers, middle.vectors, whole.vectors)])
    table = (table if given.basis is None else given.basis.transpose() * table).tolist()
    rho = []
    for k in range(6):
        first, last = k * (coarse + 1), (k + 1) * (coarse + 1)
        table[k][first] -= 1
        rho.append(sum(abs(x).upper() for row in table for x in row[first:last]))
    if not largest(rho) < 1:
        raise Undecided("C7", f"expected rho < 1, proved rho <= {float(largest(rho)):.6g} only")
    tail = largest(r) / (1 - largest(rho))
    for k in range(6):
        bound = r[k] + rho[k] * tail
        if not bound <= span["error"][k]:
            raise Undecided("C7", f"unknown {k + 1}: the file's error is {span['error'][k]:.17g}, "
                                  f"proved {float(bound.upper()):.17g} only")
    pulls = models([middle.pulls[i] for i in numbers], [whole.pulls[i] for i in numbers], order) * bernstein(order, 1)
    for i, row in zip(numbers, pulls.tolist()):
        width = whole.lengths[i][0].upper() * given.spread[i]
        least, most = smallest(row) - width, largest(row) + width
        low, high = span["least"][i], span["greatest"][i]
        if not (least >= low and most <= high):
            raise Undecided("C8", f"cable {i + 1}: the file's bounds are [{low:.17g}, {high:.17g}] N, proved "
                                  f"[{float(least.lower()):.17g}, {float(most.upper()):.17g}] N only")


def prove_piece(problem, span, given, centre, scale, tau, half):
    """(C6) to (C8) at the times centre + scale x (s), x within `half` of `tau`."""
    ctx.cap = ORDER + 1
    found = []
    for x in tau, arb(tau, half):
        start, line = decays(problem, centre + scale * x), arb_poly([x, half])
        found.append(functions(problem, start, scale * half, [arb_series(g(line)) for g in given.guess]))
    judge(span, given, range(len(problem.cables)), *found)


def prove_parts(problem, span, given, centre, scale):
    """(C6) to (C8) at the times centre + scale tau (s), tau in [-1, 1], cut in halves as need be."""
    parts = [(arb(0), arb(1), 0)]
    while parts:
        tau, half, depth = parts.pop()
        try:
            prove_piece(problem, span, given, centre, scale, tau, half)
        except (Undecided, ValueError, ZeroDivisionError) as fault:
            if depth == HALVINGS:
                condition, message = getattr(fault, "condition", "C6"), getattr(fault, "message", str(fault))
                raise Refused(condition, f"t = {float(centre + scale * tau):.9g}: {message}") from None
            parts += [(tau + half / 2, half / 2, depth + 1), (tau - half / 2, half / 2, depth + 1)]


def prove_rest(problem, span, given):
    """(C6) to (C8) from `from` of the last span on: all at once, or of a piece and the rest after it."""
    start, scale = arb(span["from"]), 1 / (2 * problem.slow)
    for last in range(RESTS, -1, -1):
        ctx.cap = 1
        try:
            found = functions(problem, decays_rest(problem, start), arb(1), [arb_series(g) for g in given.guess])
            return judge(span, given, range(len(problem.cables)), found, found)
        except (Undecided, ValueError, ZeroDivisionError) as fault:
            if last == 0:
                condition, message = getattr(fault, "condition", "C6"), getattr(fault, "message", str(fault))
                raise Refused(condition, f"t >= {float(start):.9g}: {message}") from None
        prove_parts(problem, span, given, start + scale, scale)
        start += 2 * scale


# --- Verdicts ------------------------------------------------------------------------------

def check_admissible(problem, proof):
    """(C5) to (C10)."""
    spans, cables = proof["spans"], proof["problem"]["rig"]["cables"]
    demand(spans[0]["from"] == 0, "C5", f"span 1: expected from = 0, found {spans[0]['from']}")
    for k, (span, after) in enumerate(zip(spans, spans[1:]), 1):
        demand(span["from"] < span["to"], "C5", f"span {k}: expected from < to, found {span['from']}, {span['to']}")
        demand(after["from"] <= span["to"], "C5",
               f"span {k + 1}: expected from <= {span['to']}, the last one's to, found {after['from']}")
    start, slow = spans[-1]["from"], min(proof["problem"]["step"][gain] for gain in ("lambda", "eta"))
    demand(Fraction(start) * Fraction(slow) >= 1, "C5", f"last span: expected from >= {1 / slow}, found {start}")
    for k, span in enumerate(spans, 1):
        for i, cable in enumerate(cables):
            for low, high in (cable["least"], span["least"][i]), (span["greatest"][i], cable["greatest"]):
                demand(low < high, "C9", f"span {k}, cable {i + 1}: expected {low} < {high}")
    for name, pick in ("least", min), ("greatest", max):
        found = pick(pick(span[name]) for span in spans)
        demand(proof[name] == found, "C10", f"{name}: expected {found}, found {proof[name]}")
    for k, span in enumerate(spans, 1):
        given = unknowns(problem, span)
        try:
            if k == len(spans):
                prove_rest(problem, span, given)
            else:
                first, last = arb(span["from"]), arb(span["to"])
                prove_parts(problem, span, given, (first + last) / 2, (last - first) / 2)
        except Refused as fault:
            raise Refused(fault.condition, f"span {k}, {fault.message}") from None
    return f"{proof['least']:.9g} to {proof['greatest']:.9g} N, {len(spans)} spans"


def check_instant(problem, proof):
    """(C11) to (C13)."""
    instant, cables = proof["instant"], proof["problem"]["rig"]["cables"]
    six = len(cables) == 6
    demand(instant["time"] >= 0, "C11" if six else "C13", f"expected time >= 0, found {instant['time']}")
    ctx.cap = 1
    start = decays(problem, arb(instant["time"]))
    if not six:
        return check_farkas(problem, instant, cables, *equations(problem, start, arb(1)))
    number, least, most = instant["cable"], instant["least"], instant["greatest"]
    demand(1 <= number <= 6, "C1", f"instant.cable: expected 1 to 6, found {number}")
    cable = cables[number - 1]
    demand(most <= cable["least"] or least >= cable["greatest"], "C12",
           f"cable {number}: expected a tension outside {cable['least']} to {cable['greatest']} N, "
           f"found {least} to {most} N")
    given = unknowns(problem, instant)
    found = functions(problem, start, arb(1), [arb_series(g) for g in given.guess])
    judge(instant | {"least": [least] * 6, "greatest": [most] * 6}, given, [number - 1], found, found)
    return f"cable {number} at {instant['time']:.9g} s: {least:.9g} to {most:.9g} N"


def check_farkas(problem, instant, cables, vectors, lengths, w):
    """(C13), with what `equations` gives of the instant."""
    z = instant["multipliers"]
    pull, limit, size = sum(a * x[0] for a, x in zip(z, w)), arb(0), arb(0)
    for i, cable in enumerate(cables):
        v = [x[0] for x in vectors[i]]
        c = (dot(z, v) + dot(z[3:], cross(problem.cables[i].attachment, v))) / lengths[i][0]
        limit += c * cable["least"] if cable["greatest"] == math.inf else largest(
            [c * cable["least"], c * cable["greatest"]])
        size += abs(c)
        demand(c <= 0 or cable["greatest"] < math.inf, "C13",
               f"cable {i + 1}, without a limit: expected c <= 0, found {interval(c)}")
    demand(pull > limit, "C13", f"expected z.w > H, found {interval(pull)} and {interval(limit)}")
    shortfall = (pull - limit) / size
    demand(shortfall >= instant["shortfall"], "C13",
           f"shortfall: the file says {instant['shortfall']:.17g}, proved {interval(shortfall)} only")
    return f"at {instant['time']:.9g} s, short by {instant['shortfall']:.9g} N"


def check(text):
    """The verdict that the proof `text` (string or bytes) proves; raises `Refused` if it proves none."""
    ctx.prec = BITS
    proof = read_file(text)
    problem = prepare(proof["problem"])
    check_angles(problem)
    bounds = (check_admissible if proof["verdict"] == "admissible" else check_instant)(problem, proof)
    return Verdict(proof["verdict"], bounds, proof["sha256"])


def main(names):
    """Checks files; the exit code."""
    if not names or any(name.startswith("-") for name in names):
        print("usage: python check_proof.py FILE...", file=sys.stderr)
        return 2
    code = 0
    for name in names:
        try:
            with open(name, "rb") as file:
                verdict = check(file.read(SIZE + 1))
            print(f"{name}: accepted: {verdict.verdict}, {verdict.bounds}, problem {verdict.sha256[:16]}")
        except (Refused, OSError) as fault:
            print(f"{name}: REFUSED {fault}" if isinstance(fault, Refused) else f"{name}: REFUSED: {fault.strerror}")
            code = 1
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
