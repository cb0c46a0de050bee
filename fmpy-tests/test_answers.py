"""The schemas of what `cable-robot` prints with --json: real answers conform, bent ones do not, every field says what it is."""

import json
import subprocess
from pathlib import Path

import jsonschema
import pytest

from schemas import described

ROOT = Path(__file__).resolve().parent.parent

FROM = ["--from", "0,0,1"]
EIGHT = ["--rig", "rigs/eight.toml"]
ANSWERS = {
    "plan": [
        [*FROM, "--to", "0.15,0.15,1"],
        [*FROM, "--to", "0,0.4,1"],
        [*FROM, "--to", "0,0.4,1", "--planner", "exact"],
        [*FROM, "--to", "0.15,0.15,1", "--planner", "minimum-time"],
        [*FROM, "--to", "0,0.4,1", "--planner", "minimum-time", "--max-tension-rate", "1"],
        [*FROM, "--through", "0.1,0,1", "--to", "0.15,0.15,1"],
        [*FROM, "--through", "0.1,0,1", "--to", "0,0.4,1"],
        [*EIGHT, "--from", "0,0,2", "--to", "2.2,0.6,1.5"],
    ],
    "reach": [FROM, [*FROM, "--to", "0.15,0.15,1"], [*FROM, "--to", "0.05,0,1"]],
    "certify": [
        [*FROM, "--to", "0.1,0,1"],
        [*FROM, "--to", "0.3,0,1"],
        [*FROM, "--to", "0.1,0,1", "--force", "1e9"],
        [*EIGHT, "--from", "0,0,2", "--to", "1.8,1.4,1"],
    ],
    "workspace": [[], ["--height", "-1"], ["--heights", "-1,1,2"], [*EIGHT, "--orientation", "0,0,0", "--orientation", "0,0,0.2"]],
    "tensions": [[], ["--pose", "0.5,0,1"], [*EIGHT, "--distribution", "widest"]],
    "simulate": [
        ["--to", "0.1,0,1", "--duration", "1"],
        ["paper", "--sweep", "controller.lambda=3,5"],
        ["orbit"],
    ],
}


@pytest.fixture(scope="module", params=ANSWERS)
def kind(request):
    schema = json.loads(command("schema", request.param)[1])
    jsonschema.Draft202012Validator.check_schema(schema)
    return request.param, schema


def command(*arguments):
    """Exit code and stdout of `cable-robot`."""
    done = subprocess.run([ROOT / "target/debug/cable-robot", *arguments], cwd=ROOT, capture_output=True, text=True)
    return done.returncode, done.stdout


def answer(task, arguments):
    code, out = command(task, *arguments, "--json")
    assert code in (0, 3, 4), (task, arguments)
    return json.loads(out)


def test_real_answers_conform_and_bent_ones_do_not(kind):
    task, schema = kind
    validator = jsonschema.Draft202012Validator(schema)
    for arguments in ANSWERS[task]:
        found = answer(task, arguments)
        errors = [f"{list(error.absolute_path)}: {error.message}" for error in validator.iter_errors(found)]
        assert errors == [], (arguments, errors)
        first = found[0] if isinstance(found, list) else found
        for name in list(first):
            value = first.pop(name)
            assert not validator.is_valid(found), f"{task}: without {name}"
            first[name] = value
        first["unheardOf"] = 1
        assert not validator.is_valid(found), f"{task}: with a field that the schema does not name"


def test_every_field_says_what_it_is(kind):
    task, schema = kind
    fields = dict(described(schema, task))
    assert fields and [name for name, text in fields.items() if not text] == []


@pytest.mark.parametrize("scenario", ["paper", "orbit"])
def test_a_recorded_run_conforms_and_one_that_lacks_a_field_does_not(scenario, tmp_path):
    schema = json.loads(command("schema", "run")[1])
    validator = jsonschema.Draft202012Validator(schema)
    assert command("simulate", scenario, "--output", str(tmp_path))[0] == 0
    run = json.loads((tmp_path / "run.json").read_text())
    assert [error.message for error in validator.iter_errors(run)] == []
    for part in (run, run["controllerParameters"], run["plantParameters"]["rig"]):
        for name in set(part) - {"orbit"}:
            value = part.pop(name)
            assert not validator.is_valid(run), f"without {name}"
            part[name] = value
    fields = dict(described(schema, "run"))
    assert [name for name, text in fields.items() if not text] == []
