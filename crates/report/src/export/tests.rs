use std::collections::BTreeMap;
use std::fs::{self, read};

use ::mcap::{MessageStream, Summary};
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::RowAccessor;
use serde_json::Value;
use tempfile::TempDir;

use super::*;
use crate::RunFolder;
use crate::events::EVENTS_CSV;
use crate::run_folder::RUN_CSV;
use crate::tests::run;
use cable_robot::plan::PlannerKind;

/// Two tenths of a second in 201 rows.
fn recorded() -> (TempDir, RunFolder) {
    let folder = tempfile::tempdir().unwrap();
    let run = run(PlannerKind::Exact, 0.2, 0.01);
    run.write(folder.path()).unwrap();
    (folder, run)
}

/// The messages of each topic with their times, ns.
fn messages(folder: &Path) -> BTreeMap<String, Vec<(u64, Value)>> {
    let file = folder.join("run.mcap");
    mcap(folder, &file, |file| file).unwrap();
    let mut topics: BTreeMap<String, Vec<(u64, Value)>> = BTreeMap::new();
    for message in MessageStream::new(&read(file).unwrap()).unwrap() {
        let message = message.unwrap();
        let value = serde_json::from_slice(&message.data).unwrap();
        topics.entry(message.channel.topic.clone()).or_default().push((message.log_time, value));
    }
    topics
}

/// serde_json reads a number but for its last bit; `fmpy-tests/export` compares all bits.
fn assert_read(value: &Value, told: f64) {
    let read = value.as_f64().unwrap();
    assert!((read - told).abs() <= f64::EPSILON * told.abs(), "{read} {told}");
}

#[test]
fn every_number_of_a_run_is_in_its_mcap() {
    let (folder, run) = recorded();
    let topics = messages(folder.path());
    let (plant, controller) = (&topics["/plant"], &topics["/controller"]);
    assert_eq!((plant.len(), controller.len()), (201, 201));
    for (row, time) in run.table.column("time").unwrap().iter().enumerate() {
        assert_eq!(plant[row].0, 1_000_000 * row as u64);
        assert_read(&plant[row].1["time"], *time);
        let column = |name: &str| run.table.column(name).unwrap()[row];
        assert_read(&plant[row].1["measuredTension"][5], column("plant.measuredTension[6]"));
        assert_read(&controller[row].1["setPoint"]["x"], column("controller.setPoint.x"));
        assert_read(&controller[row].1["status"], column("controller.status"));
        assert_eq!(plant[row].1["slack"][0], Value::Bool(column("plant.slack[1]") != 0.0));
    }
    let numbers = |value: &Value| value.to_string().matches([':', ',']).count();
    assert!(numbers(&plant[0].1) + numbers(&controller[0].1) > run.table.names().len());
}

#[test]
fn the_robot_is_drawn_a_hundred_times_a_second_where_it_is() {
    let (folder, run) = recorded();
    let topics = messages(folder.path());
    let (platform, cables) = (&topics["/platform"], &topics["/cables"]);
    assert_eq!(
        (platform.len(), cables.len(), topics["/outlines"].len(), topics["/world"].len()),
        (21, 21, 1, 1)
    );
    let (time, last) = &platform[20];
    let (x, row) = (run.table.column("plant.encoderPose.x").unwrap(), (time / 1_000_000) as usize);
    assert_eq!(row, 200);
    assert_read(&last["translation"]["x"], x[row]);
    // A cable is as long as the plant says.
    let points = cables[20].1["entities"][0]["lines"][0]["points"].as_array().unwrap();
    let end = |k: usize| ["x", "y", "z"].map(|axis| points[k][axis].as_f64().unwrap());
    for i in 0..6 {
        let [from, to] = [end(2 * i), end(2 * i + 1)];
        let length = (0..3).map(|k| (from[k] - to[k]).powi(2)).sum::<f64>().sqrt();
        let told = run.table.column(&format!("plant.cableLength[{}]", i + 1)).unwrap()[row];
        assert!((length - told).abs() < 1e-9, "{length} {told}");
    }
}

/// Seen from above, the frame's z points down; a viewer's points up.
#[test]
fn gravity_points_down_in_the_world() {
    let (folder, _) = recorded();
    let turn = &messages(folder.path())["/world"][0].1["rotation"];
    let [x, y, z, w] = ["x", "y", "z", "w"].map(|k| turn[k].as_f64().unwrap());
    let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    assert!((turn * nalgebra::Vector3::z() + nalgebra::Vector3::z()).norm() < 1e-12, "{turn}");
}

#[test]
fn a_slack_cable_is_red_and_others_follow_the_tension() {
    let (folder, run) = recorded();
    let text = fs::read_to_string(folder.path().join(RUN_CSV)).unwrap();
    let place = run.table.names().iter().position(|name| name == "plant.slack[2]").unwrap();
    let mut rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    rows[1][place] = "1";
    let lines: Vec<_> = rows.iter().map(|row| row.join(",")).collect();
    fs::write(folder.path().join(RUN_CSV), lines.join("\n") + "\n").unwrap();
    let colours = &messages(folder.path())["/cables"][0].1["entities"][0]["lines"][0]["colors"];
    let share = |k: usize, name: &str| colours[k][name].as_f64().unwrap();
    assert_eq!(colours.as_array().unwrap().len(), 12);
    for end in [2, 3] {
        assert!(share(end, "r") > 0.9 && share(end, "g") < 0.2, "{colours}");
    }
    assert!((0..12).filter(|k| ![2, 3].contains(k)).all(|k| share(k, "g") > 0.4), "{colours}");
}

#[test]
fn what_happened_at_a_rig_is_a_log_in_order_of_time() {
    let (folder, _) = recorded();
    let events = "time,kind,text\n0,state,Enabled\n0.1,refused,too far\n0.3,fault,an encoder is silent\n";
    fs::write(folder.path().join(EVENTS_CSV), events).unwrap();
    let topics = messages(folder.path());
    let said: Vec<_> = topics["/events"]
        .iter()
        .map(|(time, log)| (*time, log["level"].as_u64().unwrap(), log["message"].as_str().unwrap()))
        .collect();
    let bytes = read(folder.path().join("run.mcap")).unwrap();
    let times: Vec<_> =
        MessageStream::new(&bytes).unwrap().map(|message| message.unwrap().log_time).collect();
    assert!(times.is_sorted(), "an event stands where it happened");
    let refused = (100_000_000, 3, "refused: too far");
    assert_eq!(said, [(0, 2, "state: Enabled"), refused, (300_000_000, 4, "fault: an encoder is silent")]);
}

/// Whatever Foxglove cannot resolve is not in a schema: it reads objects, arrays and plain types only.
#[test]
fn schemas_say_units_and_refer_to_nothing() {
    let (folder, _) = recorded();
    messages(folder.path());
    let bytes = read(folder.path().join("run.mcap")).unwrap();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let schemas: BTreeMap<_, Value> = summary
        .schemas
        .values()
        .map(|schema| (schema.name.as_str(), serde_json::from_slice(&schema.data).unwrap()))
        .collect();
    assert_eq!(schemas.len(), 5, "{:?}", schemas.keys());
    schemas.values().for_each(plain);
    let plant = &schemas["cable_robot.plant"]["properties"];
    let said = plant["measuredTension"]["description"].as_str().unwrap();
    assert!(said.contains(", N") && said.ends_with("; item 0 is cable 1"), "{said}");
    let said = plant["encoderPose"]["properties"]["yaw"]["description"].as_str().unwrap();
    assert!(said.contains(", rad"), "{said}");
    let status = schemas["cable_robot.controller"]["properties"]["status"]["description"].as_str().unwrap();
    assert!(status.contains("2 Holding"), "{status}");
}

fn plain(schema: &Value) {
    match schema["type"].as_str() {
        Some("object") => schema["properties"].as_object().unwrap().values().for_each(plain),
        Some("array") => plain(&schema["items"]),
        Some("number" | "integer" | "boolean" | "string") => {}
        _ => panic!("{schema}"),
    }
}

#[test]
fn parquet_has_the_numbers_of_the_csv_to_the_bit() {
    let (folder, run) = recorded();
    let path = folder.path().join("run.parquet");
    assert_eq!(parquet(folder.path(), &path, |file| file).unwrap(), 201);
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let metadata = reader.metadata().file_metadata();
    let names: Vec<_> =
        metadata.schema_descr().columns().iter().map(|column| column.name().to_owned()).collect();
    assert_eq!(names, run.table.names());
    let pairs = metadata.key_value_metadata().unwrap();
    let value = |key: &str| pairs.iter().find(|pair| pair.key == key).unwrap().value.clone().unwrap();
    let units: Value = serde_json::from_str(&value("units")).unwrap();
    assert_eq!((&units["time"], &units["plant.encoderPose.yaw"]), (&"s".into(), &"rad".into()));
    assert_eq!(value("run.json"), fs::read_to_string(folder.path().join("run.json")).unwrap());
    for (row, read) in reader.get_row_iter(None).unwrap().map(Result::unwrap).enumerate() {
        for (k, name) in names.iter().enumerate() {
            let told = run.table.column(name).unwrap()[row];
            assert_eq!(read.get_double(k).unwrap().to_bits(), told.to_bits(), "{name}");
        }
    }
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let (folder, _) = recorded();
    let file = |name: &str| folder.path().join(name);
    for name in ["first", "second"] {
        mcap(folder.path(), &file(&format!("{name}.mcap")), |file| file).unwrap();
        parquet(folder.path(), &file(&format!("{name}.parquet")), |file| file).unwrap();
    }
    for kind in ["mcap", "parquet"] {
        let [first, second] = ["first", "second"].map(|name| read(file(&format!("{name}.{kind}"))).unwrap());
        assert!(first == second, "{kind}");
    }
}

#[test]
fn a_run_that_cannot_be_read_leaves_the_old_file_and_is_named() {
    let (folder, _) = recorded();
    let (csv, file) = (folder.path().join(RUN_CSV), folder.path().join("run.mcap"));
    fs::write(&file, "old").unwrap();
    let text = fs::read_to_string(&csv).unwrap();
    let refused = |text: &str| {
        fs::write(&csv, text).unwrap();
        let error = mcap(folder.path(), &file, |file| file).unwrap_err().to_string();
        assert_eq!(fs::read(&file).unwrap(), b"old");
        error
    };
    let said = refused(&text.replacen("\n0.001,", "\nsoon,", 1));
    assert!(said.contains("run.csv: line 3, column 1 (time): \"soon\""), "{said}");
    let said = refused(&text.replacen("\n0.0,", "\n-0.5,", 1));
    assert!(said.ends_with("run.csv: time = -0.5 s is not allowed: MCAP knows no time before 0"), "{said}");
    let said = refused(&text.replace("plant.encoderPose.yaw", "yaw"));
    assert!(said.contains("no column \"plant.encoderPose.yaw\""), "{said}");
}
