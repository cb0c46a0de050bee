"""The schema of rig files as an editor applies it: what the program takes conforms, what it refuses does not."""

import copy
import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

RIGS = Path(__file__).resolve().parent.parent / "rigs"
SCHEMA = json.loads((RIGS / "rig.schema.json").read_text(encoding="utf-8"))
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def read(path: Path) -> dict:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("path", sorted(RIGS.glob("*.toml")), ids=lambda path: path.name)
def test_the_bundled_rigs_conform_and_name_the_schema(path):
    VALIDATOR.validate(read(path))
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("#:schema ") and (path.parent / first.split(" ", 1)[1]).exists()


OPTIONAL = {"frame", "center_of_mass", "inertia_off_diagonal", "accuracy", "max", "min_tension", "max_tension", "pulley"}


def test_what_may_be_left_out_may_and_nothing_else():
    rig = read(RIGS / "eight.toml")
    for table in (rig, rig["platform"], rig["tension"], rig["gains"], rig["cables"][3]):
        for field in list(table):
            value = table.pop(field)
            missing = [str(error.message) for error in VALIDATOR.iter_errors(rig)]
            assert missing == [] if field in OPTIONAL else field in missing[0], field
            table[field] = value


@pytest.mark.parametrize(
    "place, value",
    [
        (("gravity",), 0.0),
        (("gravity",), "9.81"),
        (("home",), [0.0, 1.0]),
        (("home",), [0.0, 0.0, 1.0, 0.0]),
        (("platform", "mass"), -6.0),
        (("platform", "inertia"), [0.1, 0.0, 0.1]),
        (("platform", "weight"), 6.0),
        (("tension", "min"), -1.0),
        (("tension", "max"), 0.0),
        (("gains", "eta"), 0.0),
        (("cables", 2, "anchor"), [0.0, 0.0, "down"]),
        (("cables", 2, "length"), 1.0),
        (("cables",), []),
    ],
)
def test_a_malformed_rig_does_not_conform_and_the_place_is_named(place, value):
    rig = copy.deepcopy(read(RIGS / "paper.toml"))
    table = rig
    for key in place[:-1]:
        table = table[key]
    table[place[-1]] = value
    errors = list(VALIDATOR.iter_errors(rig))
    assert len(errors) == 1
    found = list(errors[0].absolute_path)
    assert found[: len(place)] == list(place) or (found == list(place[:-1]) and str(place[-1]) in errors[0].message)


def test_five_cables_are_too_few():
    rig = read(RIGS / "paper.toml")
    del rig["cables"][5]
    assert not VALIDATOR.is_valid(rig)
