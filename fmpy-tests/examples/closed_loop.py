"""Controller and plant FMU in a closed loop: the paper's move (Section VI), or one to a goal of your own.

Prints the set points, the smallest tension and the time to the goal. The other examples build on the class ClosedLoop.
"""

import argparse
import csv
import math
import re
import shutil
import sys
from pathlib import Path

from fmpy import extract, instantiate_fmu, read_model_description

FMUS = Path(__file__).resolve().parents[2] / "target" / "fmu" / "fmi3"
POSE = ["x", "y", "z", "roll", "pitch", "yaw"]
TENSIONS = [f"measuredTension[{cable}]" for cable in range(1, 7)]
STATUS = {1: "Disabled", 2: "Holding", 3: "Moving", 4: "AtGoal", 5: "GoalUnreachable", 6: "SensorFault",
          7: "WaitingForPose"}
AT_GOAL, GOAL_UNREACHABLE = 4, 5
PICTURES = [".png", ".svg", ".pdf"]


class Fmu:
    """One instance of an FMI 3.0 co-simulation FMU, its variables by name."""

    def __init__(self, path):
        description = read_model_description(path)
        self.folder = extract(path)
        self.fmu = instantiate_fmu(self.folder, description, fmi_type="CoSimulation")
        self.variables = {variable.name: variable for variable in description.modelVariables}

    def _access(self, action, names):
        first = self.variables[names[0]].type
        kind = "Int64" if first == "Enumeration" else first
        return getattr(self.fmu, action + kind), [self.variables[name].valueReference for name in names]

    def get(self, *names):
        """The values of variables of one type."""
        call, references = self._access("get", names)
        return call(references)

    def set(self, names, values):
        """Sets variables of one type."""
        call, references = self._access("set", names)
        call(references, list(values))

    def close(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


class ClosedLoop:
    """Both FMUs, connected; `controller` and `plant` are parameters by name. Step sizes are in seconds, z points down."""

    def __init__(self, fmus=FMUS, goal=(0.15, 0.15, 1.0), step=1e-3, controller=None, plant=None):
        self.time, self.count, self.h = 0.0, 0, step
        self.controller = Fmu(Path(fmus) / "CableRobotController.fmu")
        self.plant = Fmu(Path(fmus) / "CableRobotPlant.fmu")
        for fmu, parameters in ((self.controller, controller), (self.plant, plant)):
            for name, value in (parameters or {}).items():
                fmu.set([name], [value])
            fmu.fmu.enterInitializationMode()
        self.move_to(goal)
        self._measure()
        self._pull()
        self.controller.fmu.exitInitializationMode()
        self.plant.fmu.exitInitializationMode()

    def move_to(self, goal):
        """A new goal x, y, z (m); it may be given at any time."""
        self.controller.set(["goalPose.x", "goalPose.y", "goalPose.z"], goal)

    def step(self):
        """The controller first, then the plant with its tensions: no delay in the loop."""
        self._measure()
        self.controller.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=self.h)
        self._pull()
        self.plant.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=self.h)
        self.count += 1
        self.time = self.count * self.h

    def _measure(self):
        for names in ([f"encoderPose.{axis}" for axis in POSE], TENSIONS, [f"cableLength[{i}]" for i in range(1, 7)]):
            self.controller.set(names, self.plant.get(*names))

    def _pull(self):
        names = [f"motorTension[{cable}]" for cable in range(1, 7)]
        self.plant.set(names, self.controller.get(*names))

    def position(self):
        return self.plant.get("encoderPose.x", "encoderPose.y", "encoderPose.z")

    def set_point(self):
        return self.controller.get("setPoint.x", "setPoint.y", "setPoint.z")

    def set_point_index(self):
        return self.controller.get("setPointIndex")[0]

    def tensions(self):
        """What the six cables pull, N."""
        return self.plant.get(*TENSIONS)

    def status(self):
        """A number of STATUS."""
        return self.controller.get("status")[0]

    def close(self):
        self.controller.close()
        self.plant.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def number(text, allowed=lambda _: True, what="a finite number"):
    """Reads a number that is allowed."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found) or not allowed(found):
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is not {what}")
    return found


def seconds(text):
    """Reads a time."""
    return number(text, lambda found: found > 0, "a time above 0 (s)")


def gain_values(text):
    """Reads gains with commas between them."""
    return [number(part, lambda found: 0 < found <= 1000, "a gain above 0 and up to 1000 (1/s)") for part in text.split(",")]


def position(text):
    """Reads x,y,z below the base."""
    found = [number(part) for part in text.split(",")]
    if len(found) != 3:
        raise argparse.ArgumentTypeError(f"{text.strip()}: {len(found)} numbers; a position is x,y,z (m)")
    if found[2] <= 0:
        raise argparse.ArgumentTypeError(f"{text.strip()}: z points down, a position below the base has z > 0 (m)")
    return found


def parser(description):
    """The options that all examples share."""
    result = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    result.add_argument("--fmus", type=Path, default=FMUS, help="folder of the two FMUs (default: %(default)s)")
    result.add_argument("--picture", type=Path, help=f"writes a picture into this file: {', '.join(PICTURES)}")
    result.add_argument("--csv", type=Path, help="writes a table into this file")
    return result


def options(parser):
    """Reads the command line; says so at once if the FMUs are not there, or a result cannot be written."""
    # A word that begins with a space is no option, -0.1,0,1 would be taken for one.
    found = parser.parse_args([f" {word}" if re.match(r"-[\d.]", word) else word for word in sys.argv[1:]])
    for path in filter(None, (found.picture, found.csv)):
        if path.is_dir() or not path.parent.is_dir():
            parser.error(f"cannot write {path}: " + ("it is a folder" if path.is_dir() else f"no folder {path.parent}"))
    if found.picture and found.picture.suffix not in PICTURES:
        parser.error(f"cannot write {found.picture}: a picture ends with {', '.join(PICTURES)}")
    if not (found.fmus / "CableRobotController.fmu").exists():
        parser.error(f"no CableRobotController.fmu in {found.fmus}: run `cargo fmu build`, or give --fmus")
    return found


def run(main):
    """Ends the program with what `main` returns, and after Ctrl-C with 130, as shells have it."""
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        sys.exit(130)


def write_csv(path, header, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def draw(path, rows):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    time, *columns = zip(*rows)
    figure, (above, below) = plt.subplots(2, sharex=True, figsize=(8, 6), layout="constrained")
    for k, (axis, colour, line) in enumerate(zip("xyz", ["#0072B2", "#E69F00", "#009E73"], ["-", "--", "-"])):
        start = columns[k][0]
        above.plot(time, [value - start for value in columns[k]], color=colour, linestyle=line, label=axis)
        above.step(time, [value - start for value in columns[3 + k]], color=colour, linestyle=":", where="post")
    above.set_ylabel("way from the start (m)\ndotted: set point")
    for cable, colour in enumerate(["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9"]):
        below.plot(time, columns[6 + cable], color=colour, label=f"u{cable + 1}")
    below.set(xlabel="time (s)", ylabel="tension (N)", ylim=(0, None))
    for panel in (above, below):
        panel.grid(alpha=0.3)
        panel.legend(ncols=6, loc="lower right", bbox_to_anchor=(1, 1), frameon=False)
    figure.savefig(path, dpi=120)


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--goal", type=position, default=[0.15, 0.15, 1.0], metavar="X,Y,Z", help="goal, m")
    arguments.add_argument("--duration", type=seconds, default=9.0, help="simulated time, s (default: %(default)s)")
    arguments.add_argument("--step", type=seconds, default=1e-3, help="communication step, s (default: %(default)s)")
    chosen = options(arguments)

    rows, arrival = [], None
    with ClosedLoop(chosen.fmus, chosen.goal, chosen.step) as loop:
        seen = 0
        while loop.time < chosen.duration:
            loop.step()
            rows.append([loop.time, *loop.position(), *loop.set_point(), *loop.tensions()])
            if loop.set_point_index() > seen:
                seen = loop.set_point_index()
                print(f"set point {seen} from {loop.time:.2f} s on: ({', '.join(f'{x:.4f}' for x in loop.set_point())}) m")
            if arrival is None and loop.status() == AT_GOAL:
                arrival = loop.time
        status = loop.status()
    smallest, cable, time = min((min(row[7:]), row[7:].index(min(row[7:])) + 1, row[0]) for row in rows)
    print(f"smallest tension {smallest:.3f} N, in cable {cable} at {time:.2f} s")
    print(f"at the goal after {arrival:.2f} s" if arrival else f"not at the goal: {STATUS[status]}")
    if chosen.csv:
        header = ["time", *"xyz", *(f"setPoint.{axis}" for axis in "xyz"), *TENSIONS]
        write_csv(chosen.csv, header, rows)
    if chosen.picture:
        draw(chosen.picture, rows)
    return 0 if arrival else 3


if __name__ == "__main__":
    run(main)
