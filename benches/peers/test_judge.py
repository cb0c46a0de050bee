"""Tests of the judge: motions whose least tension is known in closed form, a step judged by dense samples of another model, and what hides between samples.

At the middle of Table I's rig, level and not turned, all six cables pull alike, u = m (g - z'') l/(6 z) where all are equally long, l.
"""

import math
import tomllib

import pytest

from judge import ROOT, Judge
from test_check_proof import instant_solution, make_rig, make_step  # the checker's tests are on the path by now

LEAST, GREATEST = 0.5, 40.0
UNIT = [[float(i == j) for j in range(6)] for i in range(6)]


def paper():
    file = tomllib.loads((ROOT / "rigs/paper.toml").read_text())
    inertia = [[x if i == j else 0.0 for j in range(3)] for i, x in enumerate(file["platform"]["inertia"])]
    cables = [{"anchor": c["anchor"], "attachment": c["attachment"], "least": LEAST, "greatest": GREATEST} for c in file["cables"]]
    return {"mass": 6.0, "inertia": inertia, "gravity": [0.0, 0.0, 9.81], "disturbance": [0.0] * 6, "cables": cables}


ANCHOR, ATTACHMENT = (paper()["cables"][0][end] for end in ("anchor", "attachment"))
ACROSS = math.hypot(ANCHOR[0] - ATTACHMENT[0], ANCHOR[1] - ATTACHMENT[1])


def pull(z, acceleration):
    """Of each cable in the middle."""
    return 6.0 * (9.81 - acceleration) * math.hypot(ACROSS, z) / (6 * z)


def piece(duration, way, s=0.0, rate=1.0, acceleration=0.0, beta=0.0, jerk=0.0):
    way = [[0.0, 0.0, c, 0.0, 0.0, 0.0] if isinstance(c, float) else c for c in way]
    part = {"way": way, "begin": 0.0, "s": s, "rate": rate, "acceleration": acceleration, "beta": beta, "jerk": jerk}
    return {"duration": duration, "offset": [0.0] * 6, "parts": [part]}


def judged(*pieces):
    judge = Judge({"rig": paper(), "motion": {"pieces": list(pieces)}})
    return judge, judge.least(0), judge.least(1)


def close(margin, expected):
    return margin.lower <= expected + 1e-9 and expected - 1e-9 <= margin.upper <= margin.lower + 1.1e-6 * 6 * 9.81


def test_least_tensions_that_are_known_in_closed_form_are_enclosed():
    """Of a cubic of time: z'' = 2 c2 + 6 c3 t."""
    _, below, above = judged(piece(0.5, [1.0, 0.1, -1.0, 4.0]))
    times = [0.5 * k / 2000 for k in range(2001)]
    pulls = [pull(1 + 0.1 * t - t**2 + 4 * t**3, -2 + 24 * t) for t in times]
    pulls.append(pull(1 + 0.05 - 0.25 + 0.5, 0.0))  # the rest after it
    assert close(below, min(pulls) - LEAST) and close(above, GREATEST - max(pulls))
    assert below.lower < below.upper and below.time == pytest.approx(0.5)


def test_a_swing_that_samples_see_only_at_its_crests_is_found():
    """Samples each millisecond of a swing of 1 kHz all find z'' = -9.5; between them it is 9.5, and the cables are slack."""
    beta = -((2000 * math.pi) ** 2)
    judge, below, above = judged(piece(0.003, [1.0, 1.0], rate=0.0, acceleration=-9.5, beta=beta))
    for k in range(4):
        sampled, _ = judge.at(0, k * 1e-3)
        assert sampled.lower > 17
    height = 2 * 9.5 / -beta
    assert close(below, pull(1.0 - height, 9.5) - LEAST)
    assert below.upper < 0
    assert close(above, GREATEST - pull(1.0, -9.5))


def test_a_breach_of_a_microsecond_between_two_samples_is_found():
    still = [1.0, 0.0]
    fall = piece(1e-6, [1.0, 0.0, 9.6 / 2])
    _, below, _ = judged(piece(0.10037, still), fall, piece(0.2, still))
    assert below.upper < 0 and below.piece == 1
    assert close(below, pull(1.0, 9.6) - LEAST)


def test_a_motion_that_keeps_the_limits_is_within_and_exactly_at_the_limit_it_is_not_beyond():
    _, below, _ = judged(piece(0.1, [1.0, 0.0]))
    assert below.lower > 0
    rig = paper()
    for cable in rig["cables"]:
        cable["least"] = pull(1.0, 0.0)
    below = Judge({"rig": rig, "motion": {"pieces": [piece(0.1, [1.0, 0.0])]}}).least(0)
    assert abs(below.upper) < 1e-12 and abs(below.lower) < 1e-12


def test_the_rest_after_a_motion_counts():
    """It falls to the end, so that only the rest asks the cables for the whole weight."""
    _, _, above = judged(piece(0.1, [1.0, 0.0, 1.0]))
    assert above.piece == -1
    assert close(above, GREATEST - pull(1.01, 0.0))


def test_a_step_is_judged_as_dense_samples_of_another_model_find_it():
    problem = {"rig": make_rig(6), "step": make_step()}
    least, greatest = math.inf, -math.inf
    for k in range(301):
        _, _, y, lengths = instant_solution(problem, [0.0] * 6, UNIT, 9.0 * (k / 300) ** 2)
        pulls = [a * b for a, b in zip(y, lengths)]
        least, greatest = min(least, *pulls), max(greatest, *pulls)
    below, above = (Judge(problem).least(side) for side in (0, 1))
    for margin, sampled in (below, least - 0.5), (above, 200.0 - greatest):
        assert margin.lower <= sampled <= margin.upper + 1e-3
        assert margin.upper - margin.lower < 1.1e-6 * 6 * 9.81


def test_nothing_is_said_of_a_motion_through_a_singular_pose(monkeypatch):
    """Through the plane of the anchors, where no tension holds it; what is not proved is no margin."""
    monkeypatch.setattr("judge.CUTS", 30)
    _, below, above = judged(piece(0.1, [0.05, -1.0]))
    assert below.lower == above.lower == -math.inf


def test_what_toppra_leaves_between_two_points_is_found():
    """Recorded: toppra 0.6.10, Collocation, about the switch of a level move; at the beginning of each interval the limits are kept."""
    start, goal = [-0.09408427399475727, -0.038336775513712174, 1.0, 0, 0, 0], [0.1267565543374033, 0.01907165660963911, 1.0, 0, 0, 0]
    rows = [
        (0.001452507195822017, 0.51, 3.4357466102514147, 9.056241386515564),
        (0.0014470030548083823, 0.515, 3.4489008660324294, 9.007384440799795),
        (0.0014469091937799883, 0.52, 3.4619345788341005, -8.6981317293425),
        (0.0014526772945207544, 0.525, 3.449349172066205, -10.22733240214321),
    ]
    way = [start, [b - a for a, b in zip(start, goal)]]
    judge, below, _ = judged(*(piece(duration, way, *row) for duration, *row in rows))
    assert min(judge.at(k, 0.0)[0].lower for k in range(4)) > -1e-9
    assert below.upper == pytest.approx(-0.052649, abs=1e-6) and (below.piece, below.cable) == (1, 5)


def test_more_than_six_cables_are_refused():
    with pytest.raises(ValueError, match="six cables"):
        Judge({"rig": make_rig(8), "step": make_step()})
