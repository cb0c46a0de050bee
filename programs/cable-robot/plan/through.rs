//! A plan by way of other poses, without a stop.

use std::fmt::Write;

use anyhow::Result;
use cable_robot::plan::ControllerParameters;
use cable_robot::plan::through::{NoWay, Through};
use cable_robot::robot::{Pose, RigFile};

use super::picture::{Shown, path_of};
use super::show::described;
use super::{Plan, answer, prove_motion};
use crate::command::figure::draw;
use crate::command::rig::require_below;
use crate::command::{Outcome, metres, print, print_json};

pub fn run(plan: &Plan, file: &RigFile, parameters: &ControllerParameters) -> Result<Outcome> {
    for pose in &plan.through {
        require_below(&parameters.rig, "--through", pose)?;
    }
    let poses: Vec<Pose> = [plan.from].iter().chain(&plan.through).chain([&plan.to]).copied().collect();
    let found = Through::new(parameters, &poses);
    if let (Ok(found), Some(folder)) = (&found, &plan.proof) {
        prove_motion(folder, &parameters.rig, vec![Some(found.course.clone())])?;
    }
    match (&found, plan.json) {
        (Err(NoWay::Poses), _) => return Err(NoWay::Poses.into()),
        (_, true) => print_json(&answer(&poses, &found))?,
        (_, false) => print(&as_text(&poses, &found))?,
    }
    if let Some(path) = &plan.svg {
        draw::write(path, &shown(file, &poses, &found).chart())?;
    }
    Ok(if found.is_ok() { Outcome::Done } else { Outcome::NotReachable })
}

/// When each pose is passed, s.
fn times(found: &Through) -> Vec<f64> {
    [0.0].into_iter().chain(found.course.passes()).chain([found.course.end()]).collect()
}

/// m/s.
fn speed(found: &Through, time: f64) -> f64 {
    found.course.at(time).rates.fixed_rows::<3>(0).norm()
}

fn shown<'a>(file: &'a RigFile, poses: &[Pose], found: &Result<Through, NoWay>) -> Shown<'a> {
    let made = found.as_ref().ok();
    Shown {
        file,
        points: poses.to_vec(),
        goal: poses[poses.len() - 1],
        path: made.map_or(vec![], |made| path_of(&made.course)),
        domains: vec![],
        nearest: None,
        smallest: made.map(|made| made.smallest),
        text: verdict(found),
    }
}

fn as_text(poses: &[Pose], found: &Result<Through, NoWay>) -> String {
    let Ok(made) = found else { return verdict(found) };
    let mut text = String::from(
        "passes\n  after (s)  speed (m/s)      x (m)     y (m)     z (m) roll (rad)     pitch       yaw\n",
    );
    for (pose, time) in poses.iter().zip(times(made)) {
        let row: Vec<_> = pose.0.iter().map(|coordinate| metres(*coordinate)).collect();
        let _ = writeln!(text, "  {time:9.4}  {:11.4}  {}", speed(made, time), row.join(" "));
    }
    text + &verdict(found)
}

/// What comes of it, without the poses that are passed.
fn verdict(found: &Result<Through, NoWay>) -> String {
    match found {
        Ok(found) => format!(
            "smallest tension: {}\nthe goal is reached, every tension on the way is proved to keep its limits\n",
            described(&found.smallest)
        ),
        Err(why) => format!("{why}\n"),
    }
}

fn answer(poses: &[Pose], found: &Result<Through, NoWay>) -> answer::Through {
    let made = found.as_ref().ok();
    let pass = |(at, time)| answer::Pass { pose: answer::pose(at), time };
    answer::Through {
        reachable: made.is_some(),
        passes: made.map(|made| poses.iter().zip(times(made)).map(pass).collect()),
        duration: made.map(|made| made.course.end()),
        smallest_tension: made.map(|made| answer::Tension::new(&made.smallest)),
        obstacle: found.as_ref().err().map(NoWay::to_string),
    }
}
