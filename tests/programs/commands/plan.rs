//! `cable-robot plan`, `reach` and `certify`.

use std::fs;

use serde_json::Value;

use super::program::{json, number, written};

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
