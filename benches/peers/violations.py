"""Who breaks a limit of the tensions between the points that it looks at, and by how much, proved in ball arithmetic: writes docs/violations.md and its figure.

    cargo build --bin cable-robot
    python3 -m venv target/peers && target/peers/bin/pip install --requirement benches/peers/requirements.txt
    target/peers/bin/python benches/peers/violations.py --moves 1000

Each move's results are a line each in target/violations.jsonl: a run that was stopped (Ctrl-C) has written the page of what it has, and goes on where it stopped. All cores, some 5 s of one for a move: the free optima come last, which take most of it.
"""

import argparse
import json
import os
import signal
import sys
import time
from collections import Counter
from multiprocessing import Pool

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[name] = "1"

import moves  # noqa: E402
import problems  # noqa: E402
import violations_page  # noqa: E402
from judge import Judge  # noqa: E402
from rig import Rig  # noqa: E402

RESULTS = problems.ROOT / "target/violations.jsonl"
LAST = ["CasADi + ipopt, free"]  # costs more than all others together
PASSES = [[method for method in problems.METHODS if method not in LAST], LAST]
RIG = Rig(problems.ROOT / "rigs/paper.toml", 0.5, 40.0)


def judged(method, kind, number, start, goal):
    """A line of the results: of each side [lower, upper, cable, problem, piece, time] of the least margin; `own` the margins at the method's own points (upper bounds)."""
    line = {"kind": kind, "move": number, "method": method}
    begun = time.process_time()
    asked = problems.METHODS[method](RIG, start, goal, kind)
    if asked is None:
        return line | {"found": False}
    judges = [Judge(problem) for problem in asked.problems]
    line |= {"found": True, "duration": asked.duration}
    for side, name in enumerate(("below", "above")):
        line[name] = least([judge.least(side) for judge in judges])
    if asked.own:
        worst = problems.worst(RIG, asked.problems[0], asked.own)
        line["own"] = [judges[0].at(*point)[side].upper for side, point in enumerate(worst)]
    return line | {"seconds": round(time.process_time() - begun, 3)}


def least(margins):
    k, where = min(enumerate(margins), key=lambda entry: entry[1].upper)
    return [min(margin.lower for margin in margins), where.upper, where.cable, k + 1, where.piece + 1, where.time]


def lines_of(task):
    """Lines of the methods of a move, and why others gave none."""
    (kind, number, start, goal), methods = task
    found, faults = [], {}
    for method in methods:
        try:
            found.append(judged(method, kind, number, start, goal))
        except Exception as fault:  # of a peer or of our program: the move is left open for it
            faults[method] = f"{type(fault).__name__}: {fault}".strip()[:200]
    return found, faults


def run(count):
    """Lines of the first moves of the results, all that are lacking made."""
    drawn = moves.of_all_kinds(count)
    asked = {(kind, number) for kind, number, *_ in drawn}
    RESULTS.parent.mkdir(exist_ok=True)
    known = [json.loads(line) for line in RESULTS.read_text().splitlines()] if RESULTS.exists() else []
    lines = [line for line in known if (line["kind"], line["move"]) in asked]
    have = {(line["kind"], line["move"], line["method"]) for line in lines}
    open_for = lambda move, methods: [method for method in methods if (*move[:2], method) not in have]
    tasks = [(move, open_for(move, methods)) for methods in PASSES for move in drawn]
    tasks = [task for task in tasks if task[1]]
    faults, last = Counter(), {}
    with Pool(initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)) as pool, RESULTS.open("a") as file:
        try:
            for k, (found, lacking) in enumerate(pool.imap_unordered(lines_of, tasks), 1):
                for line in found:
                    print(json.dumps(line), file=file, flush=True)
                lines += found
                faults.update(lacking)
                last |= lacking
                print(f"\r{k} of {len(tasks)} ", end="", file=sys.stderr, flush=True)
        except KeyboardInterrupt:
            print("\nstopped: the page is of what was judged", end="", file=sys.stderr)
    print(file=sys.stderr)
    for method, number in faults.items():
        print(f"{method}: left open for {number} moves, of the last: {last[method]}", file=sys.stderr)
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moves", type=int, default=1000, help="of all kinds in sum")
    lines = run(parser.parse_args().moves)
    violations_page.draw(lines, RIG.weight, problems.ROOT / "docs/figures/violations.svg")
    (problems.ROOT / "docs/violations.md").write_text(violations_page.text(lines, RIG))
    print("docs/violations.md")


if __name__ == "__main__":
    main()
