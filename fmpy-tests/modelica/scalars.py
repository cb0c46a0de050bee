"""Simulates the package's plant for a second with PyPI's modelica, which knows no arrays in components: those of the plant are written out as scalars.

Reads the folder of the classes, the start pose and the tensions as JSON; prints the pose at the end.
"""

import json
import re
import sys
from pathlib import Path

from modelica.lang import parse
from modelica.sim import causalize, flatten, simulate

ARRAY = r"parameter Real (\w+)\[\d\](?:\([^)]*\))? = \{([^}]*)\}[^;]*;"
CONNECTOR = r"CableRobot\.Interfaces\.Real(?:In|Out)put (\w+)\[(\d)\][^;]*;"


def source(folder, name):
    return re.sub(r"^within [^;]*;\s*", "", (folder / f"{name}.mo").read_text()).replace("CableRobot.Plants.", "")


def written_out(text, values):
    """Arrays with numbers for elements become scalar parameters, outputs scalar variables."""

    def parameters(name, numbers):
        return "\n".join(f"parameter Real {name}_{k} = {number};" for k, number in enumerate(numbers, 1))

    def array(match):
        return parameters(match[1], values.get(match[1]) or match[2].split(","))

    def connector(match):
        if match[1] in values:
            return parameters(match[1], values[match[1]])
        return "\n".join(f"Real {match[1]}_{k};" for k in range(1, int(match[2]) + 1))

    text = re.sub(CONNECTOR, connector, re.sub(ARRAY, array, text))
    return re.sub(r"\b(\w+)\[(\d)\]", r"\1_\2", text)


given = json.load(sys.stdin)
plants = Path(given["folder"])
values = {name: given[name] for name in ("initialPose", "motorTension")}
classes = [parse(source(plants, "Cable")), parse(written_out(source(plants, "Plant"), values))]
found = simulate(causalize(flatten(classes, "Plant")), stop=1.0, tolerance=1e-12, absolute=1e-14)
print(json.dumps([float(found[f"encoderPose_{k}"][-1]) for k in range(1, 7)]))
