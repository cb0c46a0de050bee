"""At which height should a robot work? For each: static workspace, a move in minimum time with its smallest tension, and the mass error that the certificate bears.

Needs the wheel of `cargo wheel` (module cable_robot), and matplotlib for --picture.
"""

import argparse
import csv

import cable_robot


def borne(rig, start, goal, most=0.2, halvings=12):
    """The largest mass error, as a share, with which a step is still proved."""
    least = 0.0
    for _ in range(halvings):
        middle = 0.5 * (least + most)
        least, most = (middle, most) if cable_robot.certify(rig, start, goal, mass_error=middle) else (least, middle)
    return least


def draw(path, rows):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
    names = ["static workspace (m²)", "time of the move (s)", "mass error borne (%)"]
    for panel, name, column in zip(panels, names, [1, 2, 4]):
        panel.plot([row[0] for row in rows], [row[column] for row in rows], "o-", color="#0072B2")
        panel.set(xlabel="height of the centre of mass (m)", ylabel=name, ylim=(0, None))
        panel.grid(alpha=0.3)
    figure.savefig(path, dpi=120)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--rig", metavar="FILE", help="a rig file; the paper's rig if left out")
    arguments.add_argument("--heights", type=float, nargs="+", default=[0.5, 0.75, 1, 1.5, 2], metavar="Z", help="m, base frame")
    arguments.add_argument("--picture", metavar="FILE", help="png, svg or pdf")
    arguments.add_argument("--csv", metavar="FILE")
    chosen = arguments.parse_args()
    rig = cable_robot.Rig.load(chosen.rig) if chosen.rig else cable_robot.Rig.paper()
    x, y, *_ = rig.home
    print("height (m)  workspace (m²)  time (s)  smallest tension (N)  mass error borne (%)")
    rows = []
    for z in chosen.heights:
        workspace = rig.workspace(height=z)
        start, goal, near = (x, y, z), (x + 0.1, y + 0.1, z), (x + 0.04, y + 0.02, z)
        plan = cable_robot.plan(rig, start, goal, planner="minimum-time")
        time, tension = (plan.duration, plan.smallest_tension) if plan.reachable else (None, None)
        rows.append([z, workspace.area if workspace else 0.0, time, tension, 100 * borne(rig, start, near)])
        moved = f"{time:>8.3f}  {tension:>20.3f}" if plan.reachable else f"{'-':>8}  {'-':>20}"
        print(f"{z:>10g}  {rows[-1][1]:>14.4f}  {moved}  {rows[-1][4]:>20.2f}", flush=True)
    if chosen.csv:
        with open(chosen.csv, "w", newline="") as file:
            csv.writer(file).writerows([["height", "area", "time", "smallestTension", "massError"], *rows])
    if chosen.picture:
        draw(chosen.picture, rows)


if __name__ == "__main__":
    main()
