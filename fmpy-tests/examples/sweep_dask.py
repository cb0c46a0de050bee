"""A sweep over both gains, λ and η, on a dask cluster: on this machine, or on many with --scheduler.

The two FMUs and closed_loop.py are sent to the workers, so these need no files of this project, only fmpy and its like; the FMUs run on
Linux x86-64. Prints progress, and of the pairs of gains the fastest with its smallest tension.
"""

import logging
import signal
import sys
import tempfile
from pathlib import Path

from closed_loop import gain_values, number, options, parser, run, seconds, write_csv

NAMES = ["CableRobotController.fmu", "CableRobotPlant.fmu"]


def unpacked(fmus):
    """The folder with the FMUs on a worker, written once there."""
    from dask.distributed import get_worker

    worker = get_worker()
    if not hasattr(worker, "fmus"):
        worker.fmus = tempfile.TemporaryDirectory()
        for name, content in fmus.items():
            (Path(worker.fmus.name) / name).write_bytes(content)
    return worker.fmus.name


def case(fmus, lam, eta, step, longest):
    """One move with the exact planner: λ, η, time to the goal (s, None if it was not reached), smallest tension (N)."""
    from closed_loop import AT_GOAL, ClosedLoop

    gains = {"planner": 2, "lambda": lam, "eta": eta}
    smallest = float("inf")
    with ClosedLoop(unpacked(fmus), step=step, controller=gains) as loop:
        while loop.time < longest:
            loop.step()
            smallest = min(smallest, *loop.tensions())
            if loop.status() == AT_GOAL:
                return lam, eta, loop.time, smallest
    return lam, eta, None, smallest


def sweep(client, chosen):
    """All cases on the cluster's workers, in the order of the grid."""
    from dask.distributed import as_completed

    client.upload_file(str(Path(__file__).with_name("closed_loop.py")))
    content = {name: (chosen.fmus / name).read_bytes() for name in NAMES}
    fmus = client.scatter(content, broadcast=True)
    grid = [(lam, eta) for lam in chosen.gains for eta in chosen.gains]
    futures = [client.submit(case, fmus, *pair, chosen.step, chosen.longest, pure=False) for pair in grid]
    for done, _ in enumerate(as_completed(futures), 1):
        print(f"\r{done} of {len(futures)} cases", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return client.gather(futures)


def workers(text):
    """Reads how many."""
    return int(number(text, lambda found: found >= 1 and found == int(found), "a number of workers, 1 or more"))


def local_cluster(count):
    """Workers on this machine, which leave Ctrl-C to this program: it ends them, and what they then lack they need not say. While they start nobody hears it."""
    from dask.distributed import LocalCluster

    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        # One thread a worker: Python lets only one of them work.
        return LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None, silence_logs=logging.CRITICAL)
    finally:
        signal.signal(signal.SIGINT, handler)


def draw(path, rows, gains):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    times = np.array([np.nan if row[2] is None else row[2] for row in rows]).reshape(len(gains), len(gains))
    figure, panel = plt.subplots(figsize=(6.5, 5.2), layout="constrained")
    image = panel.imshow(times, origin="lower", cmap="cividis")
    for row, line in enumerate(times):
        for column, time in enumerate(line):
            if not np.isnan(time):
                colour = "black" if image.norm(time) > 0.5 else "white"
                panel.text(column, row, f"{time:.2f}", ha="center", va="center", color=colour)
    ticks = range(len(gains))
    names = [f"{gain:g}" for gain in gains]
    panel.set(xlabel="η (1/s)", ylabel="λ (1/s)", xticks=ticks, yticks=ticks, xticklabels=names, yticklabels=names)
    figure.colorbar(image, label="time to the goal (s)")
    figure.savefig(path, dpi=120)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--scheduler", metavar="ADDRESS", help="a running dask scheduler, such as tcp://HOST:8786")
    arguments.add_argument("--workers", type=workers, help="workers on this machine (default: one a core)")
    arguments.add_argument("--gains", type=gain_values, default=[2, 3, 4, 6, 8], metavar="N,N,...", help="values of λ and of η, 1/s")
    arguments.add_argument("--step", type=seconds, default=1e-3, help="communication step, s (default: %(default)s)")
    arguments.add_argument("--longest", type=seconds, default=15.0, help="time for one move, s (default: %(default)s)")
    chosen = options(arguments)
    try:
        from dask.distributed import Client
    except ImportError as error:
        arguments.error(f"{error}: pip install -r fmpy-tests/examples/requirements-dask.txt")

    if chosen.scheduler:
        try:
            client = Client(chosen.scheduler, timeout=10)
        except OSError as error:
            arguments.error(f"no scheduler at {chosen.scheduler}: {error}")
        with client:
            rows = sweep(client, chosen)
    else:
        with local_cluster(chosen.workers) as cluster, Client(cluster) as client:
            rows = sweep(client, chosen)

    arrived = [row for row in rows if row[2] is not None]
    print(f"{len(arrived)} of {len(rows)} cases arrived within {chosen.longest:g} s")
    if arrived:
        lam, eta, time, smallest = min(arrived, key=lambda row: row[2])
        print(f"fastest: λ = {lam:g}, η = {eta:g}: {time:.2f} s, smallest tension {smallest:.3f} N")
    if chosen.csv:
        write_csv(chosen.csv, ["lambda", "eta", "time", "smallestTension"], rows)
    if chosen.picture:
        draw(chosen.picture, rows, chosen.gains)
    return 0


if __name__ == "__main__":
    run(main)
