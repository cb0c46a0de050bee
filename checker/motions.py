"""Motions in pieces of proof files: (C14), (C15), and the coordinates of a piece as series.

Names and units are those of the format and of check_proof.py.
"""
from collections import namedtuple

from flint import arb, arb_series, ctx

from proof_file import demand

Piece = namedtuple("Piece", "offset parts duration")
Part = namedtuple("Part", "way begin s rate acceleration beta jerk")


def prepare(motion):
    """The pieces in balls; `way` a list of coefficients for each coordinate."""
    def part(fields):
        way = [[arb(x) for x in coefficients] for coefficients in zip(*fields["way"])]
        return Part(way, *(arb(fields[name]) for name in Part._fields[1:]))
    return [Piece([arb(x) for x in piece["offset"]], [part(fields) for fields in piece["parts"]],
                  arb(piece["duration"])) for piece in motion["pieces"]]


def progress(part, time, scale):
    """s as a series in x, where t = `time` + `scale` x (s) and `time` is a ball.

    Where beta is not 0, each derivative is beta times the last but one, from s''' on.
    """
    _, _, s, v, a, beta, j = part
    if beta == 0:
        found = [s + time * (v + time * (a / 2 + time * j / 6)), v + time * (a + time * j / 2), a + time * j, j]
    else:
        k = abs(beta).sqrt()
        sine, cosine = (arb.sinh, arb.cosh) if beta > 0 else (arb.sin, arb.cos)
        c, y, half = cosine(k * time), sine(k * time) / k, sine(k * time / 2) / k
        found = [s + 2 * a * half * half + v * y, v * c + a * y, a * c + beta * v * y]
        while len(found) < ctx.cap:
            found.append(beta * found[-2])
    series, factor = [], arb(1)
    for n, derivative in enumerate(found, 1):
        series.append(derivative * factor)
        factor *= scale / n
    return arb_series(series)


def coordinates(piece, time, scale):
    """The coordinates and their first and second derivatives in t (m, rad, s), as series in x (see `progress`)."""
    ctx.cap += 2
    q = [arb_series([x]) for x in piece.offset]
    for part in piece.parts:
        sigma = progress(part, time, scale) - part.begin
        for k, coefficients in enumerate(part.way):
            power = arb_series([0])
            for c in reversed(coefficients):
                power = power * sigma + c
            q[k] += power
    dq = [x.derivative() * (1 / scale) for x in q]
    ddq = [x.derivative() * (1 / scale) for x in dq]
    ctx.cap -= 2
    return q, dq, ddq


def state(piece, time):
    """Coordinates and rates at a time (s) that is a ball."""
    ctx.cap = 1
    q, dq, _ = coordinates(piece, time, arb(1))
    return [x[0] for x in q], [x[0] for x in dq]


def check_cover(pieces, spans):
    """(C14)."""
    before = {"piece": 0}
    for k, (span, after) in enumerate(zip(spans, spans[1:]), 1):
        number, begin, end = span["piece"], span["from"], span["to"]
        expected = before["piece"], before["piece"] + 1
        demand(number in expected and 1 <= number <= len(pieces), "C14",
               f"span {k}: expected piece {max(expected[0], 1)} or {expected[1]} of {len(pieces)}, found {number}")
        if number > before["piece"]:
            demand(begin == 0, "C14", f"span {k}, the first of piece {number}: expected from = 0, found {begin}")
        else:
            demand(begin <= before["to"], "C14", f"span {k}: expected from <= {before['to']}, found {begin}")
        demand(begin < end, "C14", f"span {k}: expected from < to, found {begin}, {end}")
        demand(after.get("piece") == number or end >= pieces[number - 1].duration, "C14",
               f"span {k}, the last of piece {number}: expected to >= {float(pieces[number - 1].duration)}, found {end}")
        before = span
    demand(before["piece"] == len(pieces), "C14", f"the last span: expected spans of {len(pieces)} pieces before it, "
                                                  f"found some of {before['piece']}")


def check_joins(pieces, jump):
    """(C15)."""
    starts, ends = [state(piece, arb(0)) for piece in pieces], [state(piece, piece.duration) for piece in pieces]
    rest = [arb(0)] * 6
    places = zip([q for q, _ in ends], [q for q, _ in starts[1:]])
    rates = zip([rest] + [v for _, v in ends], [v for _, v in starts] + [rest])
    for what, most, first, joins in ("coordinate", jump[0], 1, places), ("rate", jump[1], 0, rates):
        for k, (before, after) in enumerate(joins, first):
            for i, (x, y) in enumerate(zip(before, after), 1):
                demand(abs(x - y) <= most, "C15", f"where piece {k} ends: expected a jump of {what} {i} of at most "
                                                  f"{most:.17g}, found {float(abs(x - y)):.17g}")


def check(motion, proof):
    """(C14) and (C15); the piece that each span is of, the last one at rest."""
    pieces, spans = prepare(motion), proof["spans"]
    check_cover(pieces, spans)
    check_joins(pieces, proof["jump"])
    place, _ = state(pieces[-1], pieces[-1].duration)
    return [pieces[span["piece"] - 1] for span in spans[:-1]] + [Piece(place, [], arb(0))]
