//! What the page's scripts draw: the robot, the plane, and the drawn rows of the history, as JSON.

use std::borrow::Cow;

use serde::Serialize;

use super::digest::Digest;
use super::domains::domain;
use super::events::{Kind, StateSpan, state_spans};
use super::explanation;
use super::history::History;
use super::thinning::rounded;
use super::workspace::{Section, workspace};
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::robot::triangles::FACET_NORMALS;
use cable_robot::robot::{Pose, Rig};

/// Steps to the unit in which positions (m), angles (rad) and times (s) are given.
const FINE: f64 = 1e6;
/// Steps to a newton.
const NEWTON: f64 = 1e4;
/// More set points or goals than these are no longer told apart: the first ones are listed, and drawn is what the drawn rows show.
pub const MANY: usize = 100;

/// Lengths in m, tensions in N, times in s, `row` an index into the drawn rows.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Data {
    anchors: Vec<[f64; 3]>,
    attachments: Vec<[f64; 3]>,
    /// Whether gravity points against z.
    z_up: bool,
    /// Normals of the facets of the static workspace, of the paper's rig only.
    normals: Vec<[f64; 2]>,
    /// Both ends of each facet.
    facets: Vec<[[f64; 2]; 2]>,
    /// Distance of the facets from the middle.
    apothem: f64,
    /// Outline of the static workspace, and at which height it is drawn: of the paper's rig at that of the base, where p is.
    workspace: Section,
    /// At some heights round where the platform went, for the picture in space; nothing until they are put in.
    pub sections: Vec<Section>,
    limits: Limits,
    /// Greatest tension measured, and the one from which on a cable has the last colour: that follows from the rig, so that runs can be
    /// compared.
    tension_top: f64,
    colour_top: f64,
    /// Names of the statuses from number 1 on.
    statuses: [Cow<'static, str>; 7],
    /// Those active in a drawn row.
    set_points: Vec<SetPoint>,
    /// Number of the last set point.
    last_set_point: usize,
    /// More than [`MANY`]: drawn as a line.
    many_set_points: bool,
    /// Those that hold in a drawn row.
    goals: Vec<Goal>,
    /// From when to when a cable was slack.
    slack_spans: Vec<[f64; 2]>,
    /// From when to when the platform was disturbed.
    disturbed_spans: Vec<[f64; 2]>,
    /// From when to when a rig's platform was not measured.
    unmeasured_spans: Vec<[f64; 2]>,
    /// The states of a rig's bridge in which the controller does not pull.
    state_spans: Vec<StateSpan>,
    /// When something was found wrong.
    faults: Vec<f64>,
    /// Of the run, which may be after its last row.
    end: f64,
    rows: Rows,
}

#[derive(Serialize)]
struct Limits {
    min: f64,
    /// None where nothing limits the tensions.
    max: Option<f64>,
    /// What the planner keeps from them at least, for what is not in its motion.
    kept: f64,
}

#[derive(Serialize)]
struct SetPoint {
    number: usize,
    row: usize,
    pose: [f64; 6],
    /// Outline of the domain that it was chosen from.
    domain: Option<Vec<[f64; 2]>>,
}

#[derive(Serialize)]
struct Goal {
    row: usize,
    pose: [f64; 6],
}

/// A column a quantity.
#[derive(Serialize)]
struct Rows {
    time: Vec<f64>,
    pose: [Vec<f64>; 6],
    /// What the law followed, where that is not the set point; `None` if it is everywhere.
    reference: Option<[Vec<Option<f64>>; 6]>,
    tension: Vec<Vec<f64>>,
    predicted: Option<Vec<Vec<Option<f64>>>>,
    /// Bit i is set where cable i + 1 is slack.
    slack: Vec<u32>,
    margin: Vec<f64>,
    p: [Vec<Option<f64>>; 2],
    status: Option<Vec<i32>>,
}

impl Data {
    /// Of a digest with at least one row, and its history.
    pub fn new(digest: &Digest, history: &History) -> Self {
        let (set_points, goals) = (history.set_point_rows(), history.goal_rows());
        let drawn = shown(&digest.drawn, &set_points, &goals);
        let place = |row: usize| drawn.partition_point(|k| *k < row);
        let rig = &history.info.plant_parameters.rig;
        let limits = history.info.controller_parameters.rig.common_limits();
        let facets = history.paper.map_or(vec![], |_| FACET_NORMALS.to_vec());
        let apothem = history.paper.map_or(0.0, |robot| robot.a / 2.0);
        let chosen = |i: usize| SetPoint {
            number: i,
            row: place(set_points[i]),
            pose: shortened(&history.set_point[set_points[i]]),
            domain: (1..MANY)
                .contains(&i)
                .then(|| domain(history, set_points[i - 1], set_points[i]))
                .flatten()
                .map(|outline| outline.iter().map(|point| point.map(|x| rounded(x, FINE))).collect()),
        };
        let goal = |i: usize| Goal { row: place(goals[i]), pose: shortened(&history.goal[goals[i]]) };
        let tension = history.run.tension.iter().flatten();
        let end = digest.end(history);
        let faults = digest.events.iter().filter(|event| event.kind == Kind::Fault);
        Self {
            anchors: rig.cables.iter().map(|cable| cable.anchor.into()).collect(),
            attachments: rig.cables.iter().map(|cable| cable.attachment.into()).collect(),
            z_up: rig.gravity.z < 0.0,
            normals: facets.iter().map(|normal| (*normal).into()).collect(),
            facets: facets.iter().map(|normal| facet((*normal).into(), apothem)).collect(),
            apothem,
            workspace: workspace(history, rig),
            sections: vec![],
            limits: Limits {
                min: limits.min,
                max: limits.max.is_finite().then_some(limits.max),
                kept: kept(&history.info.controller_parameters),
            },
            tension_top: tension.copied().fold(f64::MIN_POSITIVE, f64::max),
            colour_top: colour_top(rig, limits.max),
            statuses: Status::ALL.map(Status::in_words),
            set_points: active(&set_points, &drawn).into_iter().map(chosen).collect(),
            last_set_point: set_points.len() - 1,
            many_set_points: set_points.len() > MANY,
            goals: active(&goals, &drawn).into_iter().map(goal).collect(),
            slack_spans: digest.slack_spans.clone(),
            disturbed_spans: history.disturbed_spans().to_vec(),
            unmeasured_spans: unmeasured(digest, history, end),
            state_spans: state_spans(&digest.events, end),
            faults: faults.map(|event| event.time).collect(),
            end,
            rows: Rows::new(history, &drawn),
        }
    }

    /// How many rows are drawn.
    pub fn rows(&self) -> usize {
        self.rows.time.len()
    }
}

impl Rows {
    fn new(history: &History, drawn: &[usize]) -> Self {
        let run = &history.run;
        let of = |column: &[f64], steps| drawn.iter().map(|row| rounded(column[*row], steps)).collect();
        let points: Vec<_> = drawn.iter().map(|row| explanation::moving_point(history, *row)).collect();
        let mask =
            |row: &usize| (0..run.slack.len()).map(|i| u32::from(run.slack[i][*row] != 0.0) << i).sum();
        let newtons = |u: Vec<Option<f64>>| u.iter().map(|u| u.map(|u| rounded(u, NEWTON))).collect();
        let cables = run.tension.len();
        Self {
            time: of(&run.times, FINE),
            pose: std::array::from_fn(|k| {
                drawn.iter().map(|row| rounded(history.pose[*row].0[k], FINE)).collect()
            }),
            reference: reference(history, drawn),
            tension: run.tension.iter().map(|column| of(column, NEWTON)).collect(),
            predicted: explanation::predicted(history, drawn)
                .map(|rows| explanation::columns(&rows, cables).into_iter().map(newtons).collect()),
            slack: drawn.iter().map(mask).collect(),
            margin: of(&run.tension_margin, NEWTON),
            p: [0, 1].map(|k| points.iter().map(|p| p.map(|p| rounded(p[k], FINE))).collect()),
            status: history.status.as_ref().map(|status| drawn.iter().map(|row| status[*row]).collect()),
        }
    }
}

fn reference(history: &History, drawn: &[usize]) -> Option<[Vec<Option<f64>>; 6]> {
    let references = history.reference.as_ref()?;
    let leads = |row: &usize| {
        let (reference, set_point) = (&references[*row].pose, &history.set_point[*row]);
        (history.law_at_work(*row) && set_point.minus(reference).amax() > 1.0 / FINE).then_some(reference)
    };
    drawn.iter().any(|row| leads(row).is_some()).then(|| {
        let column = |k: usize| {
            drawn.iter().map(|row| leads(row).map(|reference| rounded(reference.0[k], FINE))).collect()
        };
        std::array::from_fn(column)
    })
}

/// From when to when there are no rows of a rig, to the end of the run.
fn unmeasured(digest: &Digest, history: &History, end: f64) -> Vec<[f64; 2]> {
    let mut spans = digest.unmeasured_spans.clone();
    spans.extend(history.run.times.last().filter(|last| **last < end).map(|last| [*last, end]));
    spans
}

/// What the planner keeps from the limits of tension at least, N: of `Bounded` only the set points do.
pub fn kept(parameters: &ControllerParameters) -> f64 {
    match parameters.planner {
        PlannerKind::Bounded => 0.0,
        PlannerKind::Exact | PlannerKind::MinimumTime => Planner::from(*parameters).allowance(),
    }
}

/// Which of what begins at the rows `starts` hold at one of the rows `drawn`, in order.
fn active(starts: &[usize], drawn: &[usize]) -> Vec<usize> {
    let mut active: Vec<_> =
        drawn.iter().map(|row| starts.partition_point(|start| start <= row) - 1).collect();
    active.dedup();
    active
}

/// The rows that are drawn: what a digest draws anyhow, new set points and goals, unless there are [`MANY`], and the instants before them.
fn shown(drawn: &[usize], set_points: &[usize], goals: &[usize]) -> Vec<usize> {
    let jumps = [set_points, goals].into_iter().filter(|rows| rows.len() <= MANY).flatten();
    let mut shown = drawn.to_vec();
    shown.extend(jumps.flat_map(|row| [row.saturating_sub(1), *row]));
    shown.sort_unstable();
    shown.dedup();
    shown
}

/// A share of the weight that a cable seldom bears, or the limit if that is less, N.
pub fn colour_top(rig: &Rig, limit: f64) -> f64 {
    (3.0 * rig.weight() / rig.cables.len() as f64).min(limit)
}

/// Both ends of the side of a regular hexagon whose outward normal this is.
fn facet(normal: [f64; 2], apothem: f64) -> [[f64; 2]; 2] {
    let half = apothem / 3f64.sqrt();
    [half, -half].map(|s| [normal[0] * apothem - normal[1] * s, normal[1] * apothem + normal[0] * s])
}

fn shortened(pose: &Pose) -> [f64; 6] {
    std::array::from_fn(|k| rounded(pose.0[k], FINE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::run;

    #[test]
    fn the_reference_is_drawn_where_it_is_not_the_set_point() {
        let folder = run(PlannerKind::Bounded, 1.0, 0.0);
        let history = History::new(&folder).unwrap();
        assert_eq!(reference(&history, &[0, 500, 1000]), None, "it rests at the set point");

        let folder = run(PlannerKind::MinimumTime, 1.0, 0.0);
        let history = History::new(&folder).unwrap();
        let moving = history.run.times.iter().position(|time| *time > 0.3).unwrap();
        let [x, ..] = reference(&history, &[0, moving, 700]).unwrap();
        assert_eq!([x[0], x[2]], [None, None], "before and after the motion");
        assert!((x[1].unwrap() - history.pose[moving].0[0]).abs() < 1e-3, "{x:?}");
        assert!((x[1].unwrap() - history.set_point[moving].0[0]).abs() > 0.01, "{x:?}");
    }

    #[test]
    fn what_is_kept_of_the_limits_is_what_the_planner_keeps() {
        let kept_by = |planner| kept(&ControllerParameters { planner, ..Default::default() });
        assert_eq!(kept_by(PlannerKind::Bounded), 0.0);
        let weight = ControllerParameters::default().rig.weight();
        assert!((kept_by(PlannerKind::MinimumTime) - 0.0017 * weight).abs() < 1e-12);
    }
}
