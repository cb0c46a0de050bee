"""What the gains do to the paper's move: time to the goal, set points and smallest tension over λ = η, for both planners.

With the paper's planner (bounded) higher gains make smaller domains and so more steps; with the exact one they make the robot faster.
"""

from closed_loop import AT_GOAL, ClosedLoop, gain_values, options, parser, run, seconds, write_csv

PLANNERS = {"bounded": 1, "exact": 2}


def case(fmus, planner, gain, longest):
    """One move: its time to the goal (s, None if it was not reached), set points, smallest tension (N)."""
    gains = {"planner": PLANNERS[planner], "lambda": gain, "eta": gain}
    smallest, time = float("inf"), None
    with ClosedLoop(fmus, controller=gains) as loop:
        while time is None and loop.time < longest:
            loop.step()
            smallest = min(smallest, *loop.tensions())
            if loop.status() == AT_GOAL:
                time = loop.time
        return time, loop.set_point_index(), smallest


def draw(path, rows):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for planner, colour in zip(PLANNERS, ["#0072B2", "#D55E00"]):
        mine = [row for row in rows if row[0] == planner]
        gains = [row[1] for row in mine]
        panels[0].plot(gains, [row[2] for row in mine], "o-", color=colour, label=planner)
        panels[1].plot(gains, [row[4] for row in mine], "o-", color=colour, label=planner)
    panels[0].set(ylabel="time to the goal (s)")
    panels[1].set(ylabel="smallest tension on the way (N)")
    for panel in panels:
        panel.set(xlabel="λ = η (1/s)", ylim=(0, None))
        panel.grid(alpha=0.3)
        panel.legend(frameon=False)
    figure.savefig(path, dpi=120)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--gains", type=gain_values, default=[1.5, 2, 3, 4, 5, 6, 8], metavar="N,N,...", help="values of λ = η, 1/s")
    arguments.add_argument("--longest", type=seconds, default=30.0, help="time for one move, s (default: %(default)s)")
    chosen = options(arguments)

    rows = []
    print("planner  λ = η (1/s)  time (s)  set points  smallest tension (N)")
    for planner in PLANNERS:
        for gain in chosen.gains:
            time, set_points, smallest = case(chosen.fmus, planner, gain, chosen.longest)
            rows.append([planner, gain, time, set_points, smallest])
            shown = "-" if time is None else f"{time:.2f}"
            print(f"{planner:<7}  {gain:>11g}  {shown:>8}  {set_points:>10}  {smallest:>20.3f}", flush=True)
    if chosen.csv:
        write_csv(chosen.csv, ["planner", "gain", "time", "setPoints", "smallestTension"], rows)
    if chosen.picture:
        draw(chosen.picture, rows)
    return 0


if __name__ == "__main__":
    run(main)
