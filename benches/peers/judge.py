"""How near a motion comes to its limits, proved: the least of u - u_min and of u_max - u over all cables and all time, between two bounds.

A motion is a `problem` of docs/proof.md, numbers as floats, of six cables, a `motion` of any number of parts or a `step`. Equations, series and Taylor models are those of the checker of proof
files (checker/), in Arb's ball arithmetic; branch and bound cuts time where the least may be. Nothing here is sampled: what lies between two points counts.
"""

import heapq
import math
import sys
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from flint import arb, arb_mat, arb_poly, arb_series, ctx

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "checker"))
import motions  # noqa: E402
from check_proof import BITS, Undecided, begin, bernstein, cross, decays_rest, equations, largest, models, prepare, unknowns  # noqa: E402

ORDER = 6  # of the remainders of Taylor models
TOLERANCE = 1e-6  # of the weight, between the bounds
CUTS = 1000  # of time at most
INFINITE = float("inf")


@dataclass(frozen=True)
class Segment:
    """Times from `begin` to `end` (s) of a piece of a motion (from 0, -1 the rest after it) or of a step; neighbours have the same double in common, so that none is left out."""

    piece: int
    begin: float
    end: float

    def parts(self, longest):
        cut = self.begin + longest if self.end == INFINITE else 0.5 * (self.begin + self.end)
        return [Segment(self.piece, self.begin, cut), Segment(self.piece, cut, self.end)]


@dataclass(frozen=True)
class Margin:
    """The least margin is in [lower, upper] (N); some cable (from 1) has no more than `upper` at a time (s) of a piece."""

    lower: float
    upper: float
    cable: int = 0
    piece: int = 0
    time: float = 0.0

    def or_less(self, other):
        lower = min(self.lower, other.lower)
        least = min(self, other, key=lambda margin: margin.upper)
        return Margin(lower, least.upper, least.cable, least.piece, least.time)


UNKNOWN = Margin(-INFINITE, INFINITE)


class Judge:
    """Of one problem."""

    def __init__(self, problem):
        ctx.prec = BITS
        rig, step = problem["rig"], problem.get("step")
        if len(rig["cables"]) != 6:
            raise ValueError(f"six cables are judged, whose tensions are the only ones there are, not {len(rig['cables'])}")
        self.problem, self.weight = prepare(rig, step), rig["mass"] * rig["gravity"][2]
        self.limits = [(arb(cable["least"]), arb(cable["greatest"])) for cable in rig["cables"]]
        self.seen, self.longest = {}, 1.0
        if step:
            self.longest = math.nextafter(1 / min(step["lambda"], step["eta"]), INFINITE)
            self.segments, self.pieces = [Segment(0, 0.0, self.longest), Segment(0, self.longest, INFINITE)], None
            return
        self.pieces = motions.prepare(problem["motion"])
        place, _ = motions.state(self.pieces[-1], self.pieces[-1].duration)
        self.pieces.append(motions.Piece(place, [], arb(0)))
        durations = [piece["duration"] for piece in problem["motion"]["pieces"]]
        self.segments = [Segment(k, 0.0, duration) for k, duration in enumerate(durations)] + [Segment(-1, 0.0, INFINITE)]

    def least(self, side):
        """The `Margin` of all time below (0: u - u_min) or above (1: u_max - u)."""
        order, best, heap = count(), UNKNOWN, []
        tolerance = TOLERANCE * self.weight
        found, left = UNKNOWN, self.segments
        for _ in range(CUTS):
            for segment in left:
                margin = self.margins(segment)[side]
                if margin.upper < best.upper:
                    best = margin
                heapq.heappush(heap, (margin.lower, next(order), segment))
            lower, _, segment = heapq.heappop(heap)
            found = Margin(lower, best.upper, best.cable, best.piece, best.time)
            if lower >= best.upper - tolerance:
                break
            left = segment.parts(self.longest)
        return found

    def margins(self, segment):
        """Below and above, in a segment."""
        if segment not in self.seen:
            try:
                self.seen[segment] = self._rest(segment) if segment.end == INFINITE else self._span(segment)
            except Undecided:
                self.seen[segment] = UNKNOWN, UNKNOWN
        return self.seen[segment]

    def at(self, piece, time):
        """Below and above at an instant (s) of a piece (of a step 0)."""
        return self._span(Segment(piece, time, time))

    def _of(self, segment):
        return self.problem._replace(piece=self.pieces[segment.piece]) if self.pieces else self.problem

    def _span(self, segment):
        problem, first, last = self._of(segment), arb(segment.begin), arb(segment.end)
        middle, half = (first + last) / 2, (last - first) / 2 if last > first else arb(1)
        ctx.cap = ORDER + 1 if last > first else 1
        whole = middle + arb(0, half) if last > first else middle
        found = [equations(problem, begin(problem, time), half) for time in (middle, whole)]
        given = self._guess(found[0])
        guesses = [[arb_series(guess(arb_poly([x, 1]))) for guess in given[3]] for x in (arb(0), arb(0, 1))]
        return self._bounds(segment, given, *map(_functions, found, guesses))

    def _rest(self, segment):
        """Of all times from its begin on."""
        problem = self._of(segment)
        ctx.cap = 1
        found = equations(problem, arb(0) if problem.piece else decays_rest(problem, arb(segment.begin)), arb(1))
        given = self._guess(found)
        functions = _functions(found, [arb_series(guess) for guess in given[3]])
        below, above = self._bounds(segment, given, functions, functions)
        if problem.piece:
            return below, above
        return Margin(below.lower, INFINITE), Margin(above.lower, INFINITE)

    def _guess(self, found):
        """What the checker's `unknowns` makes of an approximate inverse and solution: the series of y with V y = w, in doubles."""
        vectors, _, w, *_ = found
        columns = [v + cross(cable.attachment, v) for v, cable in zip(vectors, self.problem.cables)]
        terms = range(ctx.cap)
        matrices = [arb_mat([[column[row][k].mid() for column in columns] for row in range(6)]) for k in terms]
        right = [arb_mat([[x[k].mid()] for x in w]) for k in terms]
        try:
            inverse = matrices[0].inv()
        except ZeroDivisionError:
            raise Undecided("C7", "V is singular") from None
        solved = []
        for k in terms:
            solved.append(inverse * sum((matrices[j] * solved[k - j] * -1 for j in range(1, k + 1)), right[k]))
        rows = [[float(term[row, 0]) for term in solved] for row in range(6)]
        exact = [[float(x) for x in row] for row in inverse.tolist()]
        return unknowns(self.problem, {"inverse": exact, "solution": rows, "error": [0.0] * 6})

    def _bounds(self, segment, given, middle, whole):
        """The lemma of docs/proof.md over a segment, whose functions are given in its middle and over all of it."""
        _, levers, beside, *_ = given
        order = ctx.cap - 1
        residual = beside * models(middle[2], whole[2], order) * bernstein(order)
        r = [largest([abs(x).upper() for x in row]) for row in residual.tolist()]
        # The rows of 1 - C V, with V as one ball over the segment.
        columns = [(lever * arb_mat([[x[0]] for x in v])).entries() for lever, v in zip(levers, whole[0])]
        rho = [sum((abs((row == k) - column[row]).upper() for k, column in enumerate(columns)), arb(0)) for row in range(6)]
        if not largest(rho) < 1:
            raise Undecided("C7", "rho")
        tail = largest(r) / (1 - largest(rho))
        pulls, lengths = ((models(middle[m], whole[m], order) * bernstein(order)).tolist() for m in (3, 1))
        below, above = Margin(INFINITE, INFINITE), Margin(INFINITE, INFINITE)
        for i, (pull, length, (least, greatest)) in enumerate(zip(pulls, lengths, self.limits)):
            error = (r[i] + rho[i] * tail) * largest([x.upper() for x in length])
            below = below.or_less(_margin(segment, i, [x - least for x in pull], error))
            above = above.or_less(_margin(segment, i, [greatest - x for x in pull], error))
        return below, above


def _functions(found, s):
    """Of `equations` and the guessed s (N/m) what a segment is judged by: v, l, w and all v s, l s."""
    vectors, lengths, w, *_ = found
    return vectors, lengths, w + [x * y for v, y in zip(vectors, s) for x in v], [a * b for a, b in zip(lengths, s)]


def _margin(segment, i, pull, error):
    """Of a cable: `pull` is the margin's Bernstein form, whose ends are its values at the ends of the segment."""
    least = -largest([-x for x in pull]) - error
    if not least.is_finite():
        raise Undecided("C8", "a bound that is no number")
    lower = math.nextafter(float(least.lower()), -INFINITE)
    ends = (pull[0], segment.begin), (pull[-1], segment.end)
    upper, time = min((math.nextafter(float((x + error).upper()), INFINITE), time) for x, time in ends)
    return Margin(lower, upper, i + 1, segment.piece, time)
