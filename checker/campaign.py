"""Proofs of random problems, honest ones and bent ones, through the checker.

    python checker/campaign.py PROGRAM CASES SEED [PER_SEED]

PROGRAM is `cable-robot`. Of each problem (`study proofs`: six and eight cables, both verdicts, a quarter with pulleys; with margins where it writes such) the proof must be accepted with the
verdict that it states, and the same proof bent in one of the ways that its verdict has must be refused with the condition that names the fault. PER_SEED problems
(1000) are drawn from each of SEED, SEED + 1, ...: a run that was stopped goes on from the seed that it printed last. Exit code 1 if the checker is wrong
about any.
"""

import hashlib
import json
import math
import random
import subprocess
import sys
import time

from check_proof import check
from proof_file import Refused, spelling


def double(text):
    return float.fromhex(text)


def raised(text, least):
    """A number raised by at least this and at least some units in its last place."""
    value = double(text)
    return spelling(value + max(least, 8 * math.ulp(value)))


def bend_solution(part, draw):
    """By more than twice the error that is claimed: then the true solution is farther off than claimed."""
    k = draw.randrange(6)
    coefficients = part["solution"][k]
    j = draw.randrange(len(coefficients))
    coefficients[j] = raised(coefficients[j], 3 * double(part["error"][k]))


def any_span(proof, draw):
    return draw.choice(proof["spans"])


def bent(proof, draw):
    span = any_span(proof, draw)
    bend_solution(span, draw)


def too_good(proof, draw):
    """A least tension above the greatest one."""
    span = any_span(proof, draw)
    i = draw.randrange(len(span["least"]))
    span["least"][i] = raised(span["greatest"][i], 1e-9 * abs(double(span["greatest"][i])))
    proof["least"] = min((s for each in proof["spans"] for s in each["least"]), key=double)


def dropped(proof, draw):
    proof["spans"].pop(draw.randrange(len(proof["spans"])))


def gap(proof, draw):
    k = draw.randrange(len(proof["spans"]) - 1)
    span, after = proof["spans"][k : k + 2]
    begin, end = double(span["from"]), double(after["from"])
    span["to"] = spelling(begin + draw.uniform(0.5, 0.999) * (end - begin))


def better(proof, draw):
    proof["least"] = raised(proof["least"], 0.0)


def another_rig(proof, draw):
    proof["problem"]["rig"]["mass"] = raised(proof["problem"]["rig"]["mass"], 0.0)


def bent_instant(proof, draw):
    bend_solution(proof["instant"], draw)


def greater_shortfall(proof, draw):
    proof["instant"]["shortfall"] = raised(proof["instant"]["shortfall"], 1e-3 * abs(double(proof["instant"]["shortfall"])))


def other_side(proof, draw):
    """Farkas' vector the other way round proves nothing."""
    proof["instant"]["multipliers"] = [spelling(-double(x)) for x in proof["instant"]["multipliers"]]


def smaller(proof, draw):
    """Less than what disturbs: G has terms that do not depend on D."""
    d = proof["tube"]["disturbance"]
    k = draw.choice([k for k in range(6) if double(d[k]) > 0])
    d[k] = spelling(1e-3 * double(d[k]))


def less_pull(proof, draw):
    proof["tube"]["pull"] = spelling(draw.uniform(0, 0.5) * double(proof["tube"]["pull"]))


def longer(proof, draw):
    proof["tube"]["shortest"] = spelling(draw.uniform(2, 9) * double(proof["tube"]["shortest"]))


def softer(proof, draw):
    """Each bound of a row: one alone may be a hundred times what is so, and bent hold still."""
    k, share = draw.randrange(3), draw.uniform(0, 0.01)
    proof["tube"]["stiffness"][k] = [spelling(share * double(x)) for x in proof["tube"]["stiffness"][k]]


def sealed_again(proof):
    text = json.dumps(proof["problem"], sort_keys=True, separators=(",", ":"))
    proof["sha256"] = hashlib.sha256(text.encode()).hexdigest()


def more_wrong(proof, draw):
    """A margin raised, under its own hash, by what alone makes G greater than D."""
    rig, step, margins, tube = proof["problem"]["rig"], proof["problem"]["step"], proof["problem"]["margins"], proof["tube"]
    mass, g = double(rig["mass"]), [abs(double(x)) for x in rig["gravity"]]
    inertia = math.hypot(*[double(x) for row in rig["inertia"] for x in row])
    push, turn = [max(map(double, tube["disturbance"][k : k + 3])) for k in (0, 3)]
    more = {"mass": push / max(g), "centreOfMass": turn * inertia / (mass * max(g)), "force": mass * push,
            "torque": turn * inertia, "friction": mass * push / 6,
            "accuracy": mass * push * double(tube["shortest"]) / (2 * double(tube["pull"])),
            "samplePeriod": 1 / (double(step["lambda"]) + double(step["eta"]))}
    more["delay"] = more["samplePeriod"]
    name = draw.choice([name for name in more if more[name] > 0])
    margins[name] = spelling(double(margins[name]) + 1.01 * more[name])
    sealed_again(proof)


def no_tube(proof, draw):
    del proof["tube"]


def nearer(proof, draw):
    """A law that is nearer than it is; cut finely, a span may prove much less than the file claims."""
    span = any_span(proof, draw)
    span["distance"] = spelling(draw.choice((-1, 0, 1e-3)) * double(span["distance"]))


def bent_multipliers(proof, draw):
    """By so much that the sum for them is greater than the distance allows, for any tensions within the limits."""
    span = any_span(proof, draw)
    k = draw.randrange(3)
    size = max(abs(double(x)) for x in span["multipliers"][:3])
    span["multipliers"][k] = spelling(double(span["multipliers"][k]) + draw.choice((-1, 1)) * 100 * size)


def less_intrusion(proof, draw):
    proof["tube"]["intrusion"] = spelling(draw.uniform(0, 0.3) * double(proof["tube"]["intrusion"]))


def more_intrusion(proof, draw):
    """More than the law's margin leaves to friction."""
    margins = proof["problem"]["margins"]
    proof["tube"]["intrusion"] = raised(spelling(double(margins["lawMargin"]) - double(margins["friction"])), 0.0)


def less_margin(proof, draw):
    """A law that keeps less, under its own hash, than intrusion and friction take."""
    margins = proof["problem"]["margins"]
    margins["lawMargin"] = spelling(draw.uniform(0, 0.9) * (double(margins["friction"]) + double(proof["tube"]["intrusion"])))
    sealed_again(proof)


def more_margin(proof, draw):
    """A law that keeps more than there is between the limits, or than the tensions do."""
    span = any_span(proof, draw)
    cables = proof["problem"]["rig"]["cables"]
    proof["problem"]["margins"]["lawMargin"] = raised(spelling(min(
        double(high) - double(c["least"]) for c, high in zip(cables, span["greatest"]))), 0.0)
    sealed_again(proof)


# What may be done to a proof, and the conditions that may name it.
OF_YES = [
    (bent, {"C7"}),
    (too_good, {"C1", "C8"}),
    (dropped, {"C1", "C5", "C10"}),
    (gap, {"C5"}),
    (better, {"C10"}),
    (another_rig, {"C3"}),
]
OF_TUBE = [
    (smaller, {"C17"}),
    (less_pull, {"C16"}),
    (longer, {"C16"}),
    (softer, {"C16"}),
    (more_wrong, {"C2", "C4", "C17"}),
    (no_tube, {"C1"}),
]
OF_LAW = [
    (nearer, {"C18"}),
    (bent_multipliers, {"C18"}),
    (less_intrusion, {"C18"}),
    (more_intrusion, {"C18"}),
    (less_margin, {"C18"}),
    (more_margin, {"C18"}),
]
OF_SIX = [(bent_instant, {"C7", "C8"}), (another_rig, {"C3"})]
OF_MORE = [(greater_shortfall, {"C13"}), (other_side, {"C13"}), (another_rig, {"C3"})]


def bendings(proof):
    if proof["verdict"] == "admissible":
        return OF_YES + (OF_TUBE if "tube" in proof else []) + (OF_LAW if "intrusion" in proof.get("tube", {}) else [])
    return OF_SIX if "cable" in proof["instant"] else OF_MORE


def wrong_about(line, draw, ways=None):
    """What the checker says wrongly of a proof and of so many bent versions of it (of all), and how many it saw."""
    proof, wrong = json.loads(line), []
    try:
        if check(line).verdict != proof["verdict"]:
            wrong.append("another verdict")
    except Refused as refused:
        return [f"honest, refused: {refused}"], 0
    chosen = bendings(proof)
    chosen = chosen if ways is None else draw.sample(chosen, ways)
    for bend, conditions in chosen:
        other = json.loads(line)
        bend(other, draw)
        try:
            check(json.dumps(other))
            wrong.append(f"{bend.__name__}: accepted")
        except Refused as refused:
            if refused.condition not in conditions:
                wrong.append(f"{bend.__name__}: refused for another reason: {refused}")
    return wrong, len(chosen)


def main(program, cases, seed, per_seed=1000, ways=1):
    honest, bad, wrong, spent = 0, 0, 0, []
    begun = time.monotonic()
    while honest < cases:
        command = [program, "study", "proofs", "--cases", str(min(per_seed, cases - honest)), "--seed", str(seed)]
        lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
        draw = random.Random(seed)
        for line in lines:
            before = time.process_time()
            said, count = wrong_about(line, draw, ways)
            spent.append((time.process_time() - before) / (count + 1))
            for text in said:
                print(f"seed {seed}: {text}")
            honest, bad, wrong = honest + 1, bad + count, wrong + len(said)
        took = time.monotonic() - begun
        print(f"seed {seed}: {honest} proofs, {bad} bent ones, {wrong} times wrong, {took:.0f} s", file=sys.stderr, flush=True)
        seed += 1
    median = sorted(spent)[len(spent) // 2]
    print(f"{honest} proofs accepted or not as they should be, {bad} bent ones refused: {wrong} times wrong; {1e3 * median:.1f} ms each in the median")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:])))
