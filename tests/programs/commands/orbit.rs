//! `cable-robot orbit`, and the scenario with an orbit on the plant that is an FMU.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use cable_robot_report::{RunFolder, Table};
use serde_json::Value;

use super::program::{number, written};

/// The answer of `orbit` with these options.
fn answer(code: i32, options: &str) -> Value {
    let words = options.split_whitespace();
    let (out, _) = written(code, &["orbit"].into_iter().chain(words).chain(["--json"]).collect::<Vec<_>>());
    serde_json::from_str(&out).unwrap()
}

const CIRCLE: &str = "--radius 0.4 --rate 2.75 --start 2.5";

#[test]
fn a_circle_outside_is_proved_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("orbit.svg");
    let found = answer(0, &format!("{CIRCLE} --svg {}", picture.display()));
    assert_eq!(found["proved"], true);
    assert!((number(&found["outside"]["farthest"]) - 0.175).abs() < 1e-4);
    assert!((number(&found["outside"]["margin"]) + 10.016).abs() < 1e-3);
    let [proved, sampled] = [&found["proof"]["least"], &found["smallestTension"]["tension"]].map(number);
    assert!(0.9 < proved && proved < sampled && number(&found["proof"]["longestToRest"]) < 2.7);
    let drawn = fs::read_to_string(picture).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("outside") && drawn.contains("tension (N)"));
    let (text, _) = written(0, &["orbit", "--radius", "0.4", "--rate", "2.75", "--start", "2.5"]);
    assert!(text.contains("up to 0.1750 m, where a tension at rest would be 10.016 N beyond"), "{text}");
}

#[test]
fn what_is_refused_names_the_cable_and_what_would_do() {
    let large = answer(3, "--radius 1.2 --rate 2.75 --start 2.5");
    let refusal = &large["refusal"];
    assert!(refusal["part"] == "full" && refusal["cable"].is_u64() && number(&refusal["tension"]) < -2.0);
    let radius = number(&large["instead"]["radius"]);
    assert!((0.4..1.0).contains(&radius));
    assert_eq!(answer(0, &format!("--radius {radius} --rate 2.75 --start 2.5"))["proved"], true);

    let short = answer(3, "--radius 0.4 --start 0.5");
    assert_eq!(short["refusal"]["part"], "start");
    let start = number(&short["instead"]["start"]);
    assert!(start < 2.5 && answer(0, &format!("--radius 0.4 --start {start}"))["proved"] == true);
    let (text, _) = written(3, &["orbit", "--radius", "0.4", "--start", "0.5"]);
    assert!(
        text.contains("not proved: the start: cable ") && text.contains("proved with a start of"),
        "{text}"
    );
}

#[test]
fn a_place_outside_is_passed_through() {
    let found = answer(0, "--through 0,0.325");
    assert!((number(&found["outside"]["farthest"]) - 0.1).abs() < 1e-4);
    assert!(number(&found["duration"]) < 2.7 && found["turns"] == 0.0, "{found}");
}

#[test]
fn every_shape_and_eight_cables() {
    for options in ["--shape line --radius 0.4 --direction 1.5708", "--shape hypotrochoid --radius 0.25"] {
        assert!(number(&answer(0, options)["outside"]["farthest"]) > 0.03);
    }
    assert_eq!(answer(0, "--rig rigs/eight.toml --radius 2.5 --start 11")["proved"], true);
    let refused = answer(3, "--rig rigs/eight.toml --radius 3.5 --start 11");
    let said = refused["refusal"]["inWords"].as_str().unwrap();
    assert!(said.contains("would have to pull less"), "{said}");
}

#[test]
fn what_makes_no_sense_is_named() {
    for (code, options, said) in [
        (1, "--radius 0", "radius = 0 is not allowed"),
        (1, "--radius -0.4", "radius = -0.4 is not allowed"),
        (2, "--radius NaN", "--radius <RADIUS>': NaN is not a finite number"),
        (1, "--radius 0.4 --rate 0", "rate = 0 is not allowed"),
        (2, "--radius 0.4 --rate inf", "--rate <RATE>': inf is not a finite number"),
        (1, "--radius 0.4 --turns 0", "turns = 0 is not allowed"),
        (1, "--radius 0.4 --turns -1", "turns = -1 is not allowed"),
        (1, "--radius 0.4 --start 0", "start = 0 is not allowed"),
        (1, "--radius 0.4 --start -2", "start = -2 is not allowed"),
        (1, "--radius 0.4 --step 1", "step = 1 is not allowed"),
        (1, "--radius 0.4 --lobes 4", "--lobes: this shape has none"),
        (1, "--shape hypotrochoid --radius 0.2 --lobes 1", "lobes = 1 is not allowed"),
        (1, "--through 0,0", "--through 0,0: that is the centre"),
        (2, "--through 0.3", "1 numbers given; a place is x,y"),
        (1, "--radius 0.1 --from 0.5,0,1", "--from (0.5, 0, 1"),
        (1, "--radius 0.1 --height -1", "--height: z = -1"),
        (2, "", "--radius <RADIUS>"),
    ] {
        let (out, error) =
            written(code, &["orbit"].into_iter().chain(options.split_whitespace()).collect::<Vec<_>>());
        assert!(out.is_empty() && error.contains(said), "{options}: {error}");
    }
}

fn fmu(version: &str, model: &str) -> PathBuf {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .join(format!("target/fmu/{version}/{model}.fmu"));
    assert!(path.is_file(), "{} is missing: run `cargo fmu build` first", path.display());
    path
}

/// The table of a run that must end well.
fn recorded(scenario: &str, fmu: Option<&Path>) -> Table {
    let folder = tempfile::tempdir().unwrap();
    let plant = fmu.map_or(vec![], |path| vec!["--fmu", path.to_str().unwrap()]);
    let output = ["simulate", scenario, "--output", folder.path().to_str().unwrap()];
    let (_, said) = written(0, &[&output[..], &plant].concat());
    assert!(said.contains("slack cables: none") && said.contains("AtGoal"), "{said}");
    RunFolder::read(folder.path()).unwrap().table
}

fn smallest(table: &Table) -> f64 {
    let column = |i: usize| table.get(&format!("plant.measuredTension[{i}]")).unwrap();
    (1..=6).flat_map(|i| column(i).iter().copied()).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_plant_may_be_an_fmu_and_changes_no_bit() {
    let library = recorded("orbit", None);
    assert!(smallest(&library) > 0.9, "{}", smallest(&library));
    for version in ["fmi2", "fmi3"] {
        assert!(recorded("orbit", Some(&fmu(version, "CableRobotPlant"))) == library, "{version}");
    }
    let controller = fmu("fmi3", "CableRobotController");
    let (_, error) = written(1, &["simulate", "orbit", "--fmu", controller.to_str().unwrap()]);
    assert!(error.contains("follows no orbit"), "{error}");
}

/// On the way up, where it costs most, and at full size.
#[test]
fn a_push_of_1_n_in_the_worst_of_12_directions_slackens_no_cable_of_the_plant_fmu() {
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/orbit.toml")).unwrap();
    let plant = fmu("fmi3", "CableRobotPlant");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pushed.toml");
    for begin in [1.0, 6.0] {
        let pushed = (0..12).map(|k| {
            let (y, x) = (TAU * f64::from(k) / 12.0).sin_cos();
            let push = text
                .replace("from = 6.0 ", &format!("from = {begin:?} "))
                .replace("until = 6.2", &format!("until = {:?}", begin + 0.2))
                .replace("force = [1.0, 0.0, 0.0]", &format!("force = [{x:?}, {y:?}, 0.0]"));
            fs::write(&path, push).unwrap();
            smallest(&recorded(path.to_str().unwrap(), Some(&plant)))
        });
        let worst = pushed.fold(f64::INFINITY, f64::min);
        println!("pushed at {begin} s: {worst:.3} N");
        assert!(worst > 0.9, "{worst}");
    }
}

#[test]
fn a_scenario_with_an_orbit_that_makes_no_sense_is_refused_at_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my.toml");
    let refused = |orbit: &str, rest: &str| {
        let text = format!("title = \"t\"\nduration = 9\n[orbit]\nshape = \"circle\"\n{orbit}\n{rest}");
        fs::write(&path, text).unwrap();
        written(1, &["simulate", path.to_str().unwrap()]).1
    };
    for (orbit, rest, said) in [
        ("radius = 0\nstart = 2", "", "line 5: orbit.radius = 0 is not allowed"),
        ("radius = 0.4\nstart = -1", "", "line 6: orbit.start = -1 is not allowed"),
        ("radius = 0.4\nstart = 2\nrate = nan", "", "line 7: orbit.rate = NaN is not allowed"),
        ("radius = 0.4\nstart = 2\nturns = 0", "", "line 7: orbit.turns = 0 is not allowed"),
        ("radius = 0.4\nstart = 2\nlobes = 3", "", "line 7: orbit.lobes = given is not allowed"),
        ("radius = 0.4\nstart = 0.5", "", "the start: cable "),
        ("radius = 1.2\nrate = 2.75\nstart = 2.5", "", "at full size: cable "),
        (
            "radius = 0.4\nstart = 3",
            "[controller]\nplanner = \"exact\"",
            "controller.planner = given is not allowed",
        ),
        ("radius = 0.4\nstart = 3", "[[goals]]\ntime = 1\npose = [0,0,1]", "goals = given is not allowed"),
    ] {
        let error = refused(orbit, rest);
        assert!(error.contains(said), "{orbit}: {error}");
    }
}

#[test]
fn what_the_page_of_orbits_shows_is_so() {
    let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/orbit.md")).unwrap();
    let shown: Vec<_> = page.split("```\n$ cable-robot ").skip(1).collect();
    assert_eq!(shown.len(), 2);
    let folder = tempfile::tempdir().unwrap();
    for (block, code) in shown.into_iter().zip([0, 3]) {
        let (command, rest) = block.split_once('\n').unwrap();
        let picture = folder.path().join("orbit.svg");
        let command = command.replace("orbit.svg", picture.to_str().unwrap());
        let (out, _) = written(code, &command.split_whitespace().collect::<Vec<_>>());
        assert_eq!(out, rest.split("```").next().unwrap());
        if code == 0 {
            let drawn = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/figures/orbit.svg");
            assert!(fs::read(picture).unwrap() == fs::read(drawn).unwrap(), "docs/figures/orbit.svg is old");
        }
    }
    let (text, _) = written(0, &["orbit", "--through", "0,0.325"]);
    assert!(
        text.contains(" 2.602 s from rest to rest") && page.contains("2.602 s from rest to rest"),
        "{text}"
    );
}
