"""What the page says of margins, tried on robots that are wrong in all ways at once: plain floats, no proof files.

The plant is Newton's and Euler's equations about the true centre of mass, with pulleys and rotations as test_check_proof.py
has them; the checker's `margins.py` is asked for the tube and for G only.
"""
import math
import random

import pytest
from flint import arb, arb_series, ctx

import margins as page
from check_proof import decays, functions, prepare
from test_check_proof import (apply, compose, cross, invert, jets, leaving, make_rig, product, transpose, turns)

NAMES = "mass centreOfMass force torque friction accuracy samplePeriod delay".split()
LAW_MARGIN = 0.5     # m of (D1) of the robots here, N
WRONG = dict(zip(NAMES, (2e-3, 2e-4, 0.01, 1e-3, 4e-3, 4e-5, 4e-4, 2e-4)))


def norm(vector):
    return math.hypot(*vector)


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def plus(*vectors):
    return [sum(x) for x in zip(*vectors)]


def times(x, vector):
    return [x * y for y in vector]


def rotation(angles):
    return product(product(turns((angles[2], 0, 0), 2)[0], turns((angles[1], 0, 0), 1)[0]), turns((angles[0], 0, 0), 0)[0])


def spin(q, dq, ddq):
    """Angular velocity and acceleration in the platform's frame, from derivatives of R."""
    z, y, x = [turns((q[k], dq[k], ddq[k]), axis) for k, axis in ((5, 2), (4, 1), (3, 0))]
    r, dr, ddr = compose(compose(z, y), x)
    back = transpose(r)
    velocity, second = product(back, dr), product(back, ddr)
    square = product(velocity, velocity)
    found = [[p - s for p, s in zip(*rows)] for rows in zip(second, square)]
    return [[m[2][1], m[0][2], m[1][0]] for m in (velocity, found)]


def pulls_along(rig, q):
    """Directions of the cables in the platform's frame, and their lengths."""
    r = rotation(q[3:])
    directions, lengths = [], []
    for cable in rig["cables"]:
        end = plus(q[:3], apply(r, cable["attachment"]))
        v = apply(transpose(r), minus(leaving(cable, end), end))
        lengths.append(norm(v))
        directions.append(times(1 / lengths[-1], v))
    return directions, lengths


def torque(rig, q, u):
    return plus(*[times(x, cross(c["attachment"], d)) for c, d, x in zip(rig["cables"], pulls_along(rig, q)[0], u)])


def shared(columns, wrench, cables, margin, weight):
    """The tensions of (D1), `columns` being those of W: Newton's method for the multipliers y, where tension i is the
    one inverse of its summand's derivative at c_i, and W u = w tells the optimum."""
    def pull(c, cable):
        """Tension, its derivative by c and what y minimises of this cable."""
        least, most = cable["least"], cable["greatest"]
        reference = least + min(weight, (most - least) / 2)
        u = reference + c
        end = min(max(u, least + margin), most - margin)
        slope = 1.0 if u == end else 1 / (1 + 1e8)
        u = end + (u - end) * slope
        if not least <= u <= most:
            u, slope = min(max(u, least), most), 0.0
        return u, slope, c * u - (u - reference) ** 2 / 2 - 1e8 * (u - end) ** 2 / 2
    def at(y):
        found = [pull(x, cable) for x, cable in zip(apply(columns, y), cables)]
        u, slopes, values = map(list, zip(*found))
        return u, slopes, sum(values) - sum(a * b for a, b in zip(y, wrench)), minus(wrench, apply(transpose(columns), u))
    y = [0.0] * 6
    u, slopes, value, rest = at(y)
    for _ in range(100):
        if norm(rest) < 1e-9 * norm(wrench):
            return u
        hessian = product(transpose(columns), [times(s, row) for s, row in zip(slopes, columns)])
        step, share = apply(invert(hessian), rest), 1.0
        while True:
            other = plus(y, times(share, step))
            u, slopes, new, rest = at(other)
            if new <= value + 1e-12 * abs(value) or share < 1e-9:
                break
            share /= 2
        y, value = other, new
    raise AssertionError(f"(D1) not solved: {rest}")


def tensions(rig, q, dq, a, margin=LAW_MARGIN):
    """What the law computes: six tensions, or more of (D1)."""
    r = transpose(rotation(q[3:]))
    directions, _ = pulls_along(rig, q)
    omega, alpha = spin(q, dq, a)
    force = minus(times(rig["mass"], minus(a[:3], rig["gravity"])), rig["disturbance"][:3])
    turn = minus(plus(apply(rig["inertia"], alpha), cross(omega, apply(rig["inertia"], omega))),
                 apply(r, rig["disturbance"][3:]))
    columns = [d + cross(c["attachment"], d) for c, d in zip(rig["cables"], directions)]
    wrench = apply(r, force) + turn
    if len(columns) > 6:
        return shared(columns, wrench, rig["cables"], margin, rig["mass"] * norm(rig["gravity"]))
    return apply(invert(transpose(columns)), wrench)


def commanded(step, q, dq):
    total, many = step["lambda"] + step["eta"], step["lambda"] * step["eta"]
    return [-total * v - many * (x - p) for x, v, p in zip(q, dq, step["setPoint"])]


def happens(rig, plant, q, dq, u):
    """q'' of the plant at tensions commanded."""
    r = rotation(q[3:])
    directions, _ = pulls_along({"cables": plant["cables"]}, q)
    offset, forces = plant["offset"], [times(x + f, d) for x, f, d in zip(u, plant["friction"], directions)]
    omega, _ = spin(q, dq, [0.0] * 6)
    about = plus(*[cross(minus(c["attachment"], offset), f) for c, f in zip(plant["cables"], forces)])
    about = plus(about, apply(transpose(r), plus(rig["disturbance"][3:], plant["torque"])))
    alpha = apply(invert(plant["inertia"]), minus(about, cross(omega, apply(plant["inertia"], omega))))
    force = plus(apply(r, plus(*forces)), rig["disturbance"][:3], plant["force"])
    turned = plus(cross(alpha, offset), cross(omega, cross(omega, offset)))
    place = minus(plus(times(1 / plant["mass"], force), rig["gravity"]), apply(r, turned))
    rest = minus(alpha, spin(q, dq, [0.0] * 6)[1])
    unit = [spin(q, [0.0] * 6, [0.0] * 3 + [float(j == k) for j in range(3)])[1] for k in range(3)]
    return place + apply(invert(transpose(unit)), rest)


def direction(draw):
    found = [draw.gauss(0, 1) for _ in range(3)]
    return times(1 / norm(found), found)


def jolted(draw, point, r):
    return plus(point, times(r, direction(draw)))


def wrong_plant(draw, rig, margins):
    """All that the margins allow, at their ends."""
    share = margins["mass"]
    inertia = [[0.0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(i + 1):
            inertia[i][j] = inertia[j][i] = rig["inertia"][i][j] * (1 + share * draw.choice((-1, 1)))
    cables = [c | {"anchor": jolted(draw, c["anchor"], margins["accuracy"]),
                   "attachment": jolted(draw, c["attachment"], margins["accuracy"])} for c in rig["cables"]]
    return {"mass": rig["mass"] * (1 + share * draw.choice((-1, 1))), "inertia": inertia, "cables": cables,
            "offset": times(margins["centreOfMass"], direction(draw)),
            "force": times(margins["force"], direction(draw)), "torque": times(margins["torque"], direction(draw)),
            "friction": [margins["friction"] * draw.choice((-1, 1)) for _ in cables]}


def random_problem(draw, pulley, skew=False, torque=0.0, cables=6):
    rig = make_rig(cables, pulley)
    for cable in rig["cables"]:
        cable["anchor"] = [x + draw.uniform(-0.1, 0.1) for x in cable["anchor"]]
        cable["attachment"] = [x + draw.uniform(-0.03, 0.03) for x in cable["attachment"]]
    if skew:
        rig["inertia"] = [[0.25, 0.2, 0.0], [0.2, 0.25, 0.0], [0.0, 0.0, 0.4]]
    rig["disturbance"] = [0.0] * 3 + times(torque, direction(draw))
    step = {"start": [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], "rates": [draw.uniform(-0.1, 0.1) for _ in range(6)],
            "setPoint": [draw.uniform(-0.1, 0.1) + x for x in (0, 0, 1, 0, 0, 0)],
            "lambda": draw.uniform(1, 4), "eta": draw.uniform(1, 4)}
    return {"rig": rig, "step": step}


def floats(balls):
    return [float(x.upper()) for x in balls]


def stiffness(rig, q, u):
    """K by differences of the torque."""
    h, columns, r = 1e-5, [], rotation(q[3:])
    for k in range(6):
        found = []
        for x in (-h, h):
            if k < 3:
                moved = [q[j] + x * (j == k) for j in range(3)] + list(q[3:])
            else:
                m = product(r, turns((x, 0, 0), k - 3)[0])
                moved = list(q[:3]) + [math.atan2(m[2][1], m[2][2]), math.asin(-m[2][0]), math.atan2(m[1][0], m[0][0])]
            found.append(torque(rig, moved, u))
        columns.append(times(1 / (2 * h), minus(found[1], found[0])))
    return transpose(columns)


def measures(problem, states):
    """`tube` (without D) of states (q, what tensions there are): no room at all."""
    rig = problem["rig"]
    found = {"pull": max(sum(map(abs, u)) for _, u in states),
             "shortest": min(min(pulls_along(rig, q)[1]) for q, _ in states)}
    if "pulley" in rig["cables"][0]:
        found["sideways"] = min(norm(plus(q[:3], apply(rotation(q[3:]), c["attachment"]), times(-1, c["anchor"]))[:2])
                                for q, _ in states for c in rig["cables"])      # the axes are vertical
    k = [stiffness(rig, q, u) for q, u in states]
    return found | {"stiffness": [[max(abs(x[i][j]) for x in k) for j in range(6)] for i in range(3)]}


def settle(problem, margins, claim, factor=1.02):
    """D by iteration, a little above G: the tube, and G."""
    ctx.prec = 128
    balls = prepare(problem["rig"], problem["step"])
    d = [0.0] * 6
    for _ in range(60):
        tube = page.make_tube(balls, margins, claim | {"disturbance": d})
        swing = [abs(problem["step"]["setPoint"][k]) + abs(problem["step"]["start"][k] - problem["step"]["setPoint"][k])
                 + abs(problem["step"]["rates"][k]) / min(problem["step"]["lambda"], problem["step"]["eta"])
                 + float(tube.play[0][k].rad()) for k in (3, 4)]
        g = floats(page.disturbance(balls._replace(tube=tube), *[balls.mass * 0 + x for x in swing]))
        if all(x < y or x == y == 0 for x, y in zip(g, d)):
            return tube, g
        d = [factor * x for x in g]
    raise AssertionError(f"D does not settle, {d}")


def corner(draw, sizes):
    return [draw.choice((-1, 1)) * x for x in sizes]


def off_course(draw, step, d):
    """Deviations of coordinates and rates at an end of the tube, where the law commands no more than the tube allows."""
    slow, fast = sorted((step["lambda"], step["eta"]))
    decay = math.exp(-slow * math.log(fast / slow) / (fast - slow))
    off, turn = corner(draw, [x / (slow * fast) for x in d]), corner(draw, [2 * decay / fast * x for x in d])
    asked = [abs((slow + fast) * y + slow * fast * x) for x, y in zip(off, turn)]
    shares = [min(1.0, (1 + 2 * slow / fast * decay ** 2) * x / y) if y else 0.0 for x, y in zip(d, asked)]
    return [x * y for x, y in zip(shares, off)], [x * y for x, y in zip(shares, turn)]


def tried(draw, problem, margins, count):
    """Largest |d_k|/G_k of robots at the ends of the tube, each wrong in its own way; the tube's measures are those of
    the states that come up, without room."""
    rig, step = problem["rig"], problem["step"]
    start = [j[0] for j in jets(step, 0.0)]
    far = tensions(rig, start, [0.0] * 6, [0.0] * 6)
    tube, _ = settle(problem, margins, measures(problem, [(start, far)]))
    cases, states = [], []
    for _ in range(count):
        t = draw.choice((0.0, draw.expovariate(1.0)))
        q, dq, _ = map(list, zip(*jets(step, t)))
        off, turn = off_course(draw, step, tube.claim["disturbance"])
        q, dq = plus(q, off), plus(dq, turn)
        theta = margins["samplePeriod"] + margins["delay"]
        ddq = plus(commanded(step, q, dq), corner(draw, tube.claim["disturbance"]))
        old, rates = plus(q, times(-theta, dq)), plus(dq, times(-theta, ddq))
        plant = wrong_plant(draw, rig, margins)
        u = tensions(rig, old, rates, commanded(step, old, rates))
        found = minus(happens(rig, plant, q, dq, u), commanded(step, q, dq))
        cases.append(found)
        states += [(q, u), (old, u)]
    claim = measures(problem, states)
    _, g = settle(problem, margins, claim)
    return max(max(abs(x) / y for x, y in zip(found, g) if y > 0) for found in cases)


def only(name):
    return {k: WRONG[k] if name in (k, "all") else 0.0 for k in NAMES}


@pytest.mark.parametrize("cables", [6, 8])
@pytest.mark.parametrize("name", NAMES + ["all"])
def test_no_robot_is_disturbed_by_more_than_g(name, cables):
    draw = random.Random(NAMES.index(name) if name in NAMES else 9)
    found = [tried(draw, random_problem(draw, pulley, cables=cables), only(name), 12) for pulley in (False, True)]
    assert 0.2 < max(found) <= 1 + 1e-9


def test_products_of_inertia_that_are_wrong_disturb_by_no_more_than_g():
    """(1 - delta) in the place of 1 - delta M gives G that this |d| is more than twice of."""
    draw = random.Random(1)
    assert 0.5 < tried(draw, random_problem(draw, False, skew=True), only("mass"), 20) <= 1 + 1e-9


def test_a_torque_of_the_base_frame_turns_while_a_command_is_held():
    """Without theta w |n_0| in G this |d| is five times G."""
    draw = random.Random(5)
    problem = random_problem(draw, False)
    problem["rig"]["disturbance"] = [0.0, 0.0, 0.0, -2.0, 0.0, 0.0]
    problem["step"].update({"rates": [0.0] * 5 + [0.1], "setPoint": [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], "lambda": 0.3, "eta": 0.4})
    assert 0.5 < tried(draw, problem, dict.fromkeys(NAMES, 0.0) | {"delay": 1e-5}, 12) <= 1 + 1e-9


@pytest.mark.parametrize("pulley", [False, True])
def test_stiffness_is_what_the_torque_changes_by(pulley):
    draw = random.Random(2)
    problem = random_problem(draw, pulley)
    tube, _ = settle(problem, dict.fromkeys(NAMES, 0.0), {"pull": 1.0, "shortest": 1.0, "stiffness": [[0.0] * 6] * 3}
                     | ({"sideways": 1.0} if pulley else {}))
    balls = prepare(problem["rig"], problem["step"])._replace(tube=tube)
    for t in 0.0, 0.4:
        q, u = [j[0] for j in jets(problem["step"], t)], [draw.uniform(1, 30) for _ in range(6)]
        ctx.cap = 1
        guess = [arb_series([x / l]) for x, l in zip(u, pulls_along(problem["rig"], q)[1])]
        found = floats(x[0] for x in functions(balls, decays(balls, arb(t)), arb(1), guess)[4])
        assert found == pytest.approx(sum(stiffness(problem["rig"], q, u), []), abs=1e-6)


def simulated(draw, problem, margins, seconds, tube, g):
    """Largest share of the tube, of coordinates, rates, commands and disturbances, that a robot takes which is wrong in
    all ways, its forces and friction against one coordinate; a command is held for a period, of an old state."""
    rig, step, plant = problem["rig"], problem["step"], wrong_plant(draw, problem["rig"], margins)
    slow, fast = sorted((step["lambda"], step["eta"]))
    decay, h = math.exp(-slow * math.log(fast / slow) / (fast - slow)), margins["samplePeriod"] / 2
    d, late = tube.claim["disturbance"], round(margins["delay"] / h)
    allowed = [[x / (slow * fast) for x in d], [2 * decay / fast * x for x in d],
               [(1 + 2 * slow / fast * decay ** 2) * x for x in d], g]
    q, dq, _ = map(list, zip(*jets(step, 0.0)))
    past, worst = [(q, dq)], 0.0
    for k in range(int(seconds / h)):
        if k % 2 == 0:
            old, rates = past[max(0, len(past) - 1 - late)]
            u = tensions(rig, old, rates, commanded(step, old, rates))
        middle = happens(rig, plant, q, dq, u)
        asked, (closed, closed_rates, closed_commands) = commanded(step, q, dq), map(list, zip(*jets(step, k * h)))
        off = [minus(q, closed), minus(dq, closed_rates), minus(asked, closed_commands), minus(middle, asked)]
        worst = max([worst] + [abs(x) / y for kind, most in zip(off, allowed) for x, y in zip(kind, most)])
        half, half_rates = plus(q, times(h / 2, dq)), plus(dq, times(h / 2, middle))
        q, dq = plus(q, times(h, half_rates)), plus(dq, times(h, happens(rig, plant, half, half_rates, u)))
        past.append((q, dq))
    return worst


def test_a_simulated_robot_stays_in_the_tube():
    draw = random.Random(4)
    problem, margins = random_problem(draw, True), {k: x / 4 for k, x in WRONG.items()} | {"samplePeriod": 2e-3, "delay": 1e-3}
    states = []
    for t in range(30):
        q, dq, ddq = map(list, zip(*jets(problem["step"], t / 10)))
        states.append((q, tensions(problem["rig"], q, dq, ddq)))
    claim = measures(problem, states)
    claim |= {"pull": 1.05 * claim["pull"], "shortest": 0.97 * claim["shortest"],
              "stiffness": [[1.1 * x + 0.5 for x in row] for row in claim["stiffness"]]}
    tube, g = settle(problem, margins, claim)
    assert 0.1 < simulated(draw, problem, margins, 0.4, tube, g) < 1
