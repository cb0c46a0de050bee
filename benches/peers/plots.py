"""The figures of docs/benchmarks.md, on white so that they can be read on any ground."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import page

MARKS = "os^Dv"
SHADES = ["#000000", "#0072b2", "#009e73", "#e69f00", "#cc79a7"]


def draw(results, folder):
    matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "benchmarks", "font.size": 9})
    for name, figure in (("benchmarks", _ratios(results)), ("benchmarks-move", _move(results["The paper's move"].found))):
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})


def _ratios(results):
    """Medians of time to the goal and of planning over ours, a row a method, a mark a set of moves; hollow where a motion left the limits."""
    names = list(dict.fromkeys(name for compared in results.values() for name in compared.found))
    figure = Figure((9, 4.6), layout="constrained")
    times, plannings = figure.subplots(1, 2, sharey=True)
    for shade, mark, (title, compared) in zip(SHADES, MARKS, results.items()):
        found = compared.found
        for name, rows in found.items():
            both = [(row, own) for row, own in zip(rows, found[page.OURS]) if row and own]
            if not both:
                continue
            face = shade if all(row.keeps for row, _ in both) else "none"
            look = {"marker": mark, "color": shade, "markerfacecolor": face, "linestyle": "none"}
            for axes, quantity in ((times, "within"), (plannings, "planning")):
                ratio = np.median([getattr(row, quantity) / getattr(own, quantity) for row, own in both])
                axes.plot(ratio, names.index(name), **look)
        times.plot([], [], marker=mark, color=shade, linestyle="none", label=title)
    for axes, title in ((times, "time to goal, ours = 1"), (plannings, "planning (CPU time), ours = 1")):
        axes.set(xscale="log", title=title)
        axes.axvline(1, color="#888888", linewidth=0.8, zorder=0)
        axes.grid(axis="both", color="#e5e5e5")
    times.set_yticks(range(len(names)), names)
    times.set_xticks([0.8, 1, 2, 4, 8, 14], ["0.8", "1", "2", "4", "8", "14"])
    times.minorticks_off()
    times.invert_yaxis()
    figure.legend(loc="outside lower center", ncols=5, frameon=False, title="hollow: a tension left its limits", title_fontsize=9)
    return figure


def _move(found):
    """Distance from the goal over time."""
    figure = Figure((9, 3.6), layout="constrained")
    axes = figure.subplots()
    shades = matplotlib.colormaps["tab20"].colors
    for k, (name, (row,)) in enumerate(found.items()):
        if row:
            few = slice(None, None, len(row.times) // 300 + 1)
            style = "-" if row.keeps else "--"
            axes.plot(row.times[few], row.away[few], style, color=shades[k], linewidth=2.5 if k == 0 else 1.3, label=name)
    axes.axhline(0.02, color="#888888", linewidth=0.8)
    axes.set(xscale="log", xlim=(0.1, 10), ylim=(0, 1.05), xlabel="time (s)", ylabel="distance from the goal, share of the way")
    axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10], ["0.1", "0.2", "0.5", "1", "2", "5", "10"])
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, loc="upper right", fontsize=8)
    return figure
