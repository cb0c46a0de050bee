//! A plan as text for people and as JSON.

use std::fmt::Write;

use cable_robot::plan::ControllerParameters;
use cable_robot::plan::PlannerKind;
use cable_robot::plan::extremes::{Extremes, TensionAt};
use cable_robot::plan::planner::{FAR, Planner, STEEPEST};
use cable_robot::plan::sequence::{MOST_SET_POINTS, Obstacle, Sequence};
use cable_robot::robot::Pose;
use cable_robot::robot::pose::PITCH;
use cable_robot_report::facts::limits;

use super::Plan;
use crate::command::metres;

pub fn as_text(plan: &Plan, planned: &Sequence, parameters: &ControllerParameters) -> String {
    set_points(plan, planned) + &verdict(plan, planned, parameters)
}

/// What comes of it, without the set points.
pub fn verdict(plan: &Plan, planned: &Sequence, parameters: &ControllerParameters) -> String {
    let mut text = String::new();
    if let Some((step, u)) = planned.smallest {
        let _ = writeln!(text, "smallest tension: {} in step {step}", described(&u));
    }
    if let Some(duration) = planned.duration {
        let _ = writeln!(text, "takes {duration:.4} s");
    }
    if planned.given_up {
        let at = planned.set_points.last().unwrap_or(&plan.from);
        let left = distance(plan, parameters, at);
        let _ = writeln!(
            text,
            "given up after {MOST_SET_POINTS} set points at {}, {} m from the goal: whether more of them lead there is not known",
            place_of(at),
            metres(left).trim()
        );
    } else if let Some(obstacle) = &planned.obstacle {
        text += "the goal cannot be reached\n";
        explain(&mut text, plan, obstacle, parameters);
    } else {
        text += "the goal is reached\n";
    }
    text
}

/// The table of the set points; angles only where there are any.
fn set_points(plan: &Plan, planned: &Sequence) -> String {
    let points = || std::iter::once(&plan.from).chain(&planned.set_points);
    let turned = points().any(|point| point.0.fixed_rows::<3>(3).amax() > 0.0);
    let mut text = String::from("set points\n  i      x (m)     y (m)     z (m)");
    text += if turned { " roll (rad)     pitch       yaw\n" } else { "\n" };
    for (i, point) in points().enumerate() {
        let shown = if turned { 6 } else { 3 };
        let row: Vec<_> = point.0.iter().take(shown).map(|coordinate| metres(*coordinate)).collect();
        let _ = writeln!(text, "  {i:<3} {}", row.join(" "));
    }
    text
}

/// Why the goal cannot be reached, and what can.
fn explain(text: &mut String, plan: &Plan, obstacle: &Obstacle, parameters: &ControllerParameters) {
    if obstacle.singular {
        *text +=
            "  at the goal the wrench matrix is singular: there is a force or torque that no tensions give\n";
    }
    let is_level = (plan.to.0[2] - plan.from.0[2]).abs() <= parameters.rest().position;
    let key = parameters.planner.key();
    let is_of_bounded = parameters.planner == PlannerKind::Bounded && (plan.is_turned() || !is_level);
    if is_of_bounded {
        if plan.is_turned() {
            *text += "  the goal is turned: planner bounded keeps zero orientation, planner exact does not\n";
        }
        if !is_level {
            *text += "  it is at another height: planner bounded keeps the height of the start, planner exact does not\n";
        }
    }
    let is_steep = plan.to.0[PITCH].abs() >= STEEPEST;
    if is_steep {
        let _ = writeln!(
            text,
            "  it is pitched by {STEEPEST} rad or more, where the angles hardly tell the orientation"
        );
    }
    if !Planner::from(*parameters).is_near(&plan.to) {
        let far = metres(FAR * parameters.rig.radius());
        let _ = writeln!(
            text,
            "  it is farther than {} m ({FAR} radii of the rig) from the anchors, where nothing is looked for",
            far.trim()
        );
    }
    match &obstacle.broken {
        Some(broken @ Extremes { first_outside: Some(first), .. }) => {
            let _ = writeln!(
                text,
                "  the step from the last set point straight to it breaks the limits ({}): {}",
                limits(&parameters.rig),
                described(first)
            );
            let above = first.tension > parameters.rig.cables[first.cable - 1].limits.max;
            if !obstacle.singular {
                let worst = if above { &broken.greatest } else { &broken.smallest };
                let _ = writeln!(text, "  and is worst with {}", described(worst));
            }
        }
        _ if obstacle.is_kept_by_rate => {
            let rate = parameters.max_tension_rate;
            let _ = writeln!(
                text,
                "  maxTensionRate = {rate} N/s is too small for a motion on from there: 0 limits no rate"
            );
        }
        _ if obstacle.barrier.is_some() || is_steep || is_of_bounded => {}
        _ => {
            let why = match parameters.planner {
                PlannerKind::Bounded => "every tension at rest keeps 0.17 % of the weight from its limits",
                PlannerKind::Exact | PlannerKind::MinimumTime => {
                    "every tension keeps 0.17 % of the weight from its limits, and more on quick steps"
                }
            };
            let _ = writeln!(text, "  planner {key} has no step to it: {why}");
        }
    }
    match &obstacle.nearest {
        Some(nearest) => {
            let left = distance(plan, parameters, nearest);
            let _ =
                writeln!(text, "  nearest: {}, {} m from the goal", place_of(nearest), metres(left).trim());
        }
        None => {
            let _ =
                writeln!(text, "  no other point can be reached from there in {MOST_SET_POINTS} set points");
        }
    }
    if let Some((limit, at)) = &obstacle.barrier {
        let breach = match (limit.is_greatest, limit.limit) {
            (true, limit) => format!("above {limit} N"),
            (false, 0.0) => "slack".to_owned(),
            (false, limit) => format!("below {limit} N"),
        };
        let cable = limit.cable;
        let _ = writeln!(text, "  held back by cable {cable}, at rest {breach} from {} on", place_of(at));
    } else if obstacle.is_loose {
        *text += "  at rest no limit is broken between there and the goal, but the tensions become too large for the platform's inertia to be held\n";
    } else if obstacle.broken.is_some() && obstacle.is_tight {
        *text += "  at rest no limit is broken between there and the goal, but less than the planner keeps, 0.17 % of the weight, is left\n";
    }
}

/// From a pose to the goal, m.
fn distance(plan: &Plan, parameters: &ControllerParameters, pose: &Pose) -> f64 {
    Planner::from(*parameters).distance(pose, &plan.to)
}

pub fn described(u: &TensionAt) -> String {
    format!("{:.3} N in cable {} after {:.3} s at {}", u.tension, u.cable, u.time, place_of(&u.pose))
}

/// x, y, z, and the angles if there are any.
fn place_of(pose: &Pose) -> String {
    let shown = if pose.0.fixed_rows::<3>(3).amax() > 0.0 { 6 } else { 3 };
    let coordinates: Vec<_> = pose.0.iter().take(shown).map(|c| metres(*c).trim().to_owned()).collect();
    format!("({})", coordinates.join(", "))
}
