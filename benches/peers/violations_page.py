"""docs/violations.md and its figure: of each method's motions how near they come to the limits, as `judge.py` proves it."""

import platform
import subprocess
from datetime import date

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import ipopt
import motion
import moves
import parametrized
import problems
from judge import TOLERANCE
from page import version
from plots import SHADES

WORST = 10  # % of the weight: beyond that the figure tells no more
TITLES = {"level": "Level moves", "space": "Moves in space", "turned": "Turned moves"}


class Rows:
    """The lines of one method; margins in N, negative beyond a limit."""

    def __init__(self, lines, weight):
        self.lines, self.slight, self.weight = lines, TOLERANCE * weight, weight
        self.found = [line for line in lines if line["found"]]
        self.lower, self.upper = (np.array([min(line["below"][k], line["above"][k]) for line in self.found]) for k in (0, 1))
        self.own = np.array([min(line["own"]) for line in self.found if "own" in line])
        self.breaks, self.slightly, self.within = self.upper < -self.slight, (self.upper < 0) & (self.upper >= -self.slight), self.lower >= 0

    def cells(self):
        """Found, within, by rounding, breaks, undecided; breach: median, greatest; at its own points, and breaking only between; least margin."""
        number, bounded = len(self.found), np.isfinite(self.lower)
        broken, endless = -self.upper[self.breaks & bounded], (self.breaks & ~bounded).sum()
        counts = [self.within.sum(), self.slightly.sum(), self.breaks.sum(), number - self.within.sum() - self.slightly.sum() - self.breaks.sum()]
        breaches = [self._breach(broken, np.median), f"no bound in {endless}" if endless else self._breach(broken, np.max)]
        kept = self.own >= -self.slight
        at_own = [f"{kept.sum()}", f"{(kept & self.breaks).sum()}"] if len(self.own) else ["all times"] + ["-"]
        return [f"{number} of {len(self.lines)}", *map(str, counts), *breaches, *at_own, f"{100 * np.median(self.upper[bounded]) / self.weight:.2g} %" if bounded.any() else "-"]

    def _breach(self, broken, of):
        return f"{of(broken):.2g} N, {100 * of(broken) / self.weight:.2g} %" if len(broken) else "-"


def by_method(lines, weight):
    present = {line["method"] for line in lines}
    return {name: Rows([line for line in lines if line["method"] == name], weight) for name in problems.METHODS if name in present}


def draw(lines, weight, path):
    """Share of the motions whose least margin is at most so large."""
    matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "violations", "font.size": 9})
    figure = Figure((9, 3.6), layout="constrained")
    axes = figure.subplots()
    styles = [(shade, style) for style in ("-", "--") for shade in SHADES]
    for (shade, style), (name, rows) in zip(styles, by_method(lines, weight).items()):
        margins = np.clip(100 * np.sort(rows.upper) / weight, -WORST, None)
        few = np.unique(np.linspace(0, len(margins) - 1, min(len(margins), 200)).astype(int)) if len(margins) else []
        axes.plot(margins[few], (np.array(few) + 1) / max(len(margins), 1), style, color=shade, label=name)
    axes.axvline(0, color="#888888", linewidth=0.8, zorder=0)
    axes.set_xscale("symlog", linthresh=0.01)
    axes.set(xlabel=f"least margin to a limit, % of the weight; negative: a limit is broken; -{WORST}: by so much or more", ylabel="share of the motions", ylim=(0, 1.02))
    axes.grid(color="#e5e5e5")
    figure.legend(loc="outside right center", frameon=False)
    figure.savefig(path, metadata={"Date": None, "Creator": None})


def text(lines, rig):
    kinds = [(title, [line for line in lines if line["kind"] == kind]) for kind, title in TITLES.items()]
    tables = [("All moves", lines), *kinds]
    return _head(lines, rig) + "".join(_table(title, some, rig.weight) for title, some in tables if some)


def _table(title, lines, weight):
    rows = "".join(f"| {' | '.join([name, *rows.cells()])} |\n" for name, rows in by_method(lines, weight).items())
    count = len({(line["kind"], line["move"]) for line in lines})
    return f"""
## {title}: {count}

| | found | within limits | beyond by rounding | breaks a limit | undecided | breach, median | greatest | keeps its own points | and breaks one between | least margin, median, of the weight |
|---|---|---|---|---|---|---|---|---|---|---|
{rows}"""


def _head(lines, rig):
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=problems.ROOT, capture_output=True, text=True).stdout.strip()
    return f"""# Who breaks a limit between its points

Written by `benches/peers/violations.py`, whose first lines say how to run it ({date.today():%d %B %Y}, on top of commit {commit}, {platform.machine()}).

Planners look at the tensions at points; between them nobody looks. Here each motion is taken as an exact function of time, and the least distance of any cable's tension from its limits over *all* time is enclosed between two numbers: branch and bound over time,
Taylor models in ball arithmetic (Arb), equations and arithmetic those of the [checker of proof files](../checker/README.md), which shares no code with the program and takes nothing from a sample. The two numbers are at most 10⁻⁶ of the weight apart, {1e6 * TOLERANCE * rig.weight:.0f} µN: a hundredth of
what [benchmarks.md](benchmarks.md) forgives, and more than the rounding of any method's own arithmetic.

{len({(line["kind"], line["move"]) for line in lines})} random straight moves from rest to rest of Table I's robot, seed {moves.SEED} (`moves.of_all_kinds`): level ones, in space, and turned as well as in space, a third each. The limits are {rig.least} and {rig.greatest:.0f} N for *all* methods, ours too,
which keep some distance from them by themselves (0.17 % of the weight). Six cables only: their tensions are the only ones there are. Of eight cables a motion's margin is a linear programme at every instant, which is not enclosed here.

- *Breaks a limit*: proved, some cable is beyond a limit at some time by more than 10⁻⁶ of the weight. *Beyond by rounding*: proved, but by no more than that, which is what doubles and solvers' tolerances leave and no fault of a method. *Within limits*: proved for all time. *Undecided*: none of these.
  A *breach* is how far a tension is beyond its limit at most, proved to be at least so much, of the motions that break one, and its share of the weight. *No bound*: of so many motions the largest breach is not enclosed: the closer one looks the greater it is, as at a pose where the cables' forces are dependent, which tensions
  without bounds belong to; the median breach and margin are of the others.
- *Keeps its own points*: motions within the limits, but for 10⁻⁶ of the weight, at the points at which the method itself looked; *and breaks one between*: how many of those break a limit elsewhere.

## What was taken as each method's motion, and what it promises

- *toppra* {version("toppra")}: the straight way and its piecewise constant s'', as `ParametrizeConstAccel` evaluates it, {parametrized.POINTS} points. *Collocation* promises the limits at the beginning of each interval with its s''; its own documentation says "smaller problem size, but lower accuracy".
  *Interpolation* promises them at both ends of each ("higher accuracy"; "should use Interpolation if possible"). Neither promises anything between; the other parametrisers of toppra, splines, are not looked at. It gets tensions exact to rounding as limits.
- *ruckig* {version("ruckig")}: pieces of constant acceleration, out of its profiles. It promises limits of the axes' acceleration, which it keeps; that the tensions follow is what we made of it: the greatest acceleration, the same for all axes, with which no tension is beyond a limit at {motion.SAMPLES[rig.cables]} instants, by {parametrized.HALVINGS} halvings.
- *CasADi* {version("casadi")} with ipopt, default tolerances: *on the way*, {ipopt.CELLS[6]} cells of the straight way with constant s''; *free* of it, {ipopt.INTERVALS} intervals of constant acceleration in x, y, z, of turned moves in all six coordinates. It promises the limits at both ends of each piece, to ipopt's tolerance; the pieces are put together from places, rates and durations that it found.
- *Bounded (the paper's chain)* and *Exact*: what `plan --proof` proves, the law's steps from rest at one set point to the next, for all time. In closed loop a controller sets the next point on the way already; those steps are proved by it, each before it is made, and not judged here.
- *MinimumTime*: the motion that `plan --proof` writes. It promises the limits for all time, with its own proof, which is not used here.

![Least margin to a limit of each method's motions.](figures/violations.svg)
"""
