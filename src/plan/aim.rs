//! Where `Exact` makes for: the goal, or, if the robot cannot rest there, the nearest pose at which it can.
//!
//! The search goes on from step to step of the controller, a bounded amount of work in each.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::exact::Way;
use super::planner::{Planner, horizontal, is_upright};
use super::tangents::Tangents;
use crate::control::active_set::{Outcome, Programme, Row};
use crate::reach::static_workspace;
use crate::robot::memory::are_finite;
use crate::robot::{Pose, Shape};

/// Halvings of the straight way to the goal in the search for the last pose on it at which the robot can rest.
const HALVINGS: i32 = 52;
/// Steps towards the nearest pose, and how far the first may go, as a share of the rig's radius.
const MOST_STEPS: usize = 20;
const FIRST_REACH: f64 = 0.17;
/// A step that may go no farther than this share of the radius is the last.
const LAST_REACH: f64 = 1e-6;
/// Corrections of a step that ended outside, because the limits are not straight.
const CORRECTIONS: usize = 2;

/// Work of a search in one step of the controller, in looks at whether the robot can rest at a pose,
pub(super) const WORK: usize = 60;
/// and what a step over the tensions' tangents counts.
const TANGENT_WORK: usize = 15;

/// A search that may not have ended yet. Every pose that it has been at is one where the robot can rest, but for the first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// The goal asked for.
    pub goal: Pose,
    /// The best pose found so far.
    pub at: Pose,
    /// The goal, or if that is too far away the pose at the farthest distance in its direction.
    target: Pose,
    /// How many of the coordinates are free to change.
    free: usize,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Stage {
    /// Halving the way from a pose to another for the last at which the robot can rest.
    OnTheWay {
        from: Pose,
        to: Pose,
        below: f64,
        above: f64,
        left: i32,
    },
    /// Going nearer over tangents.
    Nearing {
        reach: f64,
        left: usize,
    },
    Ended,
}

impl Search {
    /// Whether `at` is the answer.
    pub fn has_ended(&self) -> bool {
        self.stage == Stage::Ended
    }

    /// Whether a run can have left this.
    pub(super) fn is_sound(&self) -> bool {
        let poses = [&self.goal, &self.at, &self.target];
        poses.into_iter().all(|pose| are_finite(&pose.0))
            && match self.stage {
                Stage::OnTheWay { from, to, below, above, left } => {
                    [2, 3, 6].contains(&self.free)
                        && are_finite(&from.0)
                        && are_finite(&to.0)
                        && 0.0 <= below
                        && below <= above
                        && above <= 1.0
                        && (0..=HALVINGS).contains(&left)
                }
                Stage::Nearing { reach, left } => {
                    [2, 3, 6].contains(&self.free) && reach.is_finite() && reach >= 0.0 && left <= MOST_STEPS
                }
                Stage::Ended => true,
            }
    }

    pub(super) fn ended(goal: &Pose, at: &Pose) -> Self {
        Self { goal: *goal, at: *at, target: *goal, free: 0, stage: Stage::Ended }
    }
}

impl Planner {
    /// Begins the search for where `Exact` makes for: the goal, or if the robot cannot rest there, a pose where it can, with twice the
    /// margin that it keeps on the way, so that it is not caught on the edge. For a goal of the paper's robot with zero orientation the
    /// nearest one at the goal's height, if there is any; for others the nearest one found from the last one on the straight way from
    /// `from`, with zero orientation if both have that. A goal beyond the anchors, or lower than anything, is not made for.
    pub(super) fn nearest_rest(&self, from: &Pose, goal: &Pose) -> Search {
        if self.rests_at(goal, self.allowance()) {
            return Search::ended(goal, goal);
        }
        let down = self.rig().gravity.try_normalize(0.0).unwrap_or_default();
        if !self.rig().can_be_at(goal) || (goal.position() - from.position()).dot(&down) > self.far {
            return Search::ended(goal, from);
        }
        if let Some(level) = self.level_search(goal) {
            return level;
        }
        let target = within(from, goal, self.far);
        let free = if is_upright(from) && is_upright(goal) { 3 } else { 6 };
        Search { goal: *goal, at: *from, target, free, stage: on_the_way(from, &target) }
    }

    /// For the paper's robot and a goal with zero orientation; `None` otherwise, or if there is no such point.
    fn level_search(&self, goal: &Pose) -> Option<Search> {
        let shape = self.shape.filter(|shape| is_upright(&shape.to_paper(goal)))?;
        let kept = 2.0 * self.allowance();
        let mut in_plane = shape.to_paper(goal);
        let middle = shape.to_rig(&Pose::at(0.0, 0.0, in_plane.0[2]));
        if !self.rests_at(&middle, kept) {
            return None;
        }
        let target = within(&middle, goal, self.far);
        // G = g (a/2 - n·p) at rest, and u ≥ u_min where G ≥ 3 a u_min/m.
        let least = self.rig().common_limits().min + kept + self.unknown_at(&middle);
        let margin = 3.0 * shape.robot.a * least / (shape.robot.m * shape.robot.g);
        let place = nearest_inside(&shape, &horizontal(&shape.to_paper(&target)), margin)?;
        in_plane.0.fixed_rows_mut::<2>(0).copy_from(&place);
        let aim = shape.to_rig(&in_plane);
        if self.rests_at(&aim, self.allowance()) {
            return Some(Search::ended(goal, &aim));
        }
        // The upper limit forbids it, which is no polygon.
        let gravity = self.rig().gravity;
        let free = if gravity.x == 0.0 && gravity.y == 0.0 { 2 } else { 3 };
        Some(Search { goal: *goal, at: middle, target, free, stage: on_the_way(&middle, &aim) })
    }

    /// The whole search at once: where the planner makes for from rest at `from`.
    pub fn aim(&self, from: &Pose, goal: &Pose) -> Pose {
        let mut search = self.search(from, goal);
        while !search.has_ended() {
            self.advance(&mut search, WORK);
        }
        search.at
    }

    /// Goes on with the search, for no more than `work`.
    pub(super) fn advance(&self, search: &mut Search, mut work: usize) {
        let kept = 2.0 * self.allowance();
        while work > 0 {
            match search.stage {
                Stage::Ended => return,
                Stage::OnTheWay { .. } => {
                    work -= 1;
                    self.halve(search, kept);
                }
                Stage::Nearing { reach, left } => {
                    work = work.saturating_sub(TANGENT_WORK);
                    self.go_nearer(search, reach, left, kept);
                }
            }
        }
    }

    fn halve(&self, search: &mut Search, kept: f64) {
        let Stage::OnTheWay { from, to, below, above, left } = search.stage else { return };
        let way = Way { from: &from, goal: &to };
        let beta = if left == HALVINGS { 0.0 } else { 0.5 * (below + above) };
        let rests = self.rests_at(&way.at(beta), kept);
        let (below, above) = if rests { (below, beta) } else { (beta, above) };
        search.at = if above < 1.0 { way.at(above) } else { from };
        search.stage = if left == 0 || above == 0.0 {
            Stage::Nearing { reach: FIRST_REACH * self.radius(), left: MOST_STEPS }
        } else {
            Stage::OnTheWay { from, to, below, above, left: left - 1 }
        };
    }

    /// One step, to where the distance over the tensions' tangents is least, within a reach that shrinks when that gains nothing.
    fn go_nearer(&self, search: &mut Search, reach: f64, left: usize, kept: f64) {
        let distance = self.distance(&search.at, &search.target);
        let is_last = left == 0 || reach < LAST_REACH * self.radius() || distance == 0.0;
        if is_last || !self.rests_at(&search.at, kept) {
            search.stage = Stage::Ended;
            return;
        }
        let next = self
            .nearer(&search.at, &search.target, kept, search.free, reach)
            .filter(|next| self.distance(next, &search.target) < distance);
        let reach = match next {
            Some(next) => {
                search.at = next;
                reach
            }
            None => 0.25 * reach,
        };
        search.stage = Stage::Nearing { reach, left: left - 1 };
    }

    /// `None` if the step does not end at a pose at which the robot can rest.
    fn nearer(&self, at: &Pose, target: &Pose, kept: f64, free: usize, reach: f64) -> Option<Pose> {
        let within = kept + self.unknown_at(at);
        let mut next = Tangents::new(self, at, free)?.step(self, Some(target), within, reach)?;
        for _ in 0..CORRECTIONS {
            if self.rests_at(&next, kept) {
                break;
            }
            next = Tangents::new(self, &next, free)?.step(self, None, within, reach)?;
        }
        self.rests_at(&next, kept).then_some(next)
    }

    fn radius(&self) -> f64 {
        self.far / super::planner::FAR
    }
}

fn on_the_way(from: &Pose, to: &Pose) -> Stage {
    Stage::OnTheWay { from: *from, to: *to, below: 0.0, above: 1.0, left: HALVINGS }
}

/// The point nearest to `goal` (m, in the paper's plane) that is `margin` (m) inside every facet of the static workspace (16).
fn nearest_inside(shape: &Shape, goal: &Vector2<f64>, margin: f64) -> Option<Vector2<f64>> {
    let facets = static_workspace(&shape.robot);
    let normals = facets.map(|facet| {
        let mut normal = [0.0; crate::control::active_set::MOST_UNKNOWNS];
        (normal[0], normal[1]) = (facet.normal.x, facet.normal.y);
        normal
    });
    let mut normal = 0..;
    let rows = facets.map(|facet| Row {
        normal: normal.next().unwrap_or(0),
        sign: 1.0,
        bound: facet.slack(goal) - margin,
        compliance: 0.0,
    });
    let tolerance = f64::EPSILON * (goal.norm() + shape.robot.a);
    match (Programme { unknowns: 2, rank: 2, normals: &normals, rows: &rows, tolerance }).solve() {
        Outcome::Nearest(x) => Some(goal + Vector2::new(x[0], x[1])),
        _ => None,
    }
}

/// The goal, or if it is farther than `far` the pose at that distance in its direction.
fn within(from: &Pose, goal: &Pose, far: f64) -> Pose {
    let way = goal.position() - from.position();
    let longest = way.amax();
    let mut near = *goal;
    if longest > far {
        near.0.fixed_rows_mut::<3>(0).copy_from(&(from.position() + way / longest * far));
    }
    near
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::plan::{ControllerParameters, PlannerKind};
    use crate::robot::{Coordinates, RigFile, TensionLimits};

    fn planner(max: f64) -> Planner {
        let mut parameters = ControllerParameters { planner: PlannerKind::Exact, ..Default::default() };
        parameters.rig = parameters.rig.with_limits(TensionLimits { min: 0.0, max });
        Planner::from(parameters)
    }

    fn turned(x: f64, y: f64, z: f64, roll: f64, pitch: f64, yaw: f64) -> Pose {
        Pose(Coordinates::new(x, y, z, roll, pitch, yaw))
    }

    /// The upper limit was not known to it.
    #[test]
    fn is_the_nearest_point_of_a_grid_where_the_upper_limit_binds() {
        for (max, goal) in [
            (15.0, Pose::at(0.2, 0.05, 1.0)),
            (14.0, Pose::at(-0.2, 0.15, 1.1)),
            (15.0, Pose::at(3.0, 2.0, 0.9)),
        ] {
            let planner = planner(max);
            let aim = planner.aim(&Pose::default(), &goal);
            let kept = 2.0 * planner.allowance();
            assert!(planner.rests_at(&aim, kept), "{aim:?}");
            let mut nearest = f64::INFINITY;
            for i in -300..=300 {
                for j in -300..=300 {
                    let place = Pose::at(f64::from(i) * 1e-3, f64::from(j) * 1e-3, goal.0[2]);
                    if planner.rests_at(&place, kept) {
                        nearest = nearest.min(planner.distance(&place, &goal));
                    }
                }
            }
            let found = planner.distance(&aim, &goal);
            assert!(found < nearest + 1e-5 && found > nearest - 2e-3, "{found} m, on the grid {nearest} m");
        }
    }

    /// No pose drawn at random round about `aim` is nearer to the goal by more than `tolerance` (m).
    fn is_nearest(planner: &Planner, aim: &Pose, goal: &Pose, free: usize, tolerance: f64) {
        let mut rng = Pcg64::seed_from_u64(46);
        let (kept, found) = (2.0 * planner.allowance(), planner.distance(aim, goal));
        assert!(planner.rests_at(aim, 0.999 * kept), "{aim:?}");
        let mut least = found;
        for _ in 0..100_000 {
            let size = 10f64.powf(rng.random_range(-4.0..-0.5)) * planner.size;
            let by = Coordinates::from_fn(|k, _| if k < free { rng.random_range(-size..size) } else { 0.0 });
            let near = Pose(aim.0 + by);
            let distance = planner.distance(&near, goal);
            if distance < least && planner.rests_at(&near, kept) {
                least = distance;
            }
        }
        println!("{goal:?}: {found:.5} m, by chance {least:.5} m, {aim:?}");
        assert!(least > found - tolerance, "{goal:?}: {found} m, by chance {least} m");
    }

    /// The last pose on the straight way was called the nearest.
    #[test]
    fn no_pose_round_about_is_nearer_to_a_turned_goal() {
        for goal in [
            turned(0.1, 0.0, 1.0, 0.0, 0.0, 1.2),
            turned(0.05, 0.0, 1.0, 0.0, 0.0, 1.3),
            turned(0.3, -0.1, 0.8, 0.2, -0.3, 0.5),
            turned(-0.104, -0.22247706, 0.3, -0.0099, -0.0099, -0.0099),
        ] {
            let planner = planner(100.0);
            is_nearest(&planner, &planner.aim(&Pose::default(), &goal), &goal, 6, 2e-4);
        }
    }

    #[test]
    fn no_pose_round_about_is_nearer_for_eight_cables() {
        let file = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
        let planner = Planner::from(ControllerParameters::of(&file.rig));
        for goal in [Pose::at(2.5, 0.3, 2.0), Pose::at(0.0, 2.0, 1.0), Pose::at(-3.0, -2.0, 1.6)] {
            let aim = planner.aim(&file.home, &goal);
            assert!(is_upright(&aim), "{aim:?}");
            is_nearest(&planner, &aim, &goal, 3, 2e-3);
        }
        let goal = turned(1.0, 0.5, 2.0, 0.2, 0.9, -0.4);
        is_nearest(&planner, &planner.aim(&file.home, &goal), &goal, 6, 5e-3);
    }
}
