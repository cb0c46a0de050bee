//! The bundled scenarios show what they say, and `cable-robot simulate` as a user runs it.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use cable_robot::plan::{ControllerParameters, Status};
use cable_robot::robot::Pose;
use cable_robot::sim::scenario::count_steps;
use cable_robot::sim::{BUNDLED, Moment, Scenario, ScenarioFile, Simulation};
use cable_robot_report::run_folder::Model;
use cable_robot_report::{Recording, Run, RunFolder};

use super::program;

const FMU_VERSIONS: [&str; 2] = ["fmi2", "fmi3"];

fn bundled(name: &str) -> Scenario {
    let (_, text) = BUNDLED.into_iter().find(|(known, _)| *known == name).expect("bundled");
    let file = ScenarioFile::parse(text).unwrap();
    file.scenario("Table I", Pose::default(), ControllerParameters::default()).unwrap()
}

/// Every moment of the scenario.
fn moments(scenario: &Scenario) -> Vec<Moment> {
    let mut simulation = Simulation::new(scenario).unwrap();
    let mut moments = vec![*simulation.moment()];
    for _ in 0..count_steps(scenario.duration, scenario.step).unwrap() {
        simulation.step().unwrap();
        moments.push(*simulation.moment());
    }
    moments
}

fn at(moments: &[Moment], time: f64) -> &Moment {
    moments.iter().find(|moment| moment.time > time - 1e-6).expect("within the run")
}

fn never_slack(moments: &[Moment]) -> bool {
    moments.iter().all(|moment| moment.plant.slack == [false; 6])
}

/// What a simulation that must end with `code` wrote to stdout and stderr.
fn written(code: i32, arguments: &[&str]) -> (String, String) {
    program::written(code, &[&["simulate"], arguments].concat())
}

/// The run folder that a simulation which must end well wrote.
fn recorded(arguments: &[&str]) -> RunFolder {
    let folder = tempfile::tempdir().unwrap();
    written(0, &[arguments, &["--output", folder.path().to_str().unwrap()]].concat());
    RunFolder::read(folder.path()).unwrap()
}

#[test]
fn paper_takes_four_set_points_and_cable_5_ends_near_nothing() {
    let moments = moments(&bundled("paper"));
    let last = moments.last().unwrap();
    assert_eq!((last.controller.set_point_index, last.controller.status), (4, Status::AtGoal));
    assert!(never_slack(&moments) && (last.plant.measured_tension[4] - 1.05).abs() < 5e-3);
}

#[test]
fn experiment_needs_the_force_loop() {
    let closed = bundled("experiment");
    let with = moments(&closed);
    assert!(with.iter().any(|moment| moment.controller.at_goal) && never_slack(&with));
    let mut open = closed;
    open.controller.force_loop = false;
    let without = moments(&open);
    let last = without.last().unwrap();
    assert_eq!((last.controller.set_point_index, last.controller.steady), (1, false));
    let short = last.controller.set_point.0[0] - last.plant.encoder_pose.0[0];
    assert!((1e-3..3e-3).contains(&short), "stops {short} m short");
}

#[test]
fn tour_reaches_its_goals_at_all_heights_and_turns_round_on_the_way() {
    let scenario = bundled("tour");
    let moments = moments(&scenario);
    let reached = |from: f64, until: f64| {
        moments.iter().any(|moment| moment.time > from && moment.time <= until && moment.controller.at_goal)
    };
    let between = [(0.0, 3.0), (3.0, 4.0), (4.0, 8.0), (8.0, 12.0)].map(|(from, until)| reached(from, until));
    assert_eq!(between, [true, false, true, true]);
    assert!(never_slack(&moments));
    assert!(at(&moments, 4.01).controller.set_point.0[1] < -0.1, "the third goal is made for at once");
}

#[test]
fn fast_reaches_its_goals_within_a_second_each() {
    let moments = moments(&bundled("fast"));
    let reached = |from: f64, until: f64| {
        moments.iter().any(|moment| moment.time > from && moment.time <= until && moment.controller.at_goal)
    };
    let between = [(0.11, 1.0), (1.01, 2.0), (2.01, 2.3), (2.31, 3.5), (3.51, 4.5)]
        .map(|(from, until)| reached(from, until));
    assert_eq!(between, [true, true, false, true, true]);
    let commanded = moments.iter().flat_map(|moment| moment.controller.motor_tension);
    let least = commanded.fold(f64::INFINITY, f64::min);
    assert!(never_slack(&moments) && least > 0.55, "{least}");
}

#[test]
fn gust_passes_and_what_lasts_leaves_two_centimetres() {
    let moments = moments(&bundled("gust"));
    let place = |time: f64| at(&moments, time).plant.encoder_pose.0;
    assert!(place(0.9).fixed_rows::<2>(0).norm() < 1e-9);
    assert!(place(1.5)[0] > 0.02 && place(4.5)[5] > 0.02, "pushed, then turned");
    assert!(place(3.9).fixed_rows::<2>(0).norm() < 1e-3, "and back");
    assert!((place(9.9)[1] - 0.02).abs() < 2e-3);
}

#[test]
fn detour_is_taken_up_at_rest() {
    let moments = moments(&bundled("detour"));
    assert_eq!(at(&moments, 4.0).controller.set_point_index, 2, "the step under way is finished");
    let last = moments.last().unwrap();
    assert_eq!(
        (last.controller.status, last.controller.set_point),
        (Status::AtGoal, Pose::at(-0.1, 0.05, 1.0))
    );
    assert!(never_slack(&moments));
}

#[test]
fn unreachable_is_said_and_no_cable_goes_slack() {
    let moments = moments(&bundled("unreachable"));
    let last = moments.last().unwrap();
    assert_eq!(last.controller.status, Status::GoalUnreachable);
    assert!(never_slack(&moments) && last.plant.encoder_pose.0[1] < -0.2);
    let (_, summary) = written(3, &["unreachable", "--json"]);
    assert!(summary.contains("not reached by 12.000 s") && summary.contains("GoalUnreachable"), "{summary}");
}

#[test]
fn the_program_writes_what_the_library_computes() {
    let scenario = bundled("gust");
    let mut recording = Recording::new(6);
    moments(&scenario).iter().for_each(|moment| recording.push(moment).unwrap());
    let RunFolder { info, table } = recorded(&["gust"]);
    assert!(table == recording.into_table());
    assert_eq!((info.scenario.as_deref(), info.step), (Some("gust"), 1e-3));
    assert_eq!((info.controller_parameters, info.plant_parameters), (scenario.controller, scenario.plant));
    let (csv, _) = written(0, &["gust"]);
    let mut again = vec![];
    table.write_csv(&mut again).unwrap();
    assert!(csv.as_bytes() == again, "stdout is run.csv");
}

#[test]
fn a_scenario_file_finds_its_rig_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let rig = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    fs::write(folder.path().join("heavy.toml"), rig.replace("mass = 6.0", "mass = 7.0")).unwrap();
    let path = folder.path().join("mine.toml");
    fs::write(&path, "title = \"Mine\"\nrig = \"heavy.toml\"\nduration = 0.1").unwrap();
    let info = recorded(&[path.to_str().unwrap()]).info;
    assert_eq!((info.title.as_str(), info.plant_parameters.rig.mass), ("Mine", 7.0));

    fs::write(folder.path().join("heavy.toml"), rig.replace("mass = 6.0", "mass = 0")).unwrap();
    let (_, error) = written(1, &[path.to_str().unwrap()]);
    assert!(
        error.contains("mine.toml: ")
            && error.contains("heavy.toml: line ")
            && error.contains("platform.mass")
    );
    fs::write(&path, "title = \"Mine\"\nduration = -1").unwrap();
    let (out, error) = written(1, &[path.to_str().unwrap()]);
    assert!(out.is_empty() && error.contains("mine.toml: line 2: duration = -1 is not allowed"), "{error}");
    let (_, error) = written(1, &["no/such.toml"]);
    assert!(error.contains("no/such.toml") && error.contains("paper, experiment"), "{error}");
}

/// What is said of a scenario file in a folder with these other files.
fn refused(text: &str, others: &[(&str, &[u8])]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my.toml");
    fs::write(&path, text).unwrap();
    others.iter().for_each(|(name, content)| fs::write(folder.path().join(name), content).unwrap());
    let (out, error) = written(1, &[path.to_str().unwrap()]);
    assert!(out.is_empty() && error.contains("my.toml: "), "{error}");
    error
}

#[test]
fn a_rig_that_will_not_do_is_named_with_the_line_that_names_it() {
    let text = "title = \"t\"\nduration = 1\nrig = \"rig.toml\"\n";
    let rigs = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs");
    let [paper, eight] =
        ["paper", "eight"].map(|name| fs::read_to_string(format!("{rigs}/{name}.toml")).unwrap());
    let refused_rig = |rig: &[u8]| refused(text, &[("rig.toml", rig)]);
    let missing = refused(text, &[]);
    assert!(missing.contains("line 3: rig = \"rig.toml\": cannot read "), "{missing}");
    let few = refused_rig(
        eight
            .rsplit_once("[[cables]]")
            .unwrap()
            .0
            .rsplit_once("[[cables]]")
            .unwrap()
            .0
            .rsplit_once("[[cables]]")
            .unwrap()
            .0
            .as_bytes(),
    );
    assert!(few.contains("line 3: rig = \"rig.toml\": ") && few.contains("5 given, at least 6"), "{few}");
    let stiff = refused_rig(paper.replace("lambda = 3.0", "lambda = 1e9").as_bytes());
    let line = paper.lines().position(|line| line.starts_with("lambda")).unwrap() + 1;
    assert!(
        stiff.contains(&format!("rig.toml: line {line}: gains.lambda = 1000000000 is not allowed")),
        "{stiff}"
    );
    let binary = refused_rig(b"name = \"\xff\"");
    assert!(binary.contains("line 1: byte 8 (0xff) is not UTF-8"), "{binary}");
    let far = refused_rig(paper.replace("home = [0.0,", "home = [0.4,").as_bytes());
    assert!(far.contains("line 3: rig = \"rig.toml\": home (0.4, 0, 1"), "{far}");
    let tight = refused(
        &format!("start = [0, 0, 1]\n{text}[controller]\nmax_tension = 5.0"),
        &[("rig.toml", paper.as_bytes())],
    );
    assert!(tight.contains("line 1: start (0, 0, 1, 0, 0, 0): at rest there cable 1 pulls"), "{tight}");
}

#[test]
fn a_run_ends_before_a_value_that_is_not_finite() {
    let folder = tempfile::tempdir().unwrap();
    let [path, run] = ["my.toml", "run"].map(|name| folder.path().join(name));
    fs::write(&path, "title = \"t\"\nduration = 1\n[[disturbances]]\nfrom = 0.5\nforce = [0, 1e160, 0]")
        .unwrap();
    let (_, said) = written(1, &[path.to_str().unwrap(), "--output", run.to_str().unwrap()]);
    assert!(said.contains("the plant stopped at 0.5") && said.contains("no finite number"), "{said}");
    let rows = RunFolder::read(&run).unwrap().table.rows();
    assert!(rows > 500 && rows < 1001, "{rows}");
}

#[test]
fn the_list_names_every_scenario() {
    let (list, _) = written(0, &["--list"]);
    for (name, _) in BUNDLED {
        assert!(list.lines().any(|line| line.starts_with(name) && line.len() > 20), "{name}: {list}");
    }
    let (_, error) = written(2, &[]);
    assert!(error.contains("unreachable") && error.contains("--to"), "{error}");
    written(2, &["paper", "--to", "0,0,1"]);
}

#[test]
fn an_output_that_cannot_be_written_is_said_before_the_simulation() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let inside = file.path().join("run");
    for path in [file.path(), inside.as_path(), Path::new("run.csv"), Path::new("/dev/full")] {
        let (out, error) = written(1, &["paper", "--output", path.to_str().unwrap()]);
        assert!(out.is_empty() && error.contains(path.parent().unwrap().to_str().unwrap()), "{error}");
        assert!(!error.contains("set points"), "{error}");
    }
}

#[cfg(unix)]
#[test]
fn a_start_that_cannot_be_held_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pulled.toml");
    std::fs::write(&path, "title = \"x\"\nduration = 1.0\n[controller]\nmin_tension = 90.0\n").unwrap();
    let (_, error) = written(1, &[path.to_str().unwrap()]);
    assert!(error.contains("cable 1 pulls 10.761 N, beyond its limits of 90 to 100 N"), "{error}");
}

#[test]
fn a_turned_goal_is_told_with_its_angles() {
    let turn = ["--from", "0,0,1", "--to", "0,0,1,0,0,0.5", "--planner", "exact", "--json"];
    let (out, text) = written(0, &[&turn[..], &["--duration", "3"]].concat());
    assert!(text.contains("goal (0, 0, 1, 0, 0, 0.5)") && text.contains("roll (rad)"), "{text}");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["goals"][0]["angles"][2], 0.5);
    assert_eq!(summary["setPoints"][1]["angles"][2], 0.5);
}

#[test]
fn a_sensor_fault_at_the_end_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("thrown.toml");
    let thrown = "title = \"x\"\nduration = 1.0\n[[disturbances]]\nfrom = 0.1\nforce = [1e5, 0.0, 0.0]\n";
    std::fs::write(&path, thrown).unwrap();
    let (_, text) = written(3, &[path.to_str().unwrap()]);
    assert!(text.contains("SensorFault"), "{text}");
}

fn fmu(version: &str, model: &str) -> PathBuf {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .join(format!("target/fmu/{version}/{model}.fmu"));
    assert!(path.is_file(), "{} is missing: run `cargo fmu build` first", path.display());
    path
}

#[test]
fn our_own_fmus_in_place_of_the_library_change_no_bit() {
    let library = recorded(&["experiment"]);
    for version in FMU_VERSIONS {
        let [controller, plant] =
            ["CableRobotController", "CableRobotPlant"].map(|model| fmu(version, model));
        let [controller, plant] = [&controller, &plant].map(|path| path.to_str().unwrap());
        for arguments in [vec![controller], vec![plant], vec![plant, controller]] {
            let options = arguments.iter().flat_map(|path| ["--fmu", *path]);
            let found = recorded(&std::iter::once("experiment").chain(options).collect::<Vec<_>>());
            assert!(found.table == library.table, "{arguments:?}");
            let replaced = |model: &Model| matches!(model, Model::Fmu { .. });
            assert_eq!(replaced(&found.info.controller), arguments.contains(&controller));
            assert_eq!(replaced(&found.info.plant), arguments.contains(&plant));
        }
    }
}

/// A copy of our FMU whose description was edited.
fn edited(model: &str, edit: impl Fn(String) -> String) -> tempfile::NamedTempFile {
    let mut archive = zip::ZipArchive::new(fs::File::open(fmu("fmi3", model)).unwrap()).unwrap();
    let file = tempfile::Builder::new().suffix(".fmu").tempfile().unwrap();
    let mut copy = zip::ZipWriter::new(file.reopen().unwrap());
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).unwrap();
        let mut bytes = vec![];
        entry.read_to_end(&mut bytes).unwrap();
        let name = entry.name().unwrap().into_owned();
        if name == "modelDescription.xml" {
            bytes = edit(String::from_utf8(bytes).unwrap()).into_bytes();
        }
        copy.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        copy.write_all(&bytes).unwrap();
    }
    copy.finish().unwrap();
    file
}

/// The description without the variables whose names begin like this.
fn without(names: &'static [&'static str]) -> impl Fn(String) -> String {
    move |xml| {
        let named = |line: &&str| !names.iter().any(|name| line.contains(&format!(" name=\"{name}")));
        xml.lines().filter(named).collect::<Vec<_>>().join("\n")
    }
}

#[test]
fn an_fmu_that_tells_less_is_run_and_what_it_lacks_is_not_recorded() {
    let fmu = edited(
        "CableRobotController",
        without(&["setPoint.", "setPointIndex", "status", "atGoal", "lambda"]),
    );
    let whole = recorded(&["paper"]);
    let found = recorded(&["paper", "--fmu", fmu.path().to_str().unwrap()]);
    assert_eq!(found.table.names().len() + 10, whole.table.names().len());
    assert!(found.table.get("controller.setPoint.x").is_none());
    let column = "plant.encoderPose.x";
    assert_eq!(found.table.get(column), whole.table.get(column), "the loop is the same");
    let Run { set_point, at_goal, .. } = found.run().unwrap();
    assert_eq!((set_point[0][0], at_goal[0]), (0.15, 0.0), "the goal stands for the set point");
    let (_, said) = written(0, &["paper", "--json", "--fmu", fmu.path().to_str().unwrap()]);
    assert!(said.contains("not recorded: setPoint, setPointIndex, atGoal, status, statusNumber\n"), "{said}");
    for untold in ["status at the end", "set points", "not reached"] {
        assert!(!said.contains(untold), "{said}");
    }
}

#[test]
fn fmus_that_cannot_take_part_are_refused_with_the_reason() {
    let refused = |paths: &[&Path]| {
        let options = paths.iter().flat_map(|path| ["--fmu", path.to_str().unwrap()]);
        let (out, error) = written(1, &std::iter::once("paper").chain(options).collect::<Vec<_>>());
        assert!(out.is_empty() && !error.contains("set points"), "{error}");
        error
    };
    let controller = |names| edited("CableRobotController", without(names));
    let error = refused(&[controller(&["motorTension[6]"]).path()]);
    assert!(error.contains("a controller needs the output motorTension[6]"), "{error}");
    let error = refused(&[controller(&["motorTension"]).path()]);
    assert!(error.contains("is neither controller nor plant"), "{error}");
    let error = refused(&[edited("CableRobotPlant", without(&["encoderPose.z"])).path()]);
    assert!(error.contains("a plant needs the output encoderPose.z"), "{error}");
    let deaf = edited("CableRobotPlant", without(&["measuredTension"]));
    written(0, &["paper", "--json", "--fmu", deaf.path().to_str().unwrap()]);
    let (_, error) = written(1, &["experiment", "--fmu", deaf.path().to_str().unwrap()]);
    assert!(
        error.contains("a plant needs the output measuredTension[1]"),
        "the force loop reads it: {error}"
    );
    let plant = fmu("fmi3", "CableRobotPlant");
    assert!(refused(&[&plant, &fmu("fmi2", "CableRobotPlant")]).contains("stand for the same model"));
    let stranger =
        edited("CableRobotPlant", |xml| xml.replace("instantiationToken=\"", "instantiationToken=\"x"));
    let error = refused(&[stranger.path()]);
    assert!(error.contains("could not be instantiated"), "{error}");
    assert!(refused(&[Path::new("no/such.fmu")]).contains("no/such.fmu cannot be opened as an FMU"));
}

#[test]
fn what_the_page_shows_is_so() {
    let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/scenarios.md")).unwrap();
    let blocks: Vec<_> = page.split("```").collect();
    let [list, example] = [blocks[1], blocks[3]];
    let shown = list.strip_prefix("\n$ cable-robot simulate --list\n").unwrap();
    assert_eq!(written(0, &["--list"]).0, shown);
    let file = ScenarioFile::parse(example.strip_prefix("toml\n").unwrap()).unwrap();
    let base = ControllerParameters::default();
    let scenario = file.scenario("", Pose::default(), base).unwrap();
    assert_eq!(
        scenario.controller,
        ControllerParameters { force_loop: true, ..base },
        "the defaults it names"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my.toml");
    let refusal = page.lines().find_map(|line| line.strip_prefix("    cable-robot: my.toml: ")).unwrap();
    fs::write(&path, "title = \"t\"\nduration = 1\n\n\n\n\n[[goals]]\ntime = 0\npose = [0, 0, -1]").unwrap();
    let (_, error) = written(1, &[path.to_str().unwrap()]);
    assert!(error.trim_end().ends_with(refusal), "{error}");
}

#[test]
fn fields_set_on_the_command_line_are_as_if_the_file_said_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("quick.toml");
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/paper.toml")).unwrap();
    let mut file: toml::Table = toml::from_str(&text).unwrap();
    file.insert("duration".into(), toml::Value::Float(2.0));
    let controller = file.entry("controller").or_insert_with(|| toml::Value::Table(toml::Table::new()));
    controller.as_table_mut().unwrap().insert("lambda".into(), toml::Value::Float(8.0));
    controller.as_table_mut().unwrap().insert("planner".into(), toml::Value::String("exact".into()));
    fs::write(&path, toml::to_string(&file).unwrap()).unwrap();
    let set =
        ["--set", "controller.lambda=8.0", "--set", "controller.planner=exact", "--set", "duration=2.0"];
    let (written_out, _) = written(0, &[path.to_str().unwrap()]);
    let (set_out, _) = written(0, &[&["paper"], &set[..]].concat());
    assert_eq!(written_out, set_out);
    let (_, plain) = written(1, &["paper", "--set", "controller.lamda=8"]);
    assert!(plain.contains("unknown field `lamda`"), "{plain}");
    let (_, plain) = written(1, &["paper", "--set", "controller.lambda=-8"]);
    assert!(plain.contains("controller.lambda = -8"), "{plain}");
    let (_, wrong) = written(2, &["paper", "--set", "controller.lambda"]);
    assert!(wrong.contains("controller.lambda=8"), "{wrong}");
    written(2, &["--to", "0.1,0,1", "--set", "controller.lambda=8"]);
}

#[test]
fn a_sweep_tells_of_each_combination_what_the_single_run_tells() {
    let common = ["paper", "--set", "duration=3.0", "--json"];
    let (out, _) = written(
        0,
        &[&common[..], &["--sweep", "controller.lambda=2,4", "--sweep", "controller.planner=bounded,exact"]]
            .concat(),
    );
    let cases: Vec<serde_json::Value> = serde_json::from_str(&out).unwrap();
    assert_eq!(cases.len(), 4);
    for case in &cases {
        let set: Vec<_> =
            case["set"].as_object().unwrap().iter().map(|(name, value)| format!("{name}={value}")).collect();
        let set: Vec<_> = set.iter().flat_map(|setting| ["--set", setting]).collect();
        let (single, _) = written(0, &[&common[..], &set].concat());
        assert_eq!(serde_json::from_str::<serde_json::Value>(&single).unwrap(), case["summary"]);
    }
    let (table, _) = written(0, &["paper", "--set", "duration=1.0", "--sweep", "controller.lambda=2,4"]);
    assert_eq!(table.lines().count(), 3, "{table}");
    written(
        4,
        &[
            "paper",
            "--sweep",
            "controller.lambda=3",
            "--set",
            "controller.planner=exact",
            "--set",
            "disturbances=[{from=0.5,force=[40,0,0]}]",
        ],
    );
}

#[test]
fn every_tenth_row_is_that_of_the_whole_run() {
    let (all, _) = written(0, &["--to", "0.1,0,1", "--duration", "0.5"]);
    let (some, _) = written(0, &["--to", "0.1,0,1", "--duration", "0.5", "--every", "10"]);
    let [mut all, some] = [&all, &some].map(|text| text.lines().collect::<Vec<_>>());
    let header = all.remove(0);
    assert_eq!(some[0], header);
    assert_eq!(some[1..], all.iter().step_by(10).copied().collect::<Vec<_>>()[..]);
}
