"""Tests of motions in pieces (motions.py), made here in floats with formulas other than the checker's: s by exponentials, spans by the maker of test_check_proof.py."""
import cmath
import math

import pytest
from flint import arb, ctx

import motions

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
