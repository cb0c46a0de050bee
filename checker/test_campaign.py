"""A sample of the campaign: what the program writes is accepted, what is bent is refused."""

import json
import random
from pathlib import Path

import pytest

import campaign
from test_check_proof import sealed
from test_margins import made

PROGRAM = Path(__file__).parents[1] / "target/debug/cable-robot"


def test_proofs_of_random_problems_are_accepted_and_bent_ones_refused(capsys):
    assert campaign.main(PROGRAM, 100, 7, ways=None) == 0, capsys.readouterr().out


def test_a_checker_that_accepts_everything_is_found_out(monkeypatch, capsys):
    monkeypatch.setattr(campaign, "check", lambda text: campaign.json.loads(text) and type("V", (), campaign.json.loads(text)))
    assert campaign.main(PROGRAM, 4, 7, ways=None) == 1
    assert "accepted" in capsys.readouterr().out


@pytest.mark.parametrize("pulley", [False, True])
def test_proofs_with_margins_are_accepted_and_bent_ones_refused(pulley):
    wrong, count = campaign.wrong_about(sealed(json.loads(made(pulley))), random.Random(2))
    assert not wrong and count == 12
