use super::*;
use crate::plan::PlannerKind;
use crate::sim::BUNDLED;
use serde_json::Value;

const FULL: &str = r#"title = "All there is"
rig = "my.toml"
start = [0.01, 0.0, 1.0, 0.0, 0.0, 0.1]
duration = 3
step = 0.01

[[goals]]
time = 0.5
pose = [0.1, 0.0, 1.0]

[[goals]]
time = 1.0
pose = [0.0, 0.1, 1.0, 0.0, 0.0, 0.2]

[[disturbances]]
from = 1.0
until = 2.0
force = [1.0, 2.0, 3.0]

[[disturbances]]
from = 2.0
torque = [0.0, 0.0, 0.1]

[imperfections]
friction = 0.5
motor_lag = 0.005
encoder_resolution = 1e-5
load_cell_noise = 0.05
noise_seed = -7

[controller]
planner = "exact"
planner_period = 0.1
bisection_steps = 9
lambda = 2.0
eta = 4.0
min_tension = 1.0
max_tension = 50.0
pose_source = "cable_lengths"
force_loop = true
hold_compensation = false
command_delay = 0.002
observer_bound = 0.2
mass_tolerance = 0.03
encoder_resolution = 0.0001
disturbance_bound = 0.5
max_speed = 0.3
max_angular_rate = 0.4
max_cable_speed = 0.6
"#;

fn scenario(text: &str) -> Result<Scenario, ScenarioFileError> {
    ScenarioFile::parse(text)?.scenario("rig", Pose::default(), ControllerParameters::default())
}

/// What is said of the full file with one text replaced by another.
fn refusal(from: &str, to: &str) -> String {
    assert!(FULL.contains(from), "{from}");
    scenario(&FULL.replacen(from, to, 1)).expect_err(to).to_string()
}

fn line(text: &str) -> String {
    format!("line {}: ", FULL.lines().position(|line| line.starts_with(text)).unwrap() + 1)
}

#[test]
fn a_rate_of_tensions_is_read_with_minimum_time_and_refused_with_others() {
    let with = |planner: &str| {
        let fields = format!("max_cable_speed = 0.6\nmax_tension_rate = 400.0\nplanner = \"{planner}\"");
        let text =
            FULL.replacen("planner = \"exact\"\n", "", 1).replacen("max_cable_speed = 0.6", &fields, 1);
        scenario(&text)
    };
    assert_eq!(with("minimum-time").unwrap().controller.max_tension_rate, 400.0);
    let refused = with("exact").unwrap_err().to_string();
    assert!(refused.contains("controller.max_tension_rate = 400"), "{refused}");
}

#[test]
fn every_field_is_read() {
    let found = scenario(FULL).unwrap();
    let controller = ControllerParameters {
        lambda: 2.0,
        eta: 4.0,
        planner_period: 0.1,
        bisection_steps: 9,
        rig: ControllerParameters::default().rig.with_limits(TensionLimits { min: 1.0, max: 50.0 }),
        planner: PlannerKind::Exact,
        pose_source: PoseSource::CableLengths,
        force_loop: true,
        hold_compensation: false,
        command_delay: 0.002,
        observer_bound: 0.2,
        mass_tolerance: 0.03,
        encoder_resolution: 0.0001,
        disturbance_bound: 0.5,
        max_speed: 0.3,
        max_angular_rate: 0.4,
        max_cable_speed: 0.6,
        ..ControllerParameters::default()
    };
    let plant = PlantParameters {
        initial_pose: Pose(Coordinates::new(0.01, 0.0, 1.0, 0.0, 0.0, 0.1)),
        friction: 0.5,
        motor_lag: 0.005,
        encoder_resolution: 1e-5,
        load_cell_noise: 0.05,
        noise_seed: -7,
        rig: controller.rig,
    };
    assert_eq!((found.controller, found.plant), (controller, plant));
    assert_eq!((found.duration, found.step), (3.0, 0.01));
    let turned = Pose(Coordinates::new(0.0, 0.1, 1.0, 0.0, 0.0, 0.2));
    let goals = [Goal::new(0.5, Pose::at(0.1, 0.0, 1.0)), Goal::new(1.0, turned)];
    assert_eq!(found.goals, goals);
    let [force, torque] = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.0, 0.0, 0.1)];
    let pulse = Disturbance { from: 1.0, until: 2.0, force, torque: Vector3::zeros() };
    let step = Disturbance { from: 2.0, until: f64::INFINITY, force: Vector3::zeros(), torque };
    assert_eq!(found.disturbances, [pulse, step]);
    assert_eq!(ScenarioFile::parse(FULL).unwrap().rig(), Some((2, "my.toml")));
}

#[test]
fn the_schema_that_is_checked_in_is_that_of_the_file() {
    let there: serde_json::Value =
        serde_json::from_str(include_str!("../../../scenarios/scenario.schema.json")).unwrap();
    let schema = schema().to_value();
    assert!(there == schema, "drifted: `cargo run -- schema scenario > scenarios/scenario.schema.json`");
    let tables = schema["$defs"].as_object().unwrap().values().chain([&schema]);
    for part in tables.filter(|part| part["type"] == "object") {
        assert_eq!(part["additionalProperties"], false);
        for (name, field) in part["properties"].as_object().unwrap() {
            assert!(
                field.get("description").is_some() && field.get("default") != Some(&Value::Null),
                "{name}"
            );
        }
    }
}

#[test]
fn what_is_not_given_is_the_rigs() {
    let mut base = ControllerParameters { lambda: 1.5, ..ControllerParameters::default() };
    base.rig = base.rig.with_limits(TensionLimits { min: 0.0, max: 70.0 });
    let home = Pose::at(0.05, 0.0, 0.9);
    let file = ScenarioFile::parse("title = \"t\"\nduration = 1.0").unwrap();
    let found = file.scenario("rig", home, base).unwrap();
    assert_eq!((found.controller, found.plant.initial_pose, found.step), (base, home, DEFAULT_STEP));
    assert_eq!(found.goal_at(0.5), home);
}

#[test]
fn the_bundled_scenarios_are_right() {
    for (name, text) in BUNDLED {
        let found = scenario(text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(text.contains("# Shows: ") && !found.title.is_empty(), "{name} says what it shows");
    }
}

#[test]
fn bad_values_are_named_with_line_field_and_what_is_allowed() {
    for (from, to, at, said) in [
        (
            "duration = 3",
            "duration = 0",
            "duration",
            "duration = 0 is not allowed: must be finite and greater",
        ),
        ("duration = 3", "duration = inf", "duration", "duration = inf"),
        ("duration = 3", "duration = 0.005", "duration", "a whole number of steps of 0.01 s, such as 0.01 s"),
        ("duration = 3", "duration = 2.995", "duration", "such as 2.99 or 3.0 s"),
        ("time = 1.0", "time = 2.995", "time = 1.0", "at most 2.99 s, when the last step begins"),
        (
            "0.0, 0.0, 0.2]",
            "0.0, 0.0, 90]",
            "pose = [0.0",
            "goals[2].pose[6] = 90 is not allowed: angles are in radians",
        ),
        ("0.0, 0.0, 0.1]\nduration", "-7.0, 0.0, 0.1]\nduration", "start", "start[4] = -7"),
        ("duration = 3", "duration = 1e6", "duration", "in steps of 0.01 s it must make 1 to 1000000 steps"),
        ("step = 0.01", "step = nan", "step", "step = NaN"),
        ("start = [0.01", "start = [0.4", "start", "outside the static workspace"),
        (
            "start = [0.01, 0.0, 1.0,",
            "start = [0.0, 0.0, 0.0,",
            "start",
            "start[3] = 0 is not allowed: z points",
        ),
        ("time = 0.5", "time = -1", "time = 0.5", "goals[1].time = -1"),
        (
            "time = 0.5",
            "time = 3",
            "time = 0.5",
            "goals[1].time = 3 is not allowed: must be 0 or greater and at most",
        ),
        ("time = 1.0", "time = 0.5", "time = 1.0", "goals[2].time = 0.5 is not allowed: must come after"),
        (
            "pose = [0.1, 0.0, 1.0]",
            "pose = [0.1]",
            "pose",
            "goals[1].pose = [0.1] is not allowed: a pose is three",
        ),
        ("pose = [0.1, 0.0, 1.0]", "pose = [nan, 0.0, 1.0]", "pose", "goals[1].pose = [NaN, 0.0, 1.0]"),
        ("from = 1.0", "from = -1.0", "from = 1.0", "disturbances[1].from = -1"),
        (
            "until = 2.0",
            "until = 1.0",
            "until",
            "disturbances[1].until = 1 is not allowed: must be greater than",
        ),
        ("force = [1.0, 2.0", "force = [1.0, inf", "force", "disturbances[1].force[2] = inf"),
        ("torque = [0.0, 0.0, 0.1]", "", "from = 2.0", "disturbances[2].force = nothing"),
        ("friction = 0.5", "friction = -0.5", "friction", "imperfections.friction = -0.5"),
        ("motor_lag = 0.005", "motor_lag = inf", "motor_lag", "imperfections.motor_lag = inf"),
        (
            "encoder_resolution = 1e-5",
            "encoder_resolution = -1",
            "encoder_resolution",
            "encoder_resolution = -1",
        ),
        (
            "load_cell_noise = 0.05",
            "load_cell_noise = -1",
            "load_cell_noise",
            "imperfections.load_cell_noise = -1",
        ),
        ("planner_period = 0.1", "planner_period = 0", "planner_period", "controller.planner_period = 0"),
        ("bisection_steps = 9", "bisection_steps = 0", "bisection_steps", "controller.bisection_steps = 0"),
        ("lambda = 2.0", "lambda = 0", "lambda", "controller.lambda = 0"),
        (
            "eta = 4.0",
            "eta = 2000",
            "eta",
            "controller.eta = 2000 is not allowed: must be greater than 0 and at",
        ),
        (
            "step = 0.01",
            "step = 0.2",
            "step = 0.01",
            "step = 0.2 is not allowed: must be at most 1.647e-1 (s)",
        ),
        ("min_tension = 1.0", "min_tension = -1", "min_tension", "controller.min_tension = -1"),
        ("command_delay = 0.002", "command_delay = -1", "command_delay", "controller.command_delay = -1"),
        ("observer_bound = 0.2", "observer_bound = 2", "observer_bound", "controller.observer_bound = 2"),
        ("mass_tolerance = 0.03", "mass_tolerance = 1", "mass_tolerance", "controller.mass_tolerance = 1"),
        (
            "encoder_resolution = 0.0001",
            "encoder_resolution = -2",
            "encoder_resolution = 0.0001",
            "controller.encoder_resolution = -2",
        ),
        (
            "disturbance_bound = 0.5",
            "disturbance_bound = -1",
            "disturbance_bound",
            "controller.disturbance_bound = -1",
        ),
        ("max_speed = 0.3", "max_speed = -1", "max_speed", "controller.max_speed = -1"),
        (
            "max_angular_rate = 0.4",
            "max_angular_rate = nan",
            "max_angular_rate",
            "controller.max_angular_rate",
        ),
        ("max_cable_speed = 0.6", "max_cable_speed = inf", "max_cable_speed", "controller.max_cable_speed"),
        ("max_tension = 50.0", "max_tension = 0.5", "max_tension", "controller.max_tension = 0.5"),
    ] {
        let error = refusal(from, to);
        assert!(error.starts_with(&line(at)) && error.contains(said), "{to}: {error}");
    }
    // The rig's greatest tension is below the file's least.
    let text =
        FULL.replacen("max_tension = 50.0\n", "", 1).replacen("min_tension = 1.0", "min_tension = 200", 1);
    let error = scenario(&text).unwrap_err().to_string();
    assert!(error.starts_with(&line("min_tension")) && error.contains("max_tension = 100"), "{error}");
}

#[test]
fn unknown_missing_and_mistyped_fields_are_named_with_their_line() {
    let unknown = refusal("friction = 0.5", "frictoin = 0.5");
    assert!(
        unknown.contains("line 25") && unknown.contains("`frictoin`, expected one of `friction`"),
        "{unknown}"
    );
    let missing = refusal("duration = 3\n", "");
    assert!(missing.contains("missing field `duration`"), "{missing}");
    let variant = refusal("\"exact\"", "\"exakt\"");
    assert!(
        variant.contains("line ") && variant.contains("expected one of `bounded`, `exact`, `minimum-time`"),
        "{variant}"
    );
    let short = refusal("force = [1.0, 2.0, 3.0]", "force = [1.0, 2.0]");
    assert!(short.contains("line ") && short.contains("array of length 3"), "{short}");
    let word = refusal("time = 1.0", "time = \"soon\"");
    assert!(word.contains("soon") && word.contains("line "), "{word}");
}
