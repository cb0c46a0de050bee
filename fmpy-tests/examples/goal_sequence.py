"""A sequence of goals, each given when the one before is reached: a tour of the workspace at two heights.

Prints when each goal was reached, over how many set points, and the smallest tension on the way.
"""

from closed_loop import AT_GOAL, GOAL_UNREACHABLE, STATUS, ClosedLoop, options, parser, position, run, seconds, write_csv

TOUR = [[0.15, 0.15, 1.0], [-0.15, 0.15, 1.0], [-0.1, -0.1, 0.8], [0.15, -0.1, 0.8], [0.0, 0.0, 1.0]]
EXACT = 2  # the planner that also changes the height


def move(loop, goal, longest):
    """Moves to a goal; the way as rows of time, x, y, z and the smallest tension, and the last status."""
    loop.move_to(goal)
    rows, end, given = [], loop.time + longest, loop.time
    while loop.time < end:
        loop.step()
        rows.append([loop.time, *loop.position(), min(loop.tensions())])
        # The goal is taken up at the planner's next tick, 0.05 s later at the latest; until then the status is that of the last.
        if loop.time > given + 0.1 and loop.status() in (AT_GOAL, GOAL_UNREACHABLE):
            break
    return rows, loop.status()


def draw(path, rows, goals):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    left.plot([row[1] for row in rows], [row[2] for row in rows], color="#0072B2")
    left.plot([goal[0] for goal in goals], [goal[1] for goal in goals], "o", color="#D55E00")
    for number, goal in enumerate(goals, 1):
        left.annotate(f"{number}: z = {goal[2]} m", goal[:2], xytext=(6, 6), textcoords="offset points")
    left.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    left.margins(0.4, 0.15)
    right.plot([row[0] for row in rows], [row[4] for row in rows], color="#0072B2")
    right.set(xlabel="time (s)", ylabel="smallest tension (N)", ylim=(0, None))
    for panel in (left, right):
        panel.grid(alpha=0.3)
    figure.savefig(path, dpi=120)


def main():
    arguments = parser(__doc__)
    arguments.add_argument(
        "goals", nargs="*", type=position, default=TOUR, metavar="X,Y,Z", help="goals, m"
    )
    arguments.add_argument("--longest", type=seconds, default=20.0, help="time for one goal, s (default: %(default)s)")
    chosen = options(arguments)

    every, reached = [], 0
    with ClosedLoop(chosen.fmus, controller={"planner": EXACT}) as loop:
        for number, goal in enumerate(chosen.goals, 1):
            start, points = loop.time, loop.set_point_index()
            rows, status = move(loop, goal, chosen.longest)
            every += rows
            reached += status == AT_GOAL
            given = loop.set_point_index() - points
            print(
                f"{number}: ({', '.join(map(str, goal))}) {STATUS[status]} after {loop.time - start:.2f} s,"
                f" {given} set points, smallest tension {min(row[4] for row in rows):.3f} N"
            )
    print(f"{reached} of {len(chosen.goals)} goals reached in {every[-1][0]:.2f} s")
    if chosen.csv:
        write_csv(chosen.csv, ["time", "x", "y", "z", "smallestTension"], every)
    if chosen.picture:
        draw(chosen.picture, every, chosen.goals)
    return 0 if reached == len(chosen.goals) else 3


if __name__ == "__main__":
    run(main)
