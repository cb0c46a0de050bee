"""MinimumTime beside what people would use instead, on the same moves with the same limits, in one run: writes docs/benchmarks.md and its figures.

    cargo build --bin cable-robot && cargo fmu build
    python3 -m venv target/peers && target/peers/bin/pip install --requirement benches/peers/requirements.txt
    target/peers/bin/python benches/peers/compare.py

It takes half an hour of one core. Times of planning are CPU time of one thread.
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
        "toppra, Collocation": peer(parametrized.collocation),
        "ruckig": peer(parametrized.by_ruckig),
        "CasADi + ipopt, on the way": peer(ipopt.on_the_way),
        **{f"CasADi + ipopt, free: {name}": peer(plan) for name, plan in free.items()},
        "OSQP, MPC, closed loop": peer(mpc.closed_loop),
    }


def compared(own, title, pairs):
    """What each method found for the moves, and the least time on each way."""
    plans = methods(own, title)
    found, least = {name: [] for name in plans}, []
    for k, (start, goal) in enumerate(pairs):
        for name, plan in plans.items():
            print(f"\r{title}: {k + 1} of {len(pairs)}, {name}".ljust(100), end="", file=sys.stderr, flush=True)
            found[name].append(plan(start, goal))
        least.append(optimum.least_time(own.rig, start, goal, CELLS[own.rig.cables]))
    print(file=sys.stderr)
    return found, least


def main():
    with tempfile.TemporaryDirectory() as folder:
        paper, cogiro = Rig(ROOT / "rigs/paper.toml", 0.5, 40.0), Rig(ROOT / "rigs/public/cogiro.toml", 100.0, 5000.0)
        results = {}
        for rig, sets in ((paper, moves.of_the_papers_rig()), (cogiro, moves.of_cogiro(cogiro))):
            own = Ours(rig, Path(folder) / rig.path.stem)
            results |= {title: compared(own, title, pairs) for title, pairs in sets.items()}
        again = interrupted.compared(Ours(paper, Path(folder) / "again"))
    plots.draw(results, ROOT / "docs/figures")
    (ROOT / "docs/benchmarks.md").write_text(page.text(results, again, paper, cogiro))
    print("docs/benchmarks.md")


if __name__ == "__main__":
    main()
