//! The report's facts: what was run and with what, and what came of it, in words.

use super::Slack;
use super::digest::Digest;
use super::events::Kind;
use super::history::{Arrival, History};
use super::run_folder::Model;
use cable_robot::control::{Barrier, barrier};
use cable_robot::plan::{ControllerParameters, Planner, PoseSource, Status};
use cable_robot::robot::{Pose, Rig};

/// More goals than these are counted only.
const MOST_GOALS: usize = 10;
/// The first ones tell most.
const MOST_FAULTS: usize = 10;

/// What was run and with what, and what came of it.
pub fn facts(digest: &Digest, history: &History) -> Vec<(&'static str, String)> {
    let (info, summary) = (history.info, &digest.summary);
    let (controller, plant) = (&info.controller_parameters, &info.plant_parameters);
    let gains = controller.gains();
    let (planner, _) = controller.planner.described();
    let source = match controller.pose_source {
        PoseSource::EncoderPose => "the encoders' pose",
        PoseSource::CableLengths => "the cable lengths",
    };
    let ends = |column: &[f64]| (column[0], column[column.len() - 1]);
    let (start, end) = ends(&history.run.times);
    let mut facts = vec![
        ("Controller", model(&info.controller)),
        ("Plant", model(&info.plant)),
        ("Rig", info.rig.clone()),
        ("Robot", robot(history)),
        (
            "Law",
            format!(
                "λ = {} 1/s, η = {} 1/s: ω = {:.3} 1/s, ξ = {:.3}; reads {source}; load-cell force loop {}",
                gains.lambda,
                gains.eta,
                gains.omega_n(),
                gains.xi(),
                if controller.force_loop { "closed" } else { "open" }
            ),
        ),
        match &info.orbit {
            Some(orbit) => ("Orbit", orbit.to_string()),
            None => (
                "Planner",
                format!(
                    "{planner}, T_s = {} s, N = {}",
                    controller.planner_period, controller.bisection_steps
                ),
            ),
        },
        ("Tension limits", limits(&controller.rig)),
        // Of a rig nobody measured them.
        (
            "Imperfections",
            match info.plant {
                Model::Rig => "not measured".to_owned(),
                Model::Library | Model::Fmu { .. } => format!(
                    "friction {} N, motor lag {} s, encoder resolution {} m, load-cell noise {} N (seed {})",
                    plant.friction,
                    plant.motor_lag,
                    plant.encoder_resolution,
                    plant.load_cell_noise,
                    plant.noise_seed
                ),
            },
        ),
        (
            "Disturbance",
            match (&info.plant, history.disturbance) {
                (Model::Rig, _) => "not measured".to_owned(),
                (_, [0.0, 0.0]) => "none".to_owned(),
                (_, [force, torque]) => format!("up to {force:.3} N and {torque:.3} N m"),
            },
        ),
        (
            "Time",
            format!(
                "{} to {} s in steps of {} s, {} rows",
                microseconds(start),
                microseconds(end),
                info.step,
                digest.rows
            ),
        ),
        ("Written by", format!("cable-robot {}", info.program_version)),
    ];
    if let Some(scenario) = &info.scenario {
        facts.insert(0, ("Scenario", scenario.clone()));
    }
    let smallest = summary.smallest_tension.map_or("none recorded".to_owned(), |s| s.to_string());
    let last = history.len() - 1;
    let missed = history.pose[last].minus(&history.goal[last]);
    let from =
        if history.goals().is_empty() { "From the start at the end" } else { "From the goal at the end" };
    facts.extend(goals(history));
    facts.extend(unreachable(history));
    facts.extend(faults(digest));
    facts.extend([
        ("Smallest tension", smallest),
        ("Slack cables", slack_in_words(&summary.slack)),
        (from, format!("{:.4} m", missed.fixed_rows::<3>(0).norm())),
    ]);
    facts
}

/// Table I, or mass and number of cables.
/// A time in s without what binary fractions add to it.
fn microseconds(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

fn robot(history: &History) -> String {
    let rig = &history.info.plant_parameters.rig;
    match &history.paper {
        Some(robot) => format!(
            "a = {} m, b = {} m, m = {} kg, I = ({}, {}, {}) kg m², g = {} m/s²",
            robot.a, robot.b, robot.m, robot.i1, robot.i2, robot.i3, robot.g
        ),
        None => {
            let [x, y, z] = [0, 1, 2].map(|k| rig.inertia[(k, k)]);
            format!(
                "{} cables, m = {} kg, I = ({x}, {y}, {z}) kg m², g = {:.4} m/s²",
                rig.cables.len(),
                rig.mass,
                rig.gravity.norm()
            )
        }
    }
}

/// The limits of all cables, the tightest where they differ.
pub fn limits(rig: &Rig) -> String {
    let common = rig.common_limits();
    let differ =
        if rig.limits().iter().all(|limits| *limits == common) { "" } else { ", the tightest of all cables" };
    match common.max.is_finite() {
        true => format!("{} to {} N{differ}", common.min, common.max),
        false => format!("{} N and more{differ}", common.min),
    }
}

fn model(model: &Model) -> String {
    match model {
        Model::Library => "the library's own".to_owned(),
        Model::Rig => "a rig with drives and load cells".to_owned(),
        Model::Fmu { path, name, fmi_version } => {
            format!("{name}, FMI {fmi_version}, {}", path.display())
        }
    }
}

/// A row a goal; of more than [`MOST_GOALS`] the first ones.
fn goals(history: &History) -> Vec<(&'static str, String)> {
    let goals = history.goals();
    let mut rows: Vec<_> =
        goals.iter().take(MOST_GOALS).map(|goal| ("Goal", arrival(history, goal))).collect();
    if goals.len() > MOST_GOALS {
        rows.push(("Goals", first_of(MOST_GOALS, goals.len(), "goals")));
    }
    rows
}

/// A row a fault; of more than [`MOST_FAULTS`] the first ones.
fn faults(digest: &Digest) -> impl Iterator<Item = (&'static str, String)> {
    let faults = digest.events.iter().filter(|event| event.kind == Kind::Fault).take(MOST_FAULTS);
    faults.map(|fault| ("Fault", format!("at {:.3} s: {}", fault.time, fault.text)))
}

/// What is said below a list that ends before its time.
pub fn first_of(listed: usize, count: usize, what: &str) -> String {
    format!("The first {listed} of {count} {what} are listed; run.csv has all.")
}

/// Why the last goal cannot be reached, if the controller said so: where the robot holds, and which cable forbids that it rests at the goal.
fn unreachable(history: &History) -> Option<(&'static str, String)> {
    if history.last_status() != Some(Status::GoalUnreachable) {
        return None;
    }
    let (goal, nearest) = (history.goal.last()?, history.set_point.last()?);
    let why = why_unreachable(&history.info.controller_parameters, goal, nearest);
    let left = (goal.position() - nearest.position()).norm();
    Some((
        "Goal unreachable",
        format!("{why}; the last set point is {left:.4} m from it, {}", rounded_pose(nearest)),
    ))
}

/// Why a controller cannot have a goal to which `nearest` is as near as it comes: which cable forbids that the robot rests there.
pub fn why_unreachable(parameters: &ControllerParameters, goal: &Pose, nearest: &Pose) -> String {
    let planner = Planner::from(*parameters);
    match barrier(&parameters.rig, goal) {
        Some(Barrier { cable, limit, is_greatest: true }) => {
            format!("at rest at the goal cable {cable} would pull more than its {limit} N")
        }
        Some(Barrier { cable, limit: 0.0, .. }) => {
            format!("at rest at the goal cable {cable} would be slack")
        }
        Some(Barrier { cable, limit, .. }) => {
            format!("at rest at the goal cable {cable} would pull less than its {limit} N")
        }
        None if planner.is_kept_by_rate(nearest, goal) => {
            let rate = parameters.max_tension_rate;
            format!("maxTensionRate = {rate} N/s is too small for a motion to it")
        }
        None if !planner.is_firm(goal) => {
            "at rest at the goal the tensions would be too large for the platform's inertia to be held there"
                .to_owned()
        }
        None => "at rest at the goal no limit is broken, but the planner has no step to it".to_owned(),
    }
}

/// The same to a tenth of a millimetre and of a milliradian.
fn rounded_pose(at: &Pose) -> String {
    pose_in_words(&Pose(at.0.map(|c| (c * 1e4).round() / 1e4 + 0.0)))
}

/// When a goal was given and how long the robot took.
fn arrival(history: &History, (row, arrival): &(usize, Arrival)) -> String {
    let given = history.run.times[*row];
    let after = match arrival {
        Arrival::After(time) => format!("reached after {time:.3} s"),
        Arrival::Replaced(time) => format!("replaced after {time:.3} s, before it was reached"),
        Arrival::Never => "not reached".to_owned(),
    };
    format!("{} given at {given:.3} s: {after}", pose_in_words(&history.goal[*row]))
}

/// Position in m, and angles in rad if there are any.
pub fn pose_in_words(pose: &Pose) -> String {
    let [p, angles] = [pose.position(), pose.angles()].map(|v| format!("({}, {}, {})", v.x, v.y, v.z));
    if pose.angles().amax() == 0.0 {
        format!("{p} m")
    } else {
        format!("{p} m, roll, pitch, yaw {angles} rad")
    }
}

/// Each slack cable with its first time and for how long.
pub fn slack_in_words(slack: &[Slack]) -> String {
    let cables: Vec<_> = slack.iter().map(Slack::to_string).collect();
    if cables.is_empty() { "none".to_owned() } else { cables.join("; ") }
}
