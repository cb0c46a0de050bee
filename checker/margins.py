"""Margins of proof files: the tube about the closed form and conditions (C16) to (C18), in balls. Names are the page's.

Everything here speaks of robots with one `tube`: a verdict of admissible.
"""
from fractions import Fraction
from collections import namedtuple

from flint import arb, arb_mat

from enclosures import Undecided, cross, dot, extents, largest, reach
from proof_file import Refused, demand

AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]

# `play`: balls about 0 of what coordinates, rates and accelerations may differ by from the closed form (eps of the
# page). V, A, B, L as sizes, Theta (s); `margins` and `claim` are the file's `problem.margins` and `tube`.
Tube = namedtuple("Tube", "play V A B L Theta margins claim")


def make_tube(problem, margins, claim):
    """The sizes of the tube that the file claims."""
    slow, fast, gap = problem.slow, problem.fast, problem.gap
    total, product = slow + fast, slow * fast
    decay = (-slow * ((gap / slow).log1p() / gap if gap > 0 else 1 / slow)).exp()      # at t*
    peak, turns = decay / fast, 1 + 2 * slow / fast * decay ** 2                         # phi* and 1 + 2 Z
    theta = arb(margins["samplePeriod"]) + arb(margins["delay"])
    play, sizes = [], []
    for e, v, d in zip(problem.error, problem.rates, claim["disturbance"]):
        e, v, d = abs(e), abs(v), arb(d)
        rate = product * peak * e + v + 2 * peak * d
        commanded = product * e + total * v + turns * d
        happens = commanded + d
        late = theta * (product * rate + total * happens)
        sizes.append((rate, commanded, happens, late))
        play.append((d / product + theta * rate, 2 * peak * d + theta * happens, turns * d + late))
    balls = [[arb(0, x.upper()) for x in kind] for kind in zip(*play)]
    return Tube(balls, *map(list, zip(*sizes)), theta, margins, claim)


# --- What disturbs: (C17) ------------------------------------------------------------------------------------------

def lin(six):
    return sum(x * x for x in six[:3]).sqrt()


def ang(six):
    return sum(six[3:])


def sums(matrix, vector):
    """Of each row the sum of its entries' sizes times the vector's entries."""
    return [sum(abs(x) * y for x, y in zip(row, vector)) for row in matrix]


def directions(problem, tube):
    """beta, psi, kappa_p and rho': how much the cables' directions are off (rad) and how fast they turn (rad/s)."""
    r, claim = arb(tube.margins["accuracy"]), tube.claim
    wheel = largest([cable.radius for cable in problem.cables])
    rho = largest([dot(b, b).sqrt() for b in (cable.attachment for cable in problem.cables)])
    far = (arb(claim["shortest"]) ** 2 + wheel ** 2).sqrt() - 2 * r
    demand(far > wheel, "C17", f"expected d > {float(wheel)} m, found {float(far)}")
    length = (far ** 2 - wheel ** 2).sqrt()
    beta = 2 * r / length
    extra = arb(0)
    if "sideways" in claim:
        aside = arb(claim["sideways"]) - 2 * r
        demand(aside >= wheel, "C17", f"expected sideways - 2 r >= {float(wheel)} m, found {float(aside)}")
        extra = beta * (1 + far / length) + 12 * r / aside
    return beta, (lin(tube.V) + ang(tube.V) * (rho + r)) / length, 2 * r / rho + 3 * beta + extra, rho + r


def disturbance(problem, roll, pitch):
    """G (m/s^2, rad/s^2), where |roll| and |pitch| (rad) are at most these."""
    tube = problem.tube
    margins, V, A, L, theta = tube.margins, tube.V, tube.A, tube.L, tube.Theta
    share, offset, friction, r = [arb(margins[name]) for name in ("mass", "centreOfMass", "friction", "accuracy")]
    pull, n, mass, g = arb(tube.claim["pull"]), len(problem.cables), problem.mass, problem.gravity
    w, z = ang(V), ang(tube.B)
    alpha = z + w * w
    beta, psi, skew, lever = directions(problem, tube)
    force = pull * (theta * psi + beta) + n * friction
    t = V[:3] + [V[3] + pitch * V[5], V[4] + roll * V[5], V[5] + roll * V[4]]
    torque = [theta * (x + pull * lever * (w + psi) * skew) + pull * (lever * beta + r) + lever * n * friction
              for x in sums(tube.claim["stiffness"], t)]
    H = [a + abs(x) + abs(f) / mass for a, x, f in zip(A, g, problem.force)] + A[3:]
    found = [(late + share * h + (force + arb(margins["force"])) / mass) / (1 - share) + offset * (alpha + w * w)
             for late, h in zip(L[:3], H)]
    size = sum(x * x for row in problem.inertia for x in row).sqrt()
    other = (size * w * (2 * theta * alpha + share * w) + offset * (mass * (lin(H) + lin(L)) + force)
             + arb(margins["torque"]) + theta * w * dot(problem.torque, problem.torque).sqrt())
    inverse, amplified = inverses(problem.inertia, share)
    y = amplified([ang(L) + theta * w * (3 * z + w * w) + x for x in sums(inverse, [x + other for x in torque])],
                  ang(A) + w * w)
    aside = roll * y[1] + y[2]
    return found + [y[0] + pitch.tan() * aside, y[1] + roll * y[2], aside / pitch.cos()]


def inverses(inertia, share):
    """The inverse of I, and y where y = x + delta M (y + a), M = |I^-1| |I|, as a function of x and a."""
    try:
        inverse = arb_mat(inertia).inv()
    except ZeroDivisionError:
        raise Refused("C17", "the inertia is not proved to be regular") from None
    m = share * sizes(inverse) * sizes(arb_mat(inertia))
    demand(all(sum(row) < 1 for row in m.tolist()), "C17", "expected delta times the sums of M's rows below 1")
    def amplified(x, a):
        right = [[b + sum(row) * a] for b, row in zip(x, m.tolist())]
        return (arb_mat([[int(i == j) for j in range(3)] for i in range(3)]) - m).solve(arb_mat(right)).entries()
    return inverse.tolist(), amplified


def sizes(matrix):
    return arb_mat([[abs(x) for x in row] for row in matrix.tolist()])


def check_disturbance(problem, roll, pitch):
    """(C17), where |roll| and |pitch| (rad) are at most these."""
    for k, (g, d) in enumerate(zip(disturbance(problem, roll, pitch), problem.tube.claim["disturbance"]), 1):
        demand(g < d or (d == 0 and g == 0), "C17",
               f"coordinate {k}: expected G < {d:.17g}, what the file claims, found {float(g.upper()):.17g}")


# --- The tube's geometry: (C16) ------------------------------------------------------------------------------------

def stiffness(turn, cables, vectors, lengths, wheels, pulls):
    """K (N, N m), its rows one after the other, of the cables' tensions `pulls` (N); `turn` is the transpose of R,
    and of a cable with a pulley its wheel is kappa, a (m) and e (m). Of series or of balls."""
    shift, twist = [[[0] * 3 for _ in AXES] for _ in range(2)]      # one column an axis, both in the platform's frame
    for cable, v, length, wheel, pull in zip(cables, vectors, lengths, wheels, pulls):
        b, tension = cable.attachment, pull / length
        d = [x / length for x in v]
        swung = [[tension * (axis[k] - d[j] * d[k]) for k in range(3)] for j, axis in enumerate(AXES)]
        if wheel:
            kappa, a, e = wheel
            normal, weight = cross(kappa, a), tension * (1 + dot(kappa, d)) * cable.radius / e / e / e
            swung = [[x - weight * normal[j] * y for x, y in zip(swung[j], normal)] for j in range(3)]
        swung = [cross(b, x) for x in swung]
        along = dot(b, v)
        for j, axis in enumerate(AXES):
            moved = cross(b, axis)
            turned = [tension * (b[j] * x - axis[k] * along) for k, x in enumerate(v)]       # b x (-axis x v)
            for k in range(3):
                shift[j][k] += swung[j][k]
                twist[j][k] += turned[k] + sum(moved[i] * swung[i][k] for i in range(3))
    return [entry for k in range(3) for entry in
            [-sum(turn[i][j] * shift[i][k] for i in range(3)) for j in range(3)] + [twist[j][k] for j in range(3)]]


def judge_tube(problem, spread, distance, pulls, lengths, middle, whole):
    """(C16) in a piece of time, `functions` in its middle and over all, with the extents of l s and l. s (N/m) may
    differ by `spread`, the law's tensions by `distance` (N): what is proved here, mostly less than what the file claims."""
    claim, cables = problem.tube.claim, problem.cables
    torques = extents(middle[4], whole[4])
    aside = extents(middle[5], whole[5]) if middle[5] else []
    def at_most(balls, most, name):
        if not largest(balls) <= most:
            raise Undecided("C16", f"{name}: the file claims {most:.17g}, proved {float(largest(balls).upper()):.17g} only")
    totals = [sum(p + e * x for p, e, x in zip(column[:len(spread)], spread, column[len(spread):]))
              + arb(len(cables)).sqrt() * distance for column in zip(*pulls, *lengths)]
    at_most(totals, claim["pull"], "pull")
    for rows, name in (lengths, "shortest"), (aside, "sideways"):
        for i, row in enumerate(rows, 1):
            at_most([-x for x in row], -claim[name], f"minus {name}, cable {i}")
    vectors, reaches, turn, wheels = constants([whole[m] for m in (0, 1, 6, 7)])
    loose, square = [0] * 18, [0] * 18      # what all spreads add to K, and the sum of k_i squared
    for i, (cable, e) in enumerate(zip(cables, spread)):
        of_one = stiffness(turn, [cable], [vectors[i]], [reaches[i]], [wheels[i]], [arb(1)])
        loose = [x + (e * reaches[i] * abs(y)).upper() for x, y in zip(loose, of_one)]
        square = [x + abs(y).upper() ** 2 for x, y in zip(square, of_one)]
    loose = [x + distance * y.sqrt() for x, y in zip(loose, square)]
    for m, (row, more) in enumerate(zip(torques, loose)):
        at_most([abs(x) + more for x in row], claim["stiffness"][m // 6][m % 6], f"stiffness[{m // 6}][{m % 6}]")


def constants(value):
    """The balls of series at x = 0."""
    return [constants(x) for x in value] if isinstance(value, (list, tuple)) else value[0]


# --- How more than six cables share the load: (C18) ------------------------------------------------------------------

def check_intrusion(tube):
    """`friction` + xi <= m of (C18), exact."""
    if "intrusion" in tube.claim:
        friction, margin, intrusion = tube.margins["friction"], tube.margins["lawMargin"], tube.claim["intrusion"]
        demand(Fraction(friction) + Fraction(intrusion) <= Fraction(margin), "C18",
               f"expected friction + intrusion <= {margin:.17g}, the law's margin, found {friction:.17g} + {intrusion:.17g}")


def kept(tube, cable):
    """p and q: where the law's tensions of a cable are (N)."""
    room = arb(tube.margins["lawMargin"]) - arb(tube.claim["intrusion"])
    return cable.least + room, cable.greatest - room


def judge_law(problem, claimed, spread, pulls, lengths, off):
    """(C18) in a piece of time, where s (N/m) may differ by `spread`: extents of l s, l and l s - c. Returns how far
    the law's tensions are from those of the unknowns at most (N)."""
    tube, surpluses, far = problem.tube, arb(0), arb(0)
    weight, margin = problem.mass * dot(problem.gravity, problem.gravity).sqrt(), arb(tube.margins["lawMargin"])
    for i, (cable, e, pull, length, beside) in enumerate(zip(problem.cables, spread, pulls, lengths, off), 1):
        reference = cable.least + weight.min((cable.greatest - cable.least) / 2)
        p, q = kept(tube, cable)
        (low, high), (below, above) = reach(pull, length, e), reach(beside, length, e)
        if not (low >= cable.least + margin and high <= cable.greatest - margin):
            raise Undecided("C18", f"cable {i}: expected tensions within the law's margin of {float(margin):.17g} N, proved "
                                   f"[{float(low.lower()):.17g}, {float(high.upper()):.17g}] N only")
        far += largest([high - reference, reference - low]).max(arb(0)) ** 2
        surpluses += largest([surplus(high - p, above - reference), surplus(q - low, reference - below)])
    if not far.sqrt() <= 10000 * arb(tube.claim["intrusion"]):
        raise Undecided("C18", f"intrusion: the file claims {tube.claim['intrusion']:.17g}, proved "
                               f"{float(far.sqrt().upper()) / 1e4:.17g} only")
    distance = (2 * surpluses).sqrt().upper()
    if not distance <= claimed:
        raise Undecided("C18", f"distance: the file claims {claimed:.17g}, proved {float(distance):.17g} only")
    return distance


def surplus(room, o):
    """The greatest of s (o - s/2) over s from 0 to `room`, o being negative or not: it grows with both."""
    room, o = room.upper(), o.upper().max(arb(0))
    s = room.min(o)
    return s * (o - s / 2)
