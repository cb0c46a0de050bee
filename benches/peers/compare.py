"""MinimumTime beside what people would use instead, on the same moves with the same limits, in one run: writes docs/benchmarks.md and its figures.

    cargo build --bin cable-robot && cargo fmu build
    python3 -m venv target/peers && target/peers/bin/pip install --requirement benches/peers/requirements.txt
    target/peers/bin/python benches/peers/compare.py

It takes half an hour of one core. Interrupted (Ctrl-C) it writes the page from the moves that were compared, one of each set in turn. Times of planning are CPU time of one thread.
"""

import os
import sys
import tempfile
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[name] = "1"

import interrupted  # noqa: E402
import ipopt  # noqa: E402
import moves  # noqa: E402
import mpc  # noqa: E402
import optimum  # noqa: E402
import page  # noqa: E402
import parametrized  # noqa: E402
import plots  # noqa: E402
from ours import ROOT, Ours  # noqa: E402
from rig import Rig  # noqa: E402

CELLS = {6: 1000, 8: 500}  # of the fine grid, by the number of cables


def methods(own, title):
    """By name, start and goal -> `motion.Found` or None; ours first."""
    peer = lambda plan: lambda start, goal: plan(own.rig, start, goal)
    loop = lambda planner: lambda start, goal: own.closed_loop(planner, start, goal)
    free = {"planar": ipopt.planar, "spatial": ipopt.spatial} if title in ("The paper's move", "Level moves") else {}
    free |= {"spatial": ipopt.spatial} if title == "Moves in space" else {}
    free = free or {"all six coordinates": ipopt.whole}
    return {
        page.OURS: own.plan,
        "MinimumTime, closed loop": loop("MinimumTime"),
        "Exact, closed loop": loop("Exact"),
        "Bounded (the paper's chain), closed loop": loop("Bounded"),
        page.TOPPRA: peer(parametrized.interpolation),
        page.SECOND_ORDER: peer(parametrized.second_order),
        "toppra, Collocation": peer(parametrized.collocation),
        "ruckig": peer(parametrized.by_ruckig),
        "CasADi + ipopt, on the way": peer(ipopt.on_the_way),
        **{f"CasADi + ipopt, free: {name}": peer(plan) for name, plan in free.items()},
        "OSQP, MPC, closed loop": peer(mpc.closed_loop),
    }


class Moves:
    """A set of moves, and what each method found for the first of them."""

    def __init__(self, own, title, pairs):
        self.rig, self.title, self.pairs, self.methods = own.rig, title, pairs, methods(own, title)
        self.found, self.least = {name: [] for name in self.methods}, []

    def compare_next(self):
        start, goal = self.pairs[len(self.least)]
        rows = {}
        for name, plan in self.methods.items():
            step = f"{self.title}: {len(self.least) + 1} of {len(self.pairs)}, {name}"
            print("\r" + step.ljust(90), end="", file=sys.stderr, flush=True)
            rows[name] = plan(start, goal)
        least = optimum.least_time(self.rig, start, goal, CELLS[self.rig.cables])
        for name, row in rows.items():
            self.found[name].append(row)
        self.least.append(least)


def compare(sets):
    """One move of each set in turn, so that a run that is interrupted has some of each."""
    try:
        while left := [moves for moves in sets if len(moves.least) < len(moves.pairs)]:
            for moves in left:
                moves.compare_next()
    except KeyboardInterrupt:
        print("\ninterrupted: the page is of what was compared", end="", file=sys.stderr)
    print(file=sys.stderr)


def main():
    with tempfile.TemporaryDirectory() as folder:
        paper, cogiro = Rig(ROOT / "rigs/paper.toml", 0.5, 40.0), Rig(ROOT / "rigs/public/cogiro.toml", 100.0, 5000.0)
        owns = {rig: Ours(rig, Path(folder) / rig.path.stem) for rig in (paper, cogiro)}
        again = interrupted.compared(owns[paper])
        drawn = ((paper, moves.of_the_papers_rig()), (cogiro, moves.of_cogiro(cogiro)))
        sets = [Moves(owns[rig], title, pairs) for rig, of_rig in drawn for title, pairs in of_rig.items()]
        compare(sets)
    results = {moves.title: moves for moves in sets if moves.least}
    plots.draw(results, ROOT / "docs/figures")
    (ROOT / "docs/benchmarks.md").write_text(page.text(results, again, paper, cogiro))
    print("docs/benchmarks.md")


if __name__ == "__main__":
    main()
