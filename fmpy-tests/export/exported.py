"""`cable-robot export`, read by others: mcap of Foxglove and pyarrow of Apache Arrow. `cargo verify --all` builds the command and runs this."""

import csv
import json
import subprocess
from collections import defaultdict
from pathlib import Path

import jsonschema
import pyarrow.parquet
import pytest
from mcap.reader import make_reader

ROOT = Path(__file__).resolve().parents[2]
CABLE_ROBOT = ROOT / "target" / "debug" / "cable-robot"

# What https://docs.foxglove.dev/docs/sdk/schemas requires of a message, by the schema's name.
REQUIRED = {
    "foxglove.FrameTransform": "timestamp parent_frame_id child_frame_id translation rotation",
    "foxglove.PoseInFrame": "timestamp frame_id pose",
    "foxglove.SceneUpdate": "deletions entities",
    "foxglove.Log": "timestamp level message name file line",
}
REQUIRED_ENTITY = (
    "timestamp frame_id id lifetime frame_locked metadata arrows cubes spheres cylinders lines triangles texts models"
)
REQUIRED_LINE = "type pose thickness scale_invariant points color colors indices"
EVENTS = [("0.0", "state", "Enabled"), ("0.5", "refused", "goal (9, 0, 1) m"), ("2.5", "fault", "an encoder is silent")]


def cable_robot(*arguments):
    return subprocess.run([CABLE_ROBOT, *map(str, arguments)], capture_output=True, text=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run, with the events of a rig beside it."""
    folder = tmp_path_factory.mktemp("export") / "run"
    done = cable_robot("simulate", "--to", "0.15,0.15,1", "--duration", "2", "--output", folder)
    assert done.returncode == 0, done.stderr
    with open(folder / "events.csv", "w", newline="") as file:
        csv.writer(file).writerows([("time", "kind", "text"), *EVENTS])
    for name in ["run", "again"]:
        paths = [folder / f"{name}.{kind}" for kind in ("mcap", "parquet")]
        done = cable_robot("export", folder, "--mcap", paths[0], "--parquet", paths[1], "--json")
        assert json.loads(done.stdout) == {"mcap": str(paths[0]), "parquet": str(paths[1]), "rows": 2001}, done.stderr
    return folder


@pytest.fixture(scope="module")
def rows(folder):
    with open(folder / "run.csv") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


@pytest.fixture(scope="module")
def topics(folder):
    """Time in ns, schema and message, by topic."""
    topics = defaultdict(list)
    with open(folder / "run.mcap", "rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            topics[channel.topic].append((message.log_time, schema, json.loads(message.data)))
    return topics


def flat(prefix, value):
    """A message's numbers by the names of the columns."""
    if isinstance(value, dict):
        return {name: number for key, part in value.items() for name, number in flat(f"{prefix}.{key}", part).items()}
    if isinstance(value, list):
        return {f"{prefix}[{i}]": number for i, number in enumerate(value, 1)}
    return {prefix: value}


def test_every_number_of_a_row_is_in_its_messages_to_the_bit(rows, topics):
    assert set(topics) == set("/plant /controller /world /platform /outlines /cables /goal /set_point /events".split())
    assert len(rows) == len(topics["/plant"]) == len(topics["/controller"])
    for row, plant, controller in zip(rows, topics["/plant"], topics["/controller"]):
        assert plant[0] == controller[0] == round(row["time"] * 1e9)
        numbers = flat("plant", plant[2]) | flat("controller", controller[2])
        assert numbers.pop("plant.time") == numbers.pop("controller.time") == row["time"]
        assert numbers == {name: value for name, value in row.items() if name != "time"}


def test_messages_are_as_their_schemas_and_foxglove_want_them(topics):
    for messages in topics.values():
        for _, schema, message in messages[:: max(1, len(messages) // 50)]:
            jsonschema.validate(message, json.loads(schema.data), jsonschema.Draft7Validator)
            if schema.name in REQUIRED:
                assert set(message) == set(REQUIRED[schema.name].split())
            for entity in message.get("entities", []):
                assert set(entity) == set(REQUIRED_ENTITY.split())
                assert all(set(line) == set(REQUIRED_LINE.split()) for line in entity["lines"])


def test_events_are_messages_in_the_order_of_time(topics):
    said = [(time, message["level"], message["message"]) for time, _, message in topics["/events"]]
    levels = {"state": 2, "refused": 3, "fault": 4}
    assert said == [(int(float(time) * 1e9), levels[kind], f"{kind}: {text}") for time, kind, text in EVENTS]


def test_what_was_run_comes_along(folder):
    with open(folder / "run.mcap", "rb") as file:
        reader = make_reader(file)
        [attachment] = reader.iter_attachments()
        [metadata] = reader.iter_metadata()
    assert (attachment.name, attachment.data) == ("run.json", (folder / "run.json").read_bytes())
    assert metadata.metadata["title"] == json.loads(attachment.data)["title"]


def test_parquet_has_every_number_with_its_unit(folder, rows):
    file = pyarrow.parquet.ParquetFile(folder / "run.parquet")
    table = file.read()
    assert table.column_names == list(rows[0])
    for name in table.column_names:
        assert table[name].to_pylist() == [row[name] for row in rows]
    metadata = file.metadata.metadata
    units = json.loads(metadata[b"units"])
    assert (units["time"], units["plant.measuredTension[6]"], units["plant.encoderPose.yaw"]) == ("s", "N", "rad")
    assert metadata[b"run.json"] == (folder / "run.json").read_bytes()


@pytest.mark.parametrize("kind", ["mcap", "parquet"])
def test_two_processes_write_the_same_bytes(folder, kind):
    assert (folder / f"run.{kind}").read_bytes() == (folder / f"again.{kind}").read_bytes()


def test_a_format_is_needed_and_a_folder_that_is_no_run_is_named(tmp_path):
    assert cable_robot("export", tmp_path).returncode == 2
    done = cable_robot("export", tmp_path, "--mcap", tmp_path / "run.mcap")
    assert done.returncode == 1 and f"cannot read {tmp_path}/run.json" in done.stderr
    assert not (tmp_path / "run.mcap").exists()
