"""Reads proof files (version 1) of cable-suspended robots: conditions (C1) to (C3), fields, limits and hash, and (C5)."""
import hashlib
import json
import math
from fractions import Fraction

SIZE = 10_000_000  # bytes of a file at most


class Refused(Exception):
    """The proof is refused; `condition` is "C1" to "C18"."""

    def __init__(self, condition, message):
        super().__init__(f"{condition}: {message}")
        self.condition, self.message = condition, message


def demand(holds, condition, message):
    """Refuses the proof unless the condition `holds`."""
    if not holds:
        raise Refused(condition, message)


def brief(value):
    """A value of the file for a message."""
    return json.dumps(value)[:80]


def spelling(x):
    """The one spelling of a double."""
    mantissa, exponent = (x + 0.0).hex().split("p")
    return f"{mantissa.rstrip('0').rstrip('.')}p{exponent}"


def number(value, where, words="a number"):
    """A number of the file."""
    try:
        found = float.fromhex(value)
        if math.isfinite(found) and spelling(found) == value:
            return found
    except (TypeError, ValueError, OverflowError):
        pass
    raise Refused("C1", f"{where}: expected {words} as printf(\"%a\") spells it, found {brief(value)}")


def limit(value, where):
    """A number of the file or infinity."""
    return math.inf if value == "inf" else number(value, where, "\"inf\" or a number")


def anything(value, where):
    """What is looked at later."""
    return value


def whole(value, where):
    """A JSON number without a fraction."""
    demand(type(value) is int, "C1", f"{where}: expected a number without a fraction, found {brief(value)}")
    return value


def array(inner, least, greatest=None):
    """The shape of an array of `least` (to `greatest`) times `inner`."""
    return inner, least, least if greatest is None else greatest


VECTOR, SIX = array(number, 3), array(number, 6)
CABLE = {"anchor": VECTOR, "attachment": VECTOR, "least": number, "greatest": limit,
         "pulley?": {"radius": number, "axis": VECTOR}}
PART = {"way": array(SIX, 1, 4), "begin": number, "s": number, "rate": number, "acceleration": number, "beta": number,
        "jerk": number}
PIECE = {"duration": number, "offset": SIX, "parts": array(PART, 1, 4)}
PROBLEM = {"rig": {"mass": number, "inertia": array(VECTOR, 3), "gravity": VECTOR, "disturbance": SIX,
                   "cables": array(CABLE, 0, SIZE)},
           "step?": {"start": SIX, "rates": SIX, "setPoint": SIX, "lambda": number, "eta": number},
           "motion?": {"pieces": array(PIECE, 1, SIZE)},
           "margins?": {name: number for name in ("mass", "centreOfMass", "force", "torque", "friction", "accuracy",
                                                  "samplePeriod", "delay", "lawMargin?")}}
TUBE = {"disturbance": SIX, "pull": number, "shortest": number, "sideways?": number, "stiffness": array(SIX, 3),
        "intrusion?": number}
FILE = {"format": anything, "version": anything, "problem": PROBLEM, "sha256": anything, "verdict": anything}
VERDICTS = {"admissible": {"least": number, "greatest": number, "spans": array(anything, 1, SIZE), "tube?": TUBE,
                           "jump?": array(number, 2)},
            "not admissible": {"instant": anything}}
FARKAS = {"time": number, "multipliers": SIX, "shortfall": number}


def lemma_shape(terms, bounds, more):
    """The shape of a span or an instant that rests on the lemma; at most so many coefficients a polynomial."""
    return {"inverse": array(SIX, 6), "solution": array(array(number, 1, terms), 6), "error": SIX,
            "least": bounds, "greatest": bounds} | more


def read(value, shape, where):
    """`value` of the JSON text as `shape` says, its numbers as floats."""
    if isinstance(shape, dict):
        demand(isinstance(value, dict), "C1", f"{where}: expected an object")
        names = {name.rstrip("?"): name for name in shape}
        for key in value:
            demand(key in names, "C1", f"{where}: unexpected field {brief(key)}")
        for key, name in names.items():
            demand(key in value or name != key, "C1", f"{where}: field \"{key}\" is missing")
        return {key: read(value[key], shape[names[key]], f"{where}.{key}") for key in value}
    if isinstance(shape, tuple):
        inner, least, greatest = shape
        sizes = least if least == greatest else f"{least} to {greatest}"
        demand(isinstance(value, list), "C1", f"{where}: expected an array of {sizes}")
        demand(least <= len(value) <= greatest, "C1", f"{where}: expected an array of {sizes}, found {len(value)}")
        return [read(entry, inner, f"{where}[{k}]") for k, entry in enumerate(value)]
    return shape(value, where)


def unique(pairs):
    """A JSON object, no key of which may come twice."""
    demand(len(dict(pairs)) == len(pairs), "C1", "an object has the same key twice")
    return dict(pairs)


def read_file(text):
    """The proof in `text`, its numbers as floats; (C1) to (C3)."""
    try:
        data = text.encode() if isinstance(text, str) else text
        demand(len(data) <= SIZE, "C1", f"expected at most {SIZE} bytes")
        raw = json.loads(data.decode(), object_pairs_hook=unique)
    except (ValueError, RecursionError) as fault:      # of JSON with line and column
        raise Refused("C1", f"not JSON: {str(fault)[:100]}") from None
    for key, expected in ("format", ["cable-robot proof"]), ("version", [1]), ("verdict", list(VERDICTS)):
        found = raw.get(key) if isinstance(raw, dict) else raw
        demand(type(found) is type(expected[0]) and found in expected, "C1",
               f"{key}: expected {' or '.join(map(brief, expected))}, found {brief(found)}")
    proof = read(raw, FILE | VERDICTS[raw["verdict"]], "file")
    moves = "motion" in proof["problem"]
    demand(moves != ("step" in proof["problem"]), "C1", "problem: expected either a step or a motion")
    demand(not moves or raw["verdict"] == "admissible", "C1", "verdict: expected admissible, the only one of a motion")
    demand(moves == ("jump" in proof), "C1", "jump: expected of a motion, and of nothing else")
    check_problem(proof["problem"]["rig"], proof["problem"].get("step"), proof["problem"].get("motion"))
    check_margins(proof)
    text = json.dumps(raw["problem"], sort_keys=True, separators=(",", ":"))
    digest = hashlib.sha256(text.encode()).hexdigest()
    demand(proof["sha256"] == digest, "C3", f"the problem's sha256 is {digest}, found {brief(proof['sha256'])}")
    n = len(proof["problem"]["rig"]["cables"])
    if "instant" in proof:
        shape = FARKAS if n > 6 else lemma_shape(1, number, {"time": number, "cable": anything})
        return proof | {"instant": read(proof["instant"], shape, "instant")}
    more = {"base": array(number, n), "basis": array(SIX, n)} if n > 6 else {}
    more |= {"multipliers": SIX, "distance": number} if n > 6 and "tube" in proof else {}
    usual = more | {"from": number, "to": number} | ({"piece": whole} if moves else {})
    last = more if moves else more | {"from": number}
    usual, last = lemma_shape(6, array(number, n), usual), lemma_shape(1, array(number, n), last)
    spans = zip(proof["spans"], [usual] * (len(proof["spans"]) - 1) + [last])
    return proof | {"spans": [read(*span, f"span {k}") for k, span in enumerate(spans, 1)]}


def check_problem(rig, step=None, motion=None):
    """(C2), exact."""
    cables, inertia = rig["cables"], rig["inertia"]
    demand(6 <= len(cables) <= 16, "C2", f"expected 6 to 16 cables, found {len(cables)}")
    positive = [("mass", rig["mass"])] + [(gain, step[gain]) for gain in ("lambda", "eta") if step]
    for k, piece in enumerate(motion["pieces"] if motion else [], 1):
        positive.append((f"duration of piece {k}", piece["duration"]))
        for part in piece["parts"]:
            demand(part["beta"] == 0 or part["jerk"] == 0, "C2",
                   f"piece {k}: expected beta or jerk = 0, found {part['beta']}, {part['jerk']}")
    for name, x in positive:
        demand(x > 0, "C2", f"expected {name} > 0, found {x}")
    for i in range(3):
        demand(inertia[i][i] > 0, "C2", f"inertia: expected a positive diagonal, found {inertia[i][i]}")
        demand(inertia[i][i - 1] == inertia[i - 1][i], "C2", "inertia: expected a symmetric matrix")
    for i, cable in enumerate(cables, 1):
        least, greatest, pulley = cable["least"], cable["greatest"], cable.get("pulley", {"radius": 1, "axis": [1]})
        demand(0 <= least < greatest, "C2", f"cable {i}: expected 0 <= least < greatest, found {least}, {greatest}")
        demand(pulley["radius"] > 0, "C2", f"cable {i}: expected a radius > 0, found {pulley['radius']}")
        demand(abs(sum(Fraction(k) ** 2 for k in pulley["axis"]) - 1) <= Fraction(1, 10 ** 12), "C2",
               f"cable {i}: expected an axis of length 1, found {pulley['axis']}")


def check_margins(proof):
    """(C1) and (C2) of the margins and of the tube."""
    cables, margins, tube = proof["problem"]["rig"]["cables"], proof["problem"].get("margins"), proof.get("tube")
    if margins:
        demand("step" in proof["problem"], "C1", "margins are of a step only, this is a motion")
        for name, x in margins.items():
            demand(x >= 0, "C2", f"margins: expected {name} >= 0, found {x}")
        demand(margins["mass"] < 1, "C2", f"margins: expected mass < 1, found {margins['mass']}")
        demand(("lawMargin" in margins) == (len(cables) > 6), "C1", "margins.lawMargin: expected of more than six cables only")
    wanted = margins is not None and proof["verdict"] == "admissible"
    demand(wanted == (tube is not None), "C1", f"tube: expected {'one' if wanted else 'none'}, with margins only")
    if tube:
        pulleys = any("pulley" in cable for cable in cables)
        for name, wanted in ("sideways", pulleys), ("intrusion", len(cables) > 6):
            demand((name in tube) == wanted, "C1", f"tube.{name}: expected {'one' if wanted else 'none'}")
        for name, x in tube.items():
            numbers = [x] if isinstance(x, float) else sum((y if isinstance(y, list) else [y] for y in x), [])
            demand(min(numbers) >= 0, "C2", f"tube: expected {name} >= 0, found {min(numbers)}")
        demand(tube["shortest"] > 0, "C2", "tube: expected shortest > 0, found 0")


def check_times(step, spans):
    """(C5), exact."""
    demand(spans[0]["from"] == 0, "C5", f"span 1: expected from = 0, found {spans[0]['from']}")
    for k, (span, after) in enumerate(zip(spans, spans[1:]), 1):
        demand(span["from"] < span["to"], "C5", f"span {k}: expected from < to, found {span['from']}, {span['to']}")
        demand(after["from"] <= span["to"], "C5",
               f"span {k + 1}: expected from <= {span['to']}, where span {k} ends, found {after['from']}")
    start, slow = spans[-1]["from"], min(step["lambda"], step["eta"])
    demand(Fraction(start) * Fraction(slow) >= 1, "C5", f"last span: expected from >= 1/{slow}, found {start}")
