//! The measured rows of docs/limits.md are what the program does.

use cable_robot::plan::{ControllerParameters, Status};
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::{ScenarioFile, Simulation};

const PAGE: &str = include_str!("../../docs/limits.md");

/// Where a run ends: mm and mrad from the goal, and the status.
#[derive(Debug)]
struct End {
    distance: f64,
    turn: f64,
    status: Status,
}

/// The run of the page with these lines in the scenario's tables, `step` s, and a platform of `mass` kg.
fn end(imperfections: &str, controller: &str, step: f64, mass: f64) -> End {
    let text = format!(
        "title = \"limits\"\nduration = 12.0\nstep = {step}\n[[goals]]\ntime = 0.0\npose = [0.1, 0.0, 1.0]\n\
         [imperfections]\n{imperfections}\n[controller]\n{controller}\n"
    );
    let base = ControllerParameters::default();
    let home = RigFile::default().home;
    let mut scenario = ScenarioFile::parse(&text).unwrap().scenario("paper", home, base).unwrap();
    scenario.plant.rig.mass = mass;
    let mut simulation = Simulation::new(&scenario).unwrap();
    for _ in 0..(12.0 / step).round() as u32 {
        simulation.step().unwrap();
    }
    let moment = simulation.moment();
    let (at, goal) = (moment.plant.encoder_pose, Pose::at(0.1, 0.0, 1.0));
    End {
        distance: 1e3 * (at.position() - goal.position()).norm(),
        turn: 1e3 * at.rotation().rotation_to(&goal.rotation()).angle(),
        status: moment.controller.status,
    }
}

/// The cells of a row of the page.
fn row(name: &str) -> Vec<&'static str> {
    let line = PAGE.lines().find(|line| line.starts_with(&format!("| {name} |")));
    let line = line.unwrap_or_else(|| panic!("docs/limits.md has no row {name}"));
    line.trim_matches('|').split('|').map(str::trim).collect()
}

#[test]
fn the_measured_rows_are_what_the_program_does() {
    let mut wrong = vec![];
    for (name, imperfections, controller, step, mass) in [
        ("plain", "", "", 1e-3, 6.0),
        ("friction 0.2", "friction = 0.2", "", 1e-3, 6.0),
        ("friction 0.5", "friction = 0.5", "", 1e-3, 6.0),
        ("friction 1.0", "friction = 1.0", "", 1e-3, 6.0),
        ("friction 1.0 closed", "friction = 1.0", "force_loop = true", 1e-3, 6.0),
        ("noise 0.1", "load_cell_noise = 0.1", "force_loop = true", 1e-3, 6.0),
        ("noise 0.1 slow", "load_cell_noise = 0.1", "force_loop = true", 4e-3, 6.0),
        ("mass 6.012", "", "", 1e-3, 6.012),
        ("exact, friction 0.2", "friction = 0.2", "planner = \"exact\"", 1e-3, 6.0),
        ("exact, friction 1.0", "friction = 1.0", "planner = \"exact\"", 1e-3, 6.0),
        ("exact, friction 1.0 closed", "friction = 1.0", "planner = \"exact\"\nforce_loop = true", 1e-3, 6.0),
        ("exact, mass 6.012", "", "planner = \"exact\"", 1e-3, 6.012),
        ("exact, mass 6.6", "", "planner = \"exact\"", 1e-3, 6.6),
        ("exact, mass 7", "", "planner = \"exact\"", 1e-3, 7.0),
    ] {
        let found = end(imperfections, controller, step, mass);
        println!("| {name} | ... | {:.2} | {:.1} | {:?} |", found.distance, found.turn, found.status);
        let cells = row(name);
        let near = |cell: &str, found: f64, unit: f64| {
            let said: f64 = cell.parse().unwrap();
            (said - found).abs() <= unit + 0.02 * said.abs()
        };
        let is_so = near(cells[2], found.distance, 0.01)
            && near(cells[3], found.turn, 0.1)
            && cells[4] == format!("{:?}", found.status);
        if !is_so {
            wrong.push(format!("{name}: {found:?}, the page says {cells:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
