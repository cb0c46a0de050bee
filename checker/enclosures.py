"""Bounds of functions over a piece of time, x in [-1, 1], as Taylor models in balls, and products of three numbers."""
import functools
import math

from flint import arb, arb_mat, ctx, fmpq, fmpq_poly

from proof_file import Refused


class Undecided(Refused):
    """Not proved of a piece of time as a whole; of its parts it may be."""


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def interval(ball):
    return f"[{float(ball.lower()):.17g}, {float(ball.upper()):.17g}]"


def largest(balls):
    return functools.reduce(arb.max, balls)


def models(middle, whole, order):
    """Taylor models of functions of x in [-1, 1], one a row: the coefficients below `order` at x = 0, from
    `middle`, and then that of the remainder (Lagrange's), from `whole`, which holds it at every x."""
    rows = []
    for a, b in zip(middle, whole):
        a, b = a.coeffs(), b.coeffs()
        rows.append(a[:order] + [0] * (order - len(a)) + (b[order:order + 1] or [0]))
    return arb_mat(rows)


def reach(pull, length, spread):
    """Bounds of l s, exact numbers, where `pull` and `length` (their Bernstein coefficients) are of l s and l, and s
    may differ by `spread`."""
    return (-largest([spread * b - a for a, b in zip(pull, length)]).upper(),
            largest([spread * b + a for a, b in zip(pull, length)]).upper())


@functools.cache
def bernstein(order):
    """Matrix from coefficients of a polynomial on [-1, 1] to those of Bernstein's form, which enclose it."""
    line = fmpq_poly([-1, 2])
    return arb_mat([[arb(sum(((line ** k)[i] * fmpq(math.comb(j, i), math.comb(order, i)) for i in range(j + 1)),
                             fmpq(0))) for j in range(order + 1)] for k in range(order + 1)])


def extents(middle, whole):
    """Balls whose least and greatest enclose each of the functions, one a row."""
    order = ctx.cap - 1
    return (models(middle, whole, order) * bernstein(order)).tolist()
