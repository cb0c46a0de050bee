"""Checks proof files (version 1) of cable-suspended robots in ball arithmetic.

    python check_proof.py FILE...

Written from the description of the format alone; (C1) to (C18) are its conditions, and names are its names.
A real number is an `arb`, a ball that holds it; comparing balls gives True only of what is certain. A function of
time is an `arb_series`, its Taylor coefficients, each a ball. Units: m, kg, s, N, N m, rad.
"""
import math
import sys
from collections import namedtuple

from flint import arb, arb_mat, arb_poly, arb_series, ctx

import motions
from enclosures import Undecided, bernstein, cross, dot, extents, interval, largest, models, reach
from margins import check_disturbance, check_intrusion, judge_law, judge_tube, kept, make_tube, stiffness
from proof_file import SIZE, Refused, brief, check_times, demand, read_file

BITS = 128         # of the midpoints of all balls
ORDER = 8          # of the remainders of Taylor models over spans,
COARSE = 3         # and of the models of V B
HALVINGS = 9       # of a span at most, before it is refused
RESTS = 60         # pieces of 1/mu that the last span is cut in at most

Verdict = namedtuple("Verdict", "verdict bounds sha256")
Cable = namedtuple("Cable", "anchor attachment radius axis least greatest")
Problem = namedtuple("Problem", "mass inertia gravity force torque cables place error rates slow fast gap tube piece",
                     defaults=[None] * 8)      # of a step until the gap, with margins the tube; of a motion the piece


# --- The motion: (C4) ----------------------------------------------------------------------------------------------

def reduced(angle):
    """The angle less the multiple of 2 pi that brings it into [-pi, pi], rad."""
    turns = (angle / (2 * arb.pi()) + 0.5).floor().unique_fmpz()
    demand(turns is not None, "C4", f"an angle of {float(angle)} is too large or just half a turn")
    return angle - 2 * arb.pi() * turns


def prepare(rig, step=None):
    """The problem in balls, e_0 and v_0 as `error` and `rates`, mu, M and Delta as `slow`, `fast` and `gap`; without
    a step that of a motion, whose `piece` is still to be set."""
    def balls(numbers):
        return [arb(x) for x in numbers]
    pulleys = [cable.get("pulley", {"radius": 0.0, "axis": []}) for cable in rig["cables"]]
    cables = [Cable(balls(cable["anchor"]), balls(cable["attachment"]), arb(pulley["radius"]), balls(pulley["axis"]),
                    arb(cable["least"]), arb(cable["greatest"])) for cable, pulley in zip(rig["cables"], pulleys)]
    body = Problem(arb(rig["mass"]), [balls(row) for row in rig["inertia"]], balls(rig["gravity"]),
                   balls(rig["disturbance"][:3]), balls(rig["disturbance"][3:]), cables)
    if step is None:
        return body
    place = balls(step["setPoint"])
    error = [x - p for x, p in zip(balls(step["start"]), place)]
    slow, fast = balls(sorted((step["lambda"], step["eta"])))
    return body._replace(place=place, error=error[:3] + [reduced(x) for x in error[3:]], rates=balls(step["rates"]),
                         slow=slow, fast=fast, gap=fast - slow)


def check_angles(problem):
    """(C4); bounds of |roll|, |pitch| and |yaw| in the tube (rad), each less a multiple of 2 pi."""
    slow, gap, bounds = problem.slow, problem.gap, []
    for j, name in (3, "roll"), (4, "pitch"), (5, "yaw"):
        e, v, place = problem.error[j], problem.rates[j], reduced(problem.place[j])
        play = problem.tube.play[0][j] if problem.tube else 0
        extremes = [arb(0), e]
        k = v + problem.fast * e        # e_0 f + v_0 phi = e_0 exp(-M t) + k phi
        if v != 0 and k / v > 0:
            rate = slow * k / v
            _, quick, phi = decays(problem, 1 / rate if gap == 0 else (gap / rate).log1p() / gap)
            extremes.append(e * quick + k * phi)
        elif v != 0 and not k / v <= 0:     # k may be 0; phi is below 1/mu
            extremes += [abs(e) + abs(k) / slow, -abs(e) - abs(k) / slow]
        for x in extremes:
            demand(abs(x + play) < arb.pi(), "C4", f"{name}: expected an error within pi, found {float(x)}")
        bounds.append(largest([abs(place + x + play).upper() for x in extremes]))
    demand(bounds[1] < arb.pi() / 2, "C4", f"expected a pitch within pi/2, found {float(bounds[1])}")
    return bounds


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


def begin(problem, time):
    """What `coordinates` starts from at a time (s) that is a ball."""
    return time if problem.piece else decays(problem, time)


def coordinates(problem, start, scale):
    """The coordinates and their first and second derivatives in t (m, rad, s), as series in x: `start` is what
    `begin` gives at x = 0, and t changes by `scale` x (s).

    The k-th derivative of phi is -(-1)^k (S_k exp(-M t) - mu^k phi), S_k = (M^k - mu^k)/(M - mu), and f' is
    -mu M phi. So every coefficient is tight also where `start` is wide.
    """
    if problem.piece:
        return motions.coordinates(problem.piece, start, scale)
    slow, fast = problem.slow, problem.fast
    decay, quick, phi = start
    series, power, s, factor = [], arb(1), arb(0), arb(-1)
    ctx.cap += 2
    for k in range(ctx.cap):
        series.append((s * quick - power * phi) * factor)
        s, power, factor = fast * s + power, slow * power, -factor * scale / (k + 1)
    phi_series = arb_series(series)
    f = (-slow * fast * scale) * phi_series.integral() + (decay + slow * phi)
    q = [p + e * f + v * phi_series for p, e, v in zip(problem.place, problem.error, problem.rates)]
    dq = [x.derivative() * (1 / scale) for x in q]
    ddq = [x.derivative() * (1 / scale) for x in dq]
    ctx.cap -= 2
    if problem.tube:    # at each instant its motions differ from this one by unknown constants
        q, dq, ddq = [[x + y for x, y in zip(*both)] for both in zip((q, dq, ddq), problem.tube.play)]
    return q, dq, ddq


# --- The equations -------------------------------------------------------------------------------------------------

def root(x, what):
    """Square root of a series, both proved to be positive (C6); tighter than its method where `x` is wide."""
    found = (x.log() * 0.5).exp() if x[0] > 0 else x
    if not (x[0] > 0 and found[0] > 0):
        raise Undecided("C6", f"{what} > 0 is not proved, its square is in {interval(x[0])}")
    return found


def equations(problem, start, scale):
    """v and l of each cable (m) and w (N, N m), platform's frame, the transpose of R, and kappa, a and e (m) of each
    cable's pulley, as series (see `coordinates`); (C6)."""
    q, dq, ddq = coordinates(problem, start, scale)
    (sa, ca), (sb, cb), (sc, cc) = [x.sin_cos() for x in q[3:]]
    cc_sb, sc_sb = cc * sb, sc * sb
    turn = [[cc * cb, sc * cb, -sb],     # the transpose of R
            [cc_sb * sa - sc * ca, sc_sb * sa + cc * ca, cb * sa],
            [cc_sb * ca + sc * sa, sc_sb * ca - cc * sa, cb * ca]]
    def platform(vector):
        return [dot(row, vector) for row in turn]
    vectors, lengths, wheels = [], [], []
    for i, cable in enumerate(problem.cables, 1):
        a = platform([x - p for x, p in zip(cable.anchor, q)])
        v, wheel = [x - b for x, b in zip(a, cable.attachment)], []
        if cable.axis:
            axis, a = platform(cable.axis), v
            v, e = round_pulley(a, cable.radius, axis, i)
            wheel = [axis, a, e]
        wheels.append(wheel)
        vectors.append(v)
        lengths.append(root(dot(v, v), f"length of cable {i}"))
    (da, db, dc), (dda, ddb, ddc) = dq[3:], ddq[3:]
    spin = [da - dc * sb, db * ca + dc * turn[1][2], dc * turn[2][2] - db * sa]
    d = ddc * cb - dc * (db * sb)
    dspin = [dda - ddc * sb - dc * (db * cb), ddb * ca + d * sa + da * spin[2], d * ca - ddb * sa - da * spin[1]]
    momentum, rate = [[dot(row, x) for row in problem.inertia] for x in (spin, dspin)]
    force = platform([problem.mass * (a - g) - f for a, g, f in zip(ddq, problem.gravity, problem.force)])
    torque = [a + b - c for a, b, c in zip(rate, cross(spin, momentum), platform(problem.torque))]
    return vectors, lengths, force + torque, turn, wheels


def round_pulley(a, r, axis, i):
    """v and e (m) of cable `i`, whose anchor has a pulley; (C6)."""
    height = -dot(a, axis)
    out = [-x - height * k for x, k in zip(a, axis)]
    e = root(dot(out, out), f"e of cable {i}")
    p = e - r
    square = p * p + height * height
    s = root(square - r * r, f"s of cable {i}")
    along, up = (1 + (p * r - height * s) / square) * r / e, (height * r + p * s) / square * r
    return [x + along * y + up * k for x, y, k in zip(a, out, axis)], e


# --- Pieces of time: (C6), (C7), (C8), (C16), (C18) ------------------------------------------------------------------------

def unknowns(problem, span):
    """What the fields of a span or an instant say. With L_i v = (v, b_i x v), so that column i of V is L_i v_i:
    B (None of six cables, where it is 1), the C L_i, the matrix of C and all -C L_i side by side, polynomials in
    tau of s where y is y-hat (N/m), by how much s may differ from them (N/m), and with a law that shares the load
    the vectors whose product with v_i is c_i l_i."""
    inverse, basis = arb_mat(span["inverse"]), None
    levers = [inverse * arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -z, y], [z, 0, -x], [-y, x, 0]])
              for x, y, z in (cable.attachment for cable in problem.cables)]
    beside = arb_mat([row + [-x for lever in levers for x in lever.tolist()[k]]
                      for k, row in enumerate(inverse.tolist())])
    guess, spread = [arb_poly(c) for c in span["solution"]], [arb(e) for e in span["error"]]
    if "basis" in span:
        basis = arb_mat(span["basis"])
        guess = [base + sum(b * g for b, g in zip(row, guess)) for base, row in zip(span["base"], basis.tolist())]
        spread = through(basis, spread)
    pushes = []
    if "multipliers" in span:
        force, torque = [[arb(x) for x in z] for z in (span["multipliers"][:3], span["multipliers"][3:])]
        pushes = [[x + y for x, y in zip(force, cross(torque, cable.attachment))] for cable in problem.cables]
    return basis, levers, beside, guess, spread, pushes


def through(basis, sizes):
    """By how much s differs where y differs by at most `sizes`."""
    return sizes if basis is None else [sum(abs(b) * e for b, e in zip(row, sizes)) for row in basis.tolist()]


def functions(problem, start, scale, s, pushes=()):
    """The functions of time that a piece is judged by, where s (N/m) is the guess: v, l, w and all v s, l s, and
    with margins K, each e, what else `equations` gives, and l s - c of each of `pushes` (see `unknowns`)."""
    vectors, lengths, w, turn, wheels = equations(problem, start, scale)
    pulls = [a * b for a, b in zip(lengths, s)]
    found = vectors, lengths, w + [x * y for v, y in zip(vectors, s) for x in v], pulls
    if problem.tube:
        torques = stiffness(turn, problem.cables, vectors, lengths, wheels, pulls)
        off = [pull - dot(push, v) / length for push, v, length, pull in zip(pushes, vectors, lengths, pulls)]
        found += torques, [wheel[2] for wheel in wheels if wheel], turn, wheels, off
    return found


def judge(problem, span, given, numbers, middle, whole):
    """(C7), and (C8) of the cables `numbers` (from 0), and with margins (C16) and (C18), in a piece of time:
    `functions` in its middle and over all."""
    basis, levers, beside, _, spread, pushes = given
    order, coarse = ctx.cap - 1, min(ctx.cap - 1, COARSE)
    residual = beside * models(middle[2], whole[2], order) * bernstein(order)
    r = [largest([abs(x).upper() for x in row]) for row in residual.tolist()]
    product = arb_mat([(lever * models(a, b, coarse)).entries()     # the transpose of C V B, a model each entry
                       for lever, a, b in zip(levers, middle[0], whole[0])])
    product = (product if basis is None else basis.transpose() * product).tolist()
    rho = []
    for k in range(6):
        first, last = k * (coarse + 1), (k + 1) * (coarse + 1)
        product[k][first] -= 1
        rho.append(sum(abs(x).upper() for row in product for x in row[first:last]))
    if not largest(rho) < 1:
        raise Undecided("C7", f"expected rho < 1, proved rho <= {float(largest(rho)):.6g} only")
    tail = largest(r) / (1 - largest(rho))
    bounds = [x + y * tail for x, y in zip(r, rho)]
    for k, bound in enumerate(bounds):
        if not bound <= span["error"][k]:
            raise Undecided("C7", f"unknown {k + 1}: the file's error is {span['error'][k]:.17g}, "
                                  f"proved {float(bound.upper()):.17g} only")
    pulls, lengths = [extents([middle[m][i] for i in numbers], [whole[m][i] for i in numbers]) for m in (3, 1)]
    tube, sharp, distance, proved = problem.tube, through(basis, bounds), 0, 0
    friction = arb(tube.margins["friction"]) if tube else 0
    if pushes:
        distance, proved = span["distance"], judge_law(problem, span["distance"], sharp, pulls, lengths,
                                                       extents(middle[8], whole[8]))
    for i, pull, length in zip(numbers, pulls, lengths):
        least, most = reach(pull, length, spread[i])
        if pushes:
            p, q = kept(tube, problem.cables[i])
            least, most = p.max(least - distance), q.min(most + distance)
        least, most = least - friction, most + friction
        low, high = span["least"][i], span["greatest"][i]
        if not (least >= low and most <= high):
            raise Undecided("C8", f"cable {i + 1}: the file's bounds are [{low:.17g}, {high:.17g}] N, proved "
                                  f"[{float(least.lower()):.17g}, {float(most.upper()):.17g}] N only")
    if tube:
        judge_tube(problem, sharp, proved, pulls, lengths, middle, whole)


def prove_parts(problem, span, given, centre, scale):
    """(C6) to (C8), (C16) and (C18) at the times centre + scale tau (s), tau in [-1, 1], cut in halves as need be."""
    parts = [(arb(0), arb(1), 0)]
    while parts:
        tau, half, depth = parts.pop()
        ctx.cap = ORDER + 1
        try:
            found = []
            for x in tau, arb(tau, half):
                s = [arb_series(g(arb_poly([x, half]))) for g in given[3]]
                found.append(functions(problem, begin(problem, centre + scale * x), scale * half, s, given[5]))
            judge(problem, span, given, range(len(problem.cables)), *found)
        except Undecided as fault:
            at = f"t = {float(centre + scale * tau):.9g}"
            demand(depth < HALVINGS, fault.condition, f"{at}: {fault.message}")
            parts += [(tau + half / 2, half / 2, depth + 1), (tau - half / 2, half / 2, depth + 1)]


def prove_constant(problem, span, given, numbers, start):
    """(C6) to (C8), (C16) and (C18) of the cables `numbers` where what `begin` gives is in `start` and the polynomials are
    constant."""
    ctx.cap = 1
    found = functions(problem, start, arb(1), [arb_series(g) for g in given[3]], given[5])
    judge(problem, span, given, numbers, found, found)


def prove_rest(problem, span, given):
    """(C6) to (C8), (C16) and (C18) of the last span: all at once, or of a piece of 1/mu and then of the rest."""
    if problem.piece:
        return prove_constant(problem, span, given, range(len(problem.cables)), arb(0))
    start, scale = arb(span["from"]), 1 / (2 * problem.slow)
    for left in range(RESTS, -1, -1):
        try:
            return prove_constant(problem, span, given, range(len(problem.cables)), decays_rest(problem, start))
        except Undecided as fault:
            demand(left > 0, fault.condition, f"t >= {float(start):.9g}: {fault.message}")
        prove_parts(problem, span, given, start + scale, scale)
        start += 2 * scale


# --- Verdicts: (C5) to (C13) ---------------------------------------------------------------------------------------

def check_admissible(problem, proof, cables):
    """(C5) to (C10), (C14) to (C16) and (C18)."""
    spans, pieces = proof["spans"], [None] * len(proof["spans"])
    if "step" in proof["problem"]:
        check_times(proof["problem"]["step"], spans)
    else:
        pieces = motions.check(proof["problem"]["motion"], proof)
    for name, pick in ("least", min), ("greatest", max):
        found = pick(pick(span[name]) for span in spans)
        demand(proof[name] == found, "C10", f"{name}: expected {found}, found {proof[name]}")
    for k, (span, piece) in enumerate(zip(spans, pieces), 1):
        problem = problem._replace(piece=piece)
        for i, cable in enumerate(cables):
            for low, high in (cable["least"], span["least"][i]), (span["greatest"][i], cable["greatest"]):
                demand(low < high, "C9", f"span {k}, cable {i + 1}: expected {low} < {high}")
        given = unknowns(problem, span)
        try:
            if k == len(spans):
                prove_rest(problem, span, given)
            else:
                first, last = arb(span["from"]), arb(span["to"])
                prove_parts(problem, span, given, (first + last) / 2, (last - first) / 2)
        except Refused as fault:
            raise Refused(fault.condition, f"span {k}, {fault.message}") from None
    jump = ", jumps of at most {:.3g} (m, rad) and {:.3g} (m/s, rad/s)".format(*proof["jump"]) if "jump" in proof else ""
    return f"{proof['least']:.9g} to {proof['greatest']:.9g} N, {len(spans)} spans{jump}"


def check_six(problem, instant, cables):
    """(C11) and (C12)."""
    number, least, most, time = instant["cable"], instant["least"], instant["greatest"], instant["time"]
    demand(time >= 0, "C11", f"instant: expected time >= 0, found {time}")
    demand(type(number) is int and 1 <= number <= 6, "C1", f"instant.cable: expected 1 to 6, found {brief(number)}")
    cable = cables[number - 1]
    demand(most <= cable["least"] or least >= cable["greatest"], "C12",
           f"instant, cable {number}: expected bounds outside {cable['least']} to {cable['greatest']} N, "
           f"found {least} to {most} N")
    span = instant | {"least": [least] * 6, "greatest": [most] * 6}
    prove_constant(problem, span, unknowns(problem, span), [number - 1], decays(problem, arb(time)))
    return f"cable {number} at {time:.9g} s: {least:.9g} to {most:.9g} N"


def check_farkas(problem, instant, cables):
    """(C13)."""
    z, time, shortfall = instant["multipliers"], instant["time"], instant["shortfall"]
    demand(time >= 0, "C13", f"instant: expected time >= 0, found {time}")
    ctx.cap = 1
    vectors, lengths, w, *_ = equations(problem, decays(problem, arb(time)), arb(1))
    most, size = arb(0), arb(0)
    for i, (cable, v, length) in enumerate(zip(cables, vectors, lengths)):
        v = [x[0] for x in v]
        c = (dot(z, v) + dot(z[3:], cross(problem.cables[i].attachment, v))) / length[0]
        size += abs(c)
        limited = cable["greatest"] < math.inf
        demand(limited or c <= 0, "C13", f"instant, cable {i + 1}: expected c <= 0, found {interval(c)}")
        most += largest([c * cable["least"], c * cable["greatest"]]) if limited else c * cable["least"]
    pull = dot(z, [x[0] for x in w]) + dot(z[3:], [x[0] for x in w[3:]])
    demand(pull > most, "C13", f"instant: expected z.w > H, found {interval(pull)} and {interval(most)}")
    found = (pull - most) / size
    demand(shortfall <= found, "C13", f"instant: the shortfall is {shortfall:.17g}, proved {interval(found)} only")
    return f"at {time:.9g} s, short by {shortfall:.9g} N"


def check(text):
    """The verdict that the proof `text` (string or bytes) proves; raises `Refused` if it proves none."""
    ctx.prec = BITS
    proof = read_file(text)
    rig, step = proof["problem"]["rig"], proof["problem"].get("step")
    problem = prepare(rig, step)
    if "tube" in proof:
        problem = problem._replace(tube=make_tube(problem, proof["problem"]["margins"], proof["tube"]))
    if step:
        angles = check_angles(problem)
    if problem.tube:
        check_intrusion(problem.tube)
        check_disturbance(problem, *angles[:2])
    if "spans" in proof:
        bounds = check_admissible(problem, proof, rig["cables"])
    else:
        bounds = (check_six if len(rig["cables"]) == 6 else check_farkas)(problem, proof["instant"], rig["cables"])
    return Verdict(proof["verdict"], bounds, proof["sha256"])


def main(names):
    """Checks files and prints a line of each; the exit code."""
    if not names or any(name.startswith("-") for name in names):
        print("usage: python check_proof.py FILE...", file=sys.stderr)
        return 2
    code = 0
    for name in names:
        try:
            with open(name, "rb") as file:
                verdict = check(file.read(SIZE + 1))
            line = f"accepted: {verdict.verdict}, {verdict.bounds}, problem {verdict.sha256}"
        except Exception as fault:      # whatever it is, this file is not accepted
            kind = "" if isinstance(fault, (Refused, OSError)) else f"the checker failed: {type(fault).__name__}, "
            line, code = f"REFUSED: {kind}{fault}", 1
        print(f"{name}: {line}".encode(errors="backslashreplace").decode())
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
