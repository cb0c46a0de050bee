//! The built `cable-robot`, as a user runs it.

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("the binary is built")
}

/// What a command that must end with `code` wrote to stdout and stderr.
fn written(code: i32, arguments: &[&str]) -> (String, String) {
    let output = run(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{out}\n{err}");
    (out, err)
}

fn json(code: i32, arguments: &[&str]) -> Value {
    let (out, _) = written(code, &[arguments, &["--json"]].concat());
    serde_json::from_str(&out).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The refusal of a rig file with this text.
fn refused_rig(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my rig.toml");
    fs::write(&path, text).unwrap();
    let (out, err) = written(1, &["workspace", "--rig", path.to_str().unwrap()]);
    assert!(out.is_empty() && err.contains("my rig.toml"), "{err}");
    err
}

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

#[test]
fn rigs_that_make_no_sense_are_refused_with_line_field_and_cause() {
    let paper = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    let error = refused_rig(&paper.replace("mass = 6.0", "mass = -6.0"));
    let line = paper.lines().position(|line| line.starts_with("mass")).unwrap() + 1;
    assert!(error.contains(&format!("line {line}: platform.mass = -6")) && error.contains("greater than 0"));
    let error = refused_rig(&paper.replace("gravity = 9.81", "gravitas = 9.81"));
    assert!(error.contains("gravitas") && error.contains("gravity"), "{error}");
    assert_eq!(error.matches("unknown field").count(), 1, "{error}");
    let error = refused_rig(&paper.replace("home = [0.0, 0.0, 1.0]", "home = [0.0, 0.0, 0.0]"));
    assert!(error.contains("in one plane"), "{error}");
    let error = refused_rig(&paper.replace("gravity = 9.81", "gravity = 0.0"));
    assert!(error.contains("gravity = 0 is not allowed"), "{error}");
    let error = refused_rig(&paper.replace("min = 0.0", "min = 200.0"));
    assert!(
        error.contains("tension.max = 100 is not allowed: must be greater than the least tension"),
        "{error}"
    );
    let error =
        refused_rig(&paper.replace(", -0.45, 0.0]", ", 0.0, 0.0]").replace(", 0.45, 0.0]", ", 0.0, 0.0]"));
    assert!(error.contains("anchors all lie on one line"), "{error}");
    let (_, error) = written(1, &["workspace", "--rig", "no/such.toml"]);
    assert!(error.contains("no/such.toml"), "{error}");
}

#[test]
fn the_papers_planner_refuses_a_rig_of_another_shape_and_says_what_differs() {
    let arguments = ["--rig", "rigs/eight.toml", "--to", "0.1,0,2", "--from", "0,0,2"];
    let (_, error) = written(1, &[&["reach"], &arguments[..]].concat());
    assert!(error.contains("the rig has 8 cables, the paper's 6"), "{error}");
    for task in ["plan", "simulate"] {
        let (_, error) = written(1, &[&[task], &arguments[..], &["--planner", "bounded"]].concat());
        assert!(error.contains("the rig has 8 cables, the paper's 6"), "{error}");
    }
    let (text, _) = written(0, &[&["plan"], &arguments[..]].concat());
    assert!(text.contains("the goal is reached"), "{text}");
}

#[test]
fn the_papers_move_takes_four_set_points() {
    let plan = json(0, &["plan", "--from", "0,0,1", "--to", "0.15,0.15,1"]);
    let x: Vec<_> = plan["setPoints"].as_array().unwrap().iter().map(|point| number(&point[0])).collect();
    for (x, expected) in x.iter().zip([0.0855, 0.1266, 0.1464, 0.15]) {
        assert!((x - expected).abs() < 5e-5, "{x} is not {expected}");
    }
    assert_eq!((x.len(), &plan["reachable"], &plan["obstacle"]), (4, &Value::Bool(true), &Value::Null));
    let smallest = &plan["smallestTension"];
    assert_eq!((&smallest["step"], &smallest["at"]["cable"]), (&4.into(), &5.into()));
    assert!((number(&smallest["at"]["tension"]) - 1.050).abs() < 5e-4);
}

#[test]
fn a_goal_outside_is_explained_and_the_nearest_point_given() {
    let arguments = ["plan", "--from", "0,0,1", "--to", "0,-0.4,1"];
    let obstacle = json(3, &arguments)["obstacle"].take();
    // Facet 3, normal -y, apothem 0.225 m; the planner keeps a few millimetres.
    assert_eq!(obstacle["firstOutside"]["cable"], 3);
    assert_eq!(obstacle["barrier"]["cable"], 3);
    let distance = number(&obstacle["nearest"]["distance"]);
    assert!((0.175..0.18).contains(&distance), "{distance}");
    assert!((number(&obstacle["nearest"]["pose"][1]) + 0.4 - distance).abs() < 1e-6, "{obstacle}");
    assert!(number(&obstacle["firstOutside"]["tension"]) <= 0.0);
    let (text, _) = written(3, &arguments);
    assert!(
        text.contains("cannot be reached") && text.contains("held back by cable 3, at rest slack from"),
        "{text}"
    );

    // What is called the nearest point can be reached.
    let y = format!("0,{},1", number(&obstacle["nearest"]["pose"][1]));
    assert_eq!(json(0, &["plan", "--from", "0,0,1", "--to", &y])["reachable"], true);
}

/// The refusal of a move from (0, 0, 1) on the paper's rig with other numbers.
fn refused_move(goal: &str, planner: &str, changes: &[(&str, &str)]) -> (Value, String) {
    let paper = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    let changed = changes.iter().fold(paper, |text, (old, new)| text.replace(old, new));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.toml");
    fs::write(&path, changed).unwrap();
    let move_of = ["--from", "0,0,1", "--to", goal, "--planner", planner];
    let arguments = [&["plan", "--rig", path.to_str().unwrap()], &move_of[..]].concat();
    (json(3, &arguments), written(3, &arguments).0)
}

#[test]
fn where_the_upper_limit_binds_no_cable_is_called_slack() {
    for planner in ["bounded", "exact"] {
        let (plan, text) = refused_move("0.15,0.15,1", planner, &[("max = 100.0", "max = 15.0")]);
        let barrier = &plan["obstacle"]["barrier"];
        // NOTES: at (0.15, 0.15, 1) cable 4 would pull 19.4 N.
        assert_eq!((barrier["cable"].as_u64(), barrier["limit"].as_f64()), (Some(4), Some(15.0)), "{plan}");
        assert!(
            text.contains("held back by cable 4, at rest above 15 N") && !text.contains("slack"),
            "{text}"
        );
    }
    let (_, text) = refused_move("0.15,0.15,1", "exact", &[("min = 0.0", "min = 2.0")]);
    assert!(text.contains("held back by cable 5, at rest below 2 N"), "{text}");
    // At rest there u2 is 0.05 N.
    for planner in ["bounded", "exact"] {
        let (plan, text) = refused_move("0,0.224,1", planner, &[]);
        assert_eq!(plan["obstacle"]["barrier"], Value::Null);
        assert!(text.contains("0.17 % of the weight"), "{text}");
    }
}

#[test]
fn a_plan_that_was_given_up_says_so_and_where() {
    let slow = [("max = 100.0", "max = 1e9"), ("= 3.0", "= 80.0")];
    let (plan, text) = refused_move("0.15,0.15,1", "exact", &slow);
    assert_eq!((&plan["reachable"], &plan["obstacle"]), (&Value::Null, &Value::Null));
    let last = plan["setPoints"].as_array().unwrap().last().unwrap();
    assert!((0.1..0.15).contains(&number(&last[0])), "{last}");
    assert!(
        text.contains("given up after 1000 set points at (0.12") && !text.contains("cannot be reached"),
        "{text}"
    );
    // Where the platform cannot rest no number of set points leads.
    let (plan, text) = refused_move("0,0.4,1", "exact", &slow);
    assert_eq!((&plan["reachable"], &plan["obstacle"]["barrier"]["cable"]), (&Value::Bool(false), &2.into()));
    assert!(text.contains("cannot be reached"), "{text}");
}

#[test]
fn the_exact_planner_takes_the_papers_move_in_one_step_and_other_heights() {
    let plan = json(0, &["plan", "--from", "0,0,1", "--to", "0.15,0.15,1", "--planner", "exact"]);
    assert_eq!(plan["setPoints"].as_array().unwrap().len(), 1);
    let rise = ["plan", "--from", "0,0,1", "--to", "0,0.1,0.8"];
    assert_eq!(json(3, &rise)["reachable"], false);
    assert_eq!(json(0, &[&rise[..], &["--planner", "exact"]].concat())["reachable"], true);
}

#[test]
fn a_rig_file_changes_what_can_be_reached() {
    let paper = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/paper.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("quick.toml");
    fs::write(&path, paper.replace("lambda = 3.0", "lambda = 1.0").replace("eta = 3.0", "eta = 1.0"))
        .unwrap();
    let slower =
        json(0, &["plan", "--rig", path.to_str().unwrap(), "--from", "0,0,1", "--to", "0.15,0.15,1"]);
    assert!(slower["setPoints"].as_array().unwrap().len() < 4, "{slower}");
}

#[test]
fn reach_gives_the_polygon_and_where_a_ray_leaves_it() {
    let domain = json(3, &["reach", "--from", "0,0,1", "--to", "0.15,0.15,1"]);
    assert_eq!(domain["vertices"].as_array().unwrap().len(), 6);
    let to = &domain["to"];
    assert_eq!((&to["admissible"], &to["forbiddenBy"]), (&Value::Bool(false), &5.into()));
    // The planner's bisection stops within 1/256 of it: 0.0855.
    let x = number(&to["farthest"][0]);
    assert!((0.0855..0.0855 + 0.15 / 256.0 + 1e-4).contains(&x), "{x}");
    let inside = json(0, &["reach", "--from", "0,0,1", "--to", "0.08,0.08,1"]);
    assert_eq!(inside["to"]["admissible"], true);
    let (_, error) = written(1, &["reach", "--from", "0.3,0,1"]);
    assert!(error.contains("outside the static workspace"), "{error}");
}

#[test]
fn simulate_writes_csv_and_arrives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let arguments = ["simulate", "--to", "0.05,0,1", "--duration", "4", "--step", "0.01"];
    let (to_stdout, summary) = written(0, &arguments);
    assert!(summary.contains("slack cables: none"), "{summary}");
    let with_file = [&arguments[..], &["--output", path.to_str().unwrap()]].concat();
    let found = json(0, &with_file);
    assert_eq!(found["status"], "AtGoal");
    assert_eq!(fs::read_to_string(path.join("run.csv")).unwrap(), to_stdout);

    let mut reader = csv::Reader::from_reader(to_stdout.as_bytes());
    let columns = reader.headers().unwrap().len();
    let rows: Vec<Vec<f64>> = reader.deserialize().map(Result::unwrap).collect();
    assert!(rows.len() == 401 && rows.iter().all(|row| row.len() == columns));
    let last = &rows[400];
    assert!((last[0] - 4.0).abs() < 1e-12 && (last[1] - 0.05).abs() < 2e-3, "{last:?}");

    written(3, &["simulate", "--to", "0,0.4,1", "--duration", "1", "--step", "0.01"]);
}

#[test]
fn bad_arguments_are_refused_with_what_is_allowed() {
    for (pose, cause) in [
        ("0,nan,1", "not a finite number"),
        ("0,0,inf", "not a finite number"),
        ("0,1", "2 numbers given"),
        ("0,0,1,0", "4 numbers given"),
        ("0,zero,1", "not a number"),
    ] {
        let (out, error) = written(2, &["plan", "--from", "0,0,1", "--to", pose]);
        assert!(out.is_empty() && error.contains(cause) && error.contains("--to"), "{pose}: {error}");
    }
    // What lies below the anchors the rig says.
    for pose in ["0,0,-1", "0,0,0"] {
        let (out, error) = written(1, &["plan", "--from", "0,0,1", "--to", pose]);
        assert!(
            out.is_empty() && error.contains("--to: z = ") && error.contains("below the anchors"),
            "{error}"
        );
    }
    written(2, &["simulate", "--to", "0,0,1", "--step", "0"]);
    written(2, &["workspace", "--height", "high"]);
    written(2, &[]);
    let (_, error) = written(1, &["simulate", "--to", "0,0,1", "--duration", "1e300"]);
    assert!(error.contains("steps"), "{error}");
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_work() {
    let (out, error) = written(1, &["simulate", "--to", "0.1,0,1", "--output", "no/such/folder/run.csv"]);
    assert!(
        out.is_empty() && error.contains("no/such/folder/run.csv") && !error.contains("set points"),
        "{error}"
    );
    let (out, error) = written(1, &["workspace", "--svg", "no/such/folder/w.svg"]);
    assert!(out.is_empty() && error.contains("no/such/folder/w.svg"), "{error}");
}

#[test]
fn a_result_that_cannot_be_written_is_an_error_that_names_the_place() {
    let (out, error) = written(1, &["workspace", "--svg", "/dev/full"]);
    assert!(out.is_empty() && error.contains("cannot write /dev/full: No space left"), "{error}");
    for arguments in
        [&["reach", "--from", "0,0,1"][..], &["simulate", "--to", "0.1,0,1", "--duration", "0.1"]]
    {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        let output = command.args(arguments).stdout(full).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1));
        assert!(error.contains("cannot write to stdout: No space left"), "{error}");
    }
}

#[test]
fn a_pipe_that_nobody_reads_does_not_change_the_exit_code() {
    for (code, goal) in [(0, "0.08,0.08,1"), (3, "0.15,0.15,1")] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_cable-robot"))
            .args(["reach", "--from", "0,0,1", "--to", goal])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), output.stderr), (Some(code), vec![]), "{goal}");
    }
}

#[test]
fn numbers_of_any_size_fit_on_a_line() {
    let short = |text: &str| text.lines().all(|line| line.chars().count() < 200);
    let (_, error) = written(1, &["workspace", "--height", "1e300"]);
    assert!(error.contains("--height 1e300") && error.contains("parallel") && short(&error), "{error}");
    let (text, _) = written(3, &["plan", "--from", "0,0,1", "--to", "0,0.4,1e300"]);
    assert!(text.contains("1.000e300 m from the goal") && short(&text), "{text}");
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_cable-robot"))
        .args(["simulate", "--to", "0.1,0,1", "--duration", "5"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(0) && said.starts_with("From (0, 0, 1)"), "{said}");
}

#[test]
fn help_of_every_command_has_an_example_and_the_exit_codes_stand_in_the_first() {
    let (help, _) = written(0, &["--help"]);
    assert!(help.contains("Exit codes: 0 done, 1 error, 2 wrong usage, 3 goal not reachable"), "{help}");
    for task in ["workspace", "reach", "plan", "simulate", "certify", "schema", "completions", "man"] {
        let (help, _) = written(0, &[task, "--help"]);
        let example = help.lines().find_map(|line| line.strip_prefix("Example: cable-robot ")).expect(task);
        let folder = tempfile::tempdir().unwrap();
        let rigs = folder.path().join("rigs");
        fs::create_dir(&rigs).unwrap();
        fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/eight.toml"), rigs.join("eight.toml"))
            .unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_cable-robot"));
        let output = command.args(example.split_whitespace()).current_dir(folder.path()).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 3)), "{example}: {output:?}");
    }
}

#[test]
fn what_the_page_shows_is_what_the_program_prints() {
    let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/command-line.md")).unwrap();
    let shown: Vec<_> =
        page.split("```").filter_map(|block| block.strip_prefix("\n$ cable-robot ")).collect();
    assert_eq!(shown.len(), 7);
    for block in shown {
        let (command, expected) = block.split_once('\n').unwrap();
        let output = run(&command.split_whitespace().collect::<Vec<_>>());
        assert_eq!(String::from_utf8(output.stdout).unwrap(), expected, "{command}");
    }
}

#[test]
fn certify_proves_a_step_in_all_six_coordinates_and_names_what_breaks_another() {
    let proved = json(0, &["certify", "--from", "0,0,1", "--to", "0.1,0.05,0.9,0.05,0,0.1"]);
    assert_eq!(proved["verdict"], "admissible");
    assert!(number(&proved["least"]) > 0.0);
    let refused = json(3, &["certify", "--from", "0,0,1", "--to", "0.3,0,1"]);
    assert_eq!((refused["verdict"].as_str(), refused["cable"].as_u64()), (Some("not admissible"), Some(5)));
    let margins = json(
        0,
        &["certify", "--from", "0,0,1", "--to", "0.1,0,1", "--mass-error", "0.005", "--force", "0.2"],
    );
    let exact = json(0, &["certify", "--from", "0,0,1", "--to", "0.1,0,1"]);
    assert!(number(&margins["least"]) < number(&exact["least"]));
}

#[test]
fn certify_knows_eight_cables() {
    let with =
        |more: &[&'static str]| [&["certify", "--rig", "rigs/eight.toml", "--from", "0,0,2"], more].concat();
    let proved = json(0, &with(&["--to", "0.5,0.3,1.8,0,0.1,0.2"]));
    assert_eq!(proved["verdict"], "admissible");
    assert!(number(&proved["least"]) > 5.0 && number(&proved["greatest"]) < 400.0, "{proved}");
    let refused = json(3, &with(&["--to", "0,1.6,2"]));
    assert_eq!(refused["verdict"], "not admissible");
    assert!(number(&refused["shortfall"]) > 0.0 && !refused["atLeast"].as_array().unwrap().is_empty());
    let (text, _) = written(3, &with(&["--to", "0,1.6,2"]));
    assert!(text.contains("no tensions keep the limits") && text.contains("at their least"), "{text}");
    // With margins, what is said is said of the law's distribution.
    let (text, _) = written(0, &with(&["--to", "0.1,0,2", "--force", "0.2", "--sample-period", "0.0005"]));
    assert!(text.contains("admissible: every tension stays between"), "{text}");
    // More friction than the law keeps from the limits.
    let (text, _) = written(3, &with(&["--to", "0.1,0,2", "--friction", "0.6"]));
    assert!(text.contains("undecided"), "{text}");
}

#[test]
fn schema_prints_what_is_checked_in() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    for (name, path) in [("rig", "rigs/rig.schema.json"), ("proof", "docs/proof.schema.json")] {
        let (printed, _) = written(0, &["schema", name]);
        assert_eq!(printed, fs::read_to_string(format!("{root}/{path}")).unwrap());
    }
    let (_, error) = written(2, &["schema", "boat"]);
    assert!(error.contains("rig"), "{error}");
}

#[test]
fn a_goal_where_the_wrench_matrix_is_singular_is_named_as_such() {
    // The paper's rig, turned by a quarter.
    let goal = ["--from", "0,0,1", "--to", "0,0,1,0,0,1.5707963267948966"];
    let (text, _) = written(3, &[&["certify"], &goal[..]].concat());
    assert!(text.starts_with("undecided: the wrench matrix is singular"), "{text}");
    for planner in ["bounded", "exact"] {
        let plan = [&["plan", "--planner", planner], &goal[..]].concat();
        let (text, _) = written(3, &plan);
        assert!(text.contains("cannot be reached\n  at the goal the wrench matrix is singular"), "{text}");
        assert_eq!(json(3, &plan)["obstacle"]["goalSingular"], true);
    }
    let level = json(3, &["plan", "--from", "0,0,1", "--to", "0,0.4,1"]);
    assert_eq!(level["obstacle"]["goalSingular"], false);
}

#[test]
fn the_exact_planner_turns_and_says_where_a_turned_goal_ends() {
    let turned = ["plan", "--planner", "exact", "--from", "0,0,1", "--to", "0.05,0,1.1,0.1,0,0.3"];
    let (text, _) = written(0, &turned);
    assert!(text.contains("roll (rad)") && text.contains("the goal is reached"), "{text}");
    let beyond = ["plan", "--planner", "exact", "--from", "0,0,1", "--to", "0.2,0,1,0,0,0.9"];
    let obstacle = &json(3, &beyond)["obstacle"];
    let (nearest, barrier) = (&obstacle["nearest"]["pose"], &obstacle["barrier"]["pose"]);
    let (had, forbidden) = (number(&nearest[5]), number(&barrier[5]));
    assert!(0.0 < had && had < forbidden && forbidden < 0.9, "{obstacle}");
    let back = ["plan", "--from", "0,0,1", "--to", "0,0,1,0,0,0.1"];
    assert!(written(3, &back).0.contains("planner bounded keeps zero orientation"));
}

#[test]
fn a_goal_far_out_is_held_back_where_one_near_by_is() {
    for (goal, cables) in [("0,1e9,1", [2, 2]), ("1e300,0,1", [5, 6])] {
        for planner in ["bounded", "exact"] {
            let obstacle =
                &json(3, &["plan", "--planner", planner, "--from", "0,0,1", "--to", goal])["obstacle"];
            let barrier = &obstacle["barrier"];
            let [x, y] = [0, 1].map(|k| number(&barrier["pose"][k]));
            // The corners of the hexagon lie at 0.26 m.
            assert!(x.hypot(y) < 0.27, "{planner} {goal}: {obstacle}");
            assert!(cables.iter().any(|cable| barrier["cable"] == *cable), "{planner} {goal}: {obstacle}");
            let [x, y] = [0, 1].map(|k| number(&obstacle["nearest"]["pose"][k]));
            assert!((0.2..0.27).contains(&x.hypot(y)), "{planner} {goal}: {obstacle}");
        }
    }
}

#[test]
fn degrees_are_not_taken_for_radians() {
    let goal = ["plan", "--from", "0,0,1", "--to", "0,0,1,0,0,30", "--planner", "exact"];
    assert!(written(2, &goal).1.contains("angles are in radians"));
    assert!(written(2, &["workspace", "--orientation", "30,0,0"]).1.contains("angles are in radians"));
}

#[test]
fn margins_that_make_no_sense_are_named_by_their_option() {
    for (option, value, expected) in [
        ("--mass-error", "5", "below 1"),
        ("--mass-error", "-1", "0 or greater"),
        ("--delay", "inf", "finite"),
    ] {
        let (_, error) = written(2, &["certify", "--from", "0,0,1", "--to", "0.1,0,1", option, value]);
        assert!(error.contains(option) && error.contains(expected), "{error}");
    }
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

#[test]
fn tensions_hold_the_weight_and_say_who_shares_how() {
    let rig = ["--rig", "rigs/eight.toml"];
    let at = ["tensions", "--pose", "0.3,0.2,2"];
    let law = json(0, &[&at[..], &rig[..]].concat());
    let widest = json(0, &[&at[..], &rig[..], &["--distribution", "widest"]].concat());
    let margin = |found: &Value| number(&found["margin"]);
    assert!(margin(&law) > 20.0 && margin(&widest) > margin(&law), "{law} {widest}");
    assert_eq!(law["cables"].as_array().unwrap().len(), 8);
    // Upwards faster: every cable of a suspended rig pulls more in sum.
    let sum = |found: &Value| -> f64 {
        found["cables"].as_array().unwrap().iter().map(|cable| number(&cable["tension"])).sum()
    };
    let lifted = json(0, &[&at[..], &rig[..], &["--acceleration", "0,0,-2,0,0,0"]].concat());
    assert!(sum(&lifted) > 1.1 * sum(&law), "{lifted}");
    let (text, _) = written(3, &["tensions", "--pose", "0.3,0.3,1"]);
    assert!(text.contains("each would have to be wider by 10.685 N"), "{text}");
}
