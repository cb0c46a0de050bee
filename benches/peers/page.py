"""docs/benchmarks.md: what was aimed at and what came out, and a table for each set of moves."""

import platform
import subprocess
from datetime import date

import numpy as np

import interrupted
import ipopt
import motion
import moves
import mpc
import parametrized
from ours import ROOT, SPARE

OURS = "MinimumTime"
LOOPS = (OURS + ", closed loop", "Exact, closed loop", "Bounded (the paper's chain), closed loop")
TOPPRA = "toppra, Interpolation"
SECOND_ORDER = TOPPRA + ", a point at a time"
LINES = ("The paper's move", "Level moves", "Moves in space")


def text(results, again, paper, cogiro):
    return "".join([_head(paper, cogiro), _aims(results, again), *map(_table, results.values()), _end(again)])


def _head(paper, cogiro):
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    return f"""# Benchmarks

Written by `benches/peers/compare.py`, whose first lines say how to run it ({date.today():%d %B %Y}, on top of commit {commit}, a busy machine with {platform.machine()}). Planning is CPU time of one thread, in Python for all: of what differs less than threefold say nothing.

Straight moves from rest to rest, seed {moves.SEED}; each method is to keep all tensions between {paper.least} and {paper.greatest:.0f} N (Table I's robot) or {cogiro.least:.0f} and {cogiro.greatest:.0f} N (CoGiRo). Our planners leave {100 * SPARE:.2f} % of the weight
besides and are given limits that are so much wider. Tensions are looked at by inverse dynamics in numpy, which shares no line with the program, between the points that a method looks at itself: at {motion.SAMPLES[6]} instants of a
planned motion, ours at every 0.1 ms, closed loops at every step (CoGiRo: {motion.SAMPLES[8]} instants, and of the ways to share the load the evenest). "Within limits" allows {100 * motion.KEPT:.2f} % of the weight.

- *{OURS}*: the plan, read out of the packed FMU; *closed loop*: that planner, `Exact` and `Bounded` through the packed FMUs at 1 kHz. Planning is the step that takes up the goal, less the one before.
- *toppra* {version("toppra")}, {parametrized.POINTS} points, both schemes, its model the inverse dynamics in numpy, for all points at once or, as its class `SecondOrderConstraint` has it, *a point at a time*; with eight cables it gets the planes of the wrenches that they can exert. *ruckig* {version("ruckig")} knows limits of the axes only: it gets the greatest acceleration, the same
  for all axes, with which the tensions are kept, found by {parametrized.HALVINGS} halvings; planning is of one call.
- *CasADi* {version("casadi")} with ipopt: the optimum *on the way* (the straight one; {ipopt.CELLS[6]} cells, {ipopt.CELLS[8]} with eight cables, limits kept at both ends of each) and *free* of it: planar (x and y at the height and orientation of the start), spatial (x, y, z), or all six
  coordinates; {ipopt.INTERVALS} intervals of constant acceleration, limits kept at both ends of each. Planning is the solver's call.
- *OSQP* {version("osqp")}, MPC towards the goal in all six coordinates: steps of {1e3 * mpc.STEP:.0f} ms, a horizon of {mpc.HORIZON} ({mpc.STEP * mpc.HORIZON:.1f} s), linearised about what was predicted the step before, limits of the tensions in each step, quadratic cost of pose and rates; closed loop on a rigid body in
  numpy. Planning is the median of one step. It may leave the straight way, tilts and rises.
- *The way's optimum*: the least time on the straight way, by forward and backward passes on a fine grid (1,000 cells; CoGiRo 500), whose error is below 0.001 %.

"""


def version(package):
    pinned = (ROOT / "benches/peers/requirements.txt").read_text().split()
    return next(line.split("==")[1] for line in pinned if line.startswith(package + "=="))


def _aims(results, again):
    rows = [
        (name, aim, shown(value), "yes" if is_met(value) else "**no**")
        for name, aim, value, shown, is_met in _measured(results, again)
        if value is not None
    ]
    lines = "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return f"""## What is aimed at

| | aim | measured | met |
|---|---|---|---|
{lines}
![Time to the goal and planning of each method beside ours.](figures/benchmarks.svg)

![The paper's move: how far from the goal over time.](figures/benchmarks-move.svg)
"""


def _measured(results, again):
    """Name, aim, value, how it is shown, whether it is met."""
    share, times, microseconds = "{:.3f} %".format, "{:,.1f}".format, "{:.0f} µs".format
    lines = [excess for title in LINES if title in results for excess in _excesses(results[title])]
    yield "lines: longest above the way's optimum", "0.1 %", max(lines), share, lambda x: x <= 0.1
    for method in (SECOND_ORDER, TOPPRA):
        quicker = [peer.planning / own.planning for title in LINES for peer, own in _pairs(results, title, method)]
        yield f"lines: planning, time of {method}, over ours, median", "1000", np.median(quicker), times, lambda x: x >= 1000
    for title in ("Turned moves", "CoGiRo, eight cables"):
        if title in results:
            yield f"{title}: longest above the way's optimum", "2 %", max(_excesses(results[title])), share, lambda x: x <= 2
            costly = 1e6 * max(row.planning for row in results[title].found[OURS] if row)
            yield f"{title}: planning, longest", "5000 µs", costly, microseconds, lambda x: x <= 5000
    loops = [results["The paper's move"].found[name][0] for name in LOOPS]
    for name, loop, aim in zip(("Exact", "the paper's chain"), loops[1:], (4, 12)):
        for until, ratio in (("2 %", loop.within / loops[0].within), ("it rests there", loop.times[-1] / loops[0].times[-1])):
            yield f"the paper's move in closed loop until {until}: time of {name} over ours", str(aim), ratio, times, lambda x, aim=aim: x >= aim
    above = 100 * (np.median(again[:, 0]) - 1)
    yield f"new goal on the way: above the free planar optimum, median", "4 %", above, share, lambda x: x <= 4
    yield f"new goal on the way ({len(again)} moves): planning, median", "200 µs", 1e6 * np.median(again[:, 1]), microseconds, lambda x: x <= 200


def _excesses(compared):
    return [100 * (row.duration / bound - 1) for row, bound in zip(compared.found[OURS], compared.least) if row]


def _pairs(results, title, method):
    if title not in results:
        return []
    found = results[title].found
    return [(row, own) for row, own in zip(found[method], found[OURS]) if row and own]


def _table(compared):
    found, least, drawn = compared.found, compared.least, len(compared.pairs)
    heading = compared.title if drawn == 1 else f"{compared.title}: {len(least)} of {drawn}"
    own = [row for row in found[OURS] if row]
    rows = "".join(_row(method, list(zip(rows, found[OURS], least))) for method, rows in found.items())
    return f"""
## {heading}

| | time to goal, ours = 1 | motion, way's optimum = 1 | planning, ours = 1 | smallest tension (N) | greatest (N) | found | within limits |
|---|---|---|---|---|---|---|---|
{rows}
Time to goal: until the platform stays within {100 * motion.NEAR:.0f} % of the way (an angle of 1 rad counts as the platform's radius); medians, of the motion median and longest. Ours: {np.median([row.within for row in own]):.4f} s, whole motion {np.median([row.duration for row in own]):.4f} s,
planned in {1e6 * np.median([row.planning for row in own]):.0f} µs.
"""


def _row(method, rows):
    found = [(row, own, bound) for row, own, bound in rows if row and own]
    if not found:
        return f"| {method} | - | - | - | - | - | 0 of {len(rows)} | - |\n"
    time = np.median([row.within / own.within for row, own, _ in found])
    planning = np.median([row.planning / own.planning for row, own, _ in found])
    whole = [row.duration / bound for row, _, bound in found if row.duration is not None]
    motions = f"{np.median(whole):.4f}, {max(whole):.4f}" if whole else "-"
    least, greatest = min(row.smallest for row, *_ in found), max(row.greatest for row, *_ in found)
    kept = sum(row.keeps for row, *_ in found)
    return (
        f"| {method} | {time:.3f} | {motions} | {_ratio(planning)} | {least:.3f} | {greatest:.2f} "
        f"| {sum(row is not None for row, *_ in rows)} of {len(rows)} | {kept} of {len(found)} |\n"
    )


def _ratio(value):
    return f"{value:,.0f}" if value >= 10 else f"{value:.2g}"


def _end(again):
    return f"""
## A new goal on the way

{len(again)} of {interrupted.MOVES} level moves between random places, each given a new goal after a random share (0.1 to 0.9) of it, through the packed FMU, which takes it up at once (`plannerPeriod` of {1e3 * interrupted.STEP:.1f} ms), beside the free planar optimum from the same state by CasADi and ipopt
({interrupted.INTERVALS} intervals, which cost it some 0.15 %). Ours takes {np.median(again[:, 0]):.3f} of the optimum's time in the median, from {again[:, 0].min():.3f} to {again[:, 0].max():.3f}, and is planned in {1e6 * np.median(again[:, 1]):.0f} µs; ipopt takes {np.median(again[:, 2] / again[:, 1]):.0f} times as long.
"""
