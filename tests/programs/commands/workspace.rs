//! `cable-robot workspace`.

use std::fs;

use serde_json::Value;

use super::program::{json, number, written};

#[test]
fn workspace_of_the_papers_rig_is_the_hexagon() {
    let found = json(0, &["workspace"]);
    let vertices = found["vertices"].as_array().unwrap();
    assert_eq!(vertices.len(), 6);
    for vertex in vertices {
        let radius = number(&vertex[0]).hypot(number(&vertex[1]));
        assert!((radius - 0.225 / 30f64.to_radians().cos()).abs() < 1e-7, "{vertex}");
    }
    // 6 triangles of height a/2.
    assert!((number(&found["area"]) - 6.0 * 0.225f64.powi(2) * 30f64.to_radians().tan()).abs() < 1e-7);
    assert!((number(&found["deepest"]["margin"]) - 10.7612).abs() < 0.01);

    let (text, err) = written(0, &["workspace", "--height", "0.7"]);
    assert!(
        text.contains("area 0.1754") && text.contains('█') && text.contains("-0.2598    0.0000"),
        "{text}"
    );
    assert!(err.is_empty(), "{err}");
}

#[test]
fn workspace_of_eight_cables_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.svg");
    let arguments = ["workspace", "--rig", "rigs/eight.toml", "--svg", path.to_str().unwrap()];
    let found = json(0, &arguments);
    assert!(number(&found["area"]) > 1.0 && number(&found["deepest"]["margin"]) > 5.0, "{found}");
    let svg = fs::read_to_string(path).unwrap();
    for cables in
        ["cables 1, 2", "cables 3, 4", "cables 5, 6", "cables 7, 8", "seen from below", "x (m)", "52.41 N"]
    {
        assert!(svg.contains(cables), "{cables}");
    }
}

#[test]
fn a_workspace_over_heights_and_orientations_is_a_panel_and_rows_each() {
    let folder = tempfile::tempdir().unwrap();
    let [svg, csv] = ["w.svg", "w.csv"].map(|name| folder.path().join(name));
    let arguments =
        ["workspace", "--heights", "-0.5,1,4", "--orientation", "0,0,0", "--orientation", "0,0.1,0"];
    let files = ["--svg", svg.to_str().unwrap(), "--csv", csv.to_str().unwrap()];
    let found = json(0, &[&arguments[..], &files].concat());
    let slices = found["slices"].as_array().unwrap();
    assert_eq!(slices.len(), 8);
    assert!(slices[..2].iter().all(|slice| slice["empty"] == true), "above the base");
    assert_eq!(slices[7]["orientation"][1], 0.1);
    assert_eq!(slices[6]["area"], json(0, &["workspace"])["area"]);
    assert!(slices[7]["area"] != slices[6]["area"]);

    let drawn = fs::read_to_string(svg).unwrap();
    assert!(["z = -0.5 m", "z = 1 m", "empty"].iter().all(|said| drawn.contains(said)));
    let mut rows = csv::Reader::from_path(csv).unwrap();
    assert_eq!(rows.headers().unwrap(), vec!["x", "y", "z", "roll", "pitch", "yaw", "margin"]);
    let rows: Vec<Vec<f64>> = rows.deserialize().map(Result::unwrap).collect();
    let inside =
        |z: f64, pitch: f64| rows.iter().filter(move |row| row[2] == z && row[4] == pitch && row[6] >= 0.0);
    let greatest = inside(1.0, 0.0).map(|row| row[6]).fold(0.0, f64::max);
    assert!((greatest - number(&slices[6]["deepest"]["margin"])).abs() < 1e-9, "{greatest}");
    assert!(inside(0.5, 0.1).count() > 100 && inside(-0.5, 0.0).count() == 0);

    let (text, _) = written(0, &arguments);
    assert_eq!(text.matches("empty").count(), 4, "{text}");
    for wrong in ["1,2", "1,2,1", "1,2,2.5", "1,2,101"] {
        assert!(written(2, &["workspace", "--heights", wrong]).1.contains("heights"), "{wrong}");
    }
}

#[test]
fn an_empty_workspace_is_a_result() {
    // Above the base every cable pulls down.
    let found = json(3, &["workspace", "--height", "-1"]);
    assert_eq!((&found["empty"], &found["deepest"]), (&Value::Bool(true), &Value::Null));
}

/// "Empty, cannot hold the platform anywhere", exit code 0: a solver's tolerance was taken for proof.
#[test]
fn a_greatest_tension_that_limits_nothing_does_not_empty_the_workspace() {
    let eight = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/eight.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let area = |max: &str| {
        let path = folder.path().join("rig.toml");
        let line = eight.lines().find(|line| line.starts_with("max = ")).unwrap();
        fs::write(&path, eight.replace(line, max).replace("rig.schema.json", "x")).unwrap();
        number(&json(0, &["workspace", "--rig", path.to_str().unwrap()])["area"])
    };
    let unlimited = area("");
    assert!((unlimited - 10.544).abs() < 1e-3, "{unlimited}");
    for max in ["max = inf", "max = 1e8", "max = 1e13"] {
        assert!((area(max) - unlimited).abs() < 1e-6 * unlimited, "{max}: {}", area(max));
    }
}
