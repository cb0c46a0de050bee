//! Where `Exact` makes for: the goal, or, if the robot cannot rest there, the nearest pose at which it can.

use nalgebra::{DMatrix, DVector, Vector3};

use super::bisection::smallest_admissible;
use super::exact::Way;
use super::interface::ControllerParameters;
use super::nearest::{nearest_admissible, workspace_facets};
use super::planner::{FAR, Planner, STEEPEST, horizontal, is_upright};
use crate::reach::quadratic_program::minimise;
use crate::robot::dynamics::static_tensions;
use crate::robot::pose::PITCH;
use crate::robot::{CABLES, PerCable, Pose};

/// Halvings of the straight way to the goal in the search for the last pose on it at which the robot can rest.
const HALVINGS: i32 = 52;
/// Steps towards the nearest pose, each at the cost of one to three small quadratic programmes, and how far the first may go, in parts of a.
const MOST_STEPS: usize = 20;
const FIRST_REACH: f64 = 0.2;
/// A step that may go no farther than this, in parts of a, is the last.
const LAST_REACH: f64 = 1e-6;
/// Corrections of a step that ended outside, because the limits are not straight.
const CORRECTIONS: usize = 2;
/// Tension that the programmes keep beside what they must, as a part of the weight, so that rounding does not matter.
const SPARE: f64 = 1e-6;
/// For differences of tensions and ways, m and rad.
const DIFFERENCE: f64 = 1e-6;

impl Planner {
    /// Where `Exact` makes for: the goal, or if the robot cannot rest there, a pose where it can, with twice the margin that it keeps on the
    /// way, so that it is not caught on the edge. For a goal with zero orientation the nearest one at the goal's height, if there is
    /// any; for others the nearest one found in all six coordinates from the last one on the straight way from `from`. A goal at or above
    /// the base, or lower than anything, is not made for.
    pub fn exact_aim(&self, from: &Pose, goal: &Pose) -> Pose {
        let allowance = self.allowance();
        if self.rests_at(goal, allowance) {
            return *goal;
        }
        let far = FAR * self.parameters.robot.a;
        if goal.0[2] <= 0.0 || goal.0[2] > far {
            return *from;
        }
        let kept = 2.0 * allowance;
        let level = if is_upright(goal) { self.level_aim(goal, allowance, kept) } else { None };
        level.unwrap_or_else(|| {
            let near = within_reach(from, goal, far);
            let on_the_way = self.last_rest(from, &near, kept);
            self.nearest_rest(on_the_way, &near, kept, 6)
        })
    }

    /// The last pose on the straight way at which the robot can rest, but for `from`.
    fn last_rest(&self, from: &Pose, to: &Pose, kept: f64) -> Pose {
        let way = Way { from, goal: to };
        let beta = smallest_admissible(HALVINGS, |beta| self.rests_at(&way.at(beta), kept));
        if beta < 1.0 { way.at(beta) } else { *from }
    }

    /// `None` if there is no such point or the solver gives no answer.
    fn level_aim(&self, goal: &Pose, allowance: f64, kept: f64) -> Option<Pose> {
        let ControllerParameters { robot, min_tension, .. } = &self.parameters;
        let middle = Pose::at(0.0, 0.0, goal.0[2]);
        if !self.rests_at(&middle, kept) {
            return None;
        }
        // G = g (a/2 - n·p) at rest, and u ≥ u_min where G ≥ 3 a u_min/m.
        let margin = 3.0 * robot.a * (min_tension + kept) / (robot.m * robot.g);
        let near = within_reach(&middle, goal, FAR * robot.a);
        let place = nearest_admissible(&horizontal(&near), &workspace_facets(robot), margin).ok()??;
        let mut aim = *goal;
        aim.0.fixed_rows_mut::<2>(0).copy_from(&place.point);
        if self.rests_at(&aim, allowance) {
            return Some(aim);
        }
        // The upper limit forbids it, which is no polygon.
        Some(self.nearest_rest(self.last_rest(&middle, &aim, kept), &near, kept, 2))
    }

    /// Goes from `start`, at which the robot rests with `kept` to spare, to where no pose round about is nearer to `goal`, in the first
    /// `free` coordinates. Each step minimises the distance over the tensions' tangents (clarabel), within a reach that shrinks when
    /// that gains nothing: every pose on the way can be rested at and is nearer than the one before.
    fn nearest_rest(&self, start: Pose, goal: &Pose, kept: f64, free: usize) -> Pose {
        let (mut at, mut reach) = (start, FIRST_REACH * self.parameters.robot.a);
        for _ in 0..MOST_STEPS {
            if reach < LAST_REACH * self.parameters.robot.a || !self.rests_at(&at, kept) {
                break;
            }
            let distance = self.distance(&at, goal);
            match self
                .nearer(&at, goal, kept, free, reach)
                .filter(|next| self.distance(next, goal) < distance)
            {
                Some(next) => at = next,
                None => reach *= 0.25,
            }
        }
        at
    }

    /// One step; `None` if it does not end at a pose at which the robot can rest.
    fn nearer(&self, at: &Pose, goal: &Pose, kept: f64, free: usize, reach: f64) -> Option<Pose> {
        let mut next = self.tangent_step(at, Some(goal), kept, free, reach)?;
        for _ in 0..CORRECTIONS {
            if self.rests_at(&next, kept) {
                break;
            }
            next = self.tangent_step(&next, None, kept, free, reach)?;
        }
        self.rests_at(&next, kept).then_some(next)
    }

    /// The pose nearest to `goal`, or to `at` if there is none, whose tensions are within the limits as far as tangents tell.
    fn tangent_step(
        &self,
        at: &Pose,
        goal: Option<&Pose>,
        kept: f64,
        free: usize,
        reach: f64,
    ) -> Option<Pose> {
        let tangents = Tangents::new(self, at, free)?;
        let target = goal.map_or(DVector::zeros(free), |goal| tangents.towards(&self.ways(at, goal)));
        // In units of the reach.
        let unit = target.amax().max(reach);
        let slope: Vec<f64> = target.iter().map(|t| -t / unit).collect();
        let (rows, bounds) = self.bounds_of(&tangents, at, kept, reach);
        let optimum = minimise(&vec![reach / unit; free], &slope, &rows, &bounds).ok()??;
        let step = tangents.lower.tr_solve_lower_triangular(&(DVector::from_vec(optimum.x) * reach))?;
        let mut next = *at;
        (0..free).for_each(|k| next.0[k] += step[k]);
        Some(next)
    }

    /// What the tensions' limits, the pitch and the reach ask of y, in units of the reach: rows and bounds.
    fn bounds_of(&self, tangents: &Tangents, at: &Pose, kept: f64, reach: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
        let ControllerParameters { robot, min_tension, max_tension, .. } = &self.parameters;
        let free = tangents.lower.nrows();
        let kept = kept + SPARE * robot.m * robot.g;
        let mut asked = vec![];
        for (pull, here) in tangents.pulls.row_iter().map(|row| row.transpose()).zip(tangents.here) {
            asked.push((-&pull, here - (min_tension + kept)));
            asked.push((pull, max_tension - kept - here));
        }
        if free > PITCH {
            let pitch = DVector::from_fn(free, |k, _| f64::from(u8::from(k == PITCH)));
            asked.push((-&pitch, STEEPEST + at.0[PITCH]));
            asked.push((pitch, STEEPEST - at.0[PITCH]));
        }
        let (mut rows, mut bounds) = (vec![], vec![]);
        for (row, bound) in asked {
            // Of y instead of d, and of length one.
            let row = tangents.lower.solve_lower_triangular(&row).unwrap_or(row);
            let size = row.norm().max(f64::MIN_POSITIVE);
            rows.push((row / size).as_slice().to_vec());
            bounds.push(bound / (size * reach));
        }
        for k in 0..2 * free {
            rows.push((0..free).map(|j| if j != k / 2 { 0.0 } else { [1.0, -1.0][k % 2] }).collect());
            bounds.push(1.0);
        }
        (rows, bounds)
    }
}

/// What a small step d in the free coordinates does.
///
/// The square of the distance of `Planner::distance` from a goal is |J d - r|²/6, with the ways r of the attachments to the goal; with J'J/6 = L L' and
/// y = L' d it is |y - L⁻¹J'r/6|² and a constant.
struct Tangents {
    /// Tensions at rest, N, and what they change by, N/m and N/rad.
    here: PerCable<f64>,
    pulls: DMatrix<f64>,
    /// J: what the attachments move by, three rows each.
    slopes: DMatrix<f64>,
    /// L.
    lower: DMatrix<f64>,
}

impl Tangents {
    fn new(planner: &Planner, at: &Pose, free: usize) -> Option<Self> {
        let tensions = |pose: &Pose| static_tensions(&planner.parameters.robot, &planner.geometry, pose);
        let (mut pulls, mut slopes) = (DMatrix::zeros(CABLES, free), DMatrix::zeros(3 * CABLES, free));
        for k in 0..free {
            let moved = |by: f64| {
                let mut pose = *at;
                pose.0[k] += by;
                pose
            };
            let (before, after) = (moved(-DIFFERENCE), moved(DIFFERENCE));
            let rise = DVector::from(tensions(&after)?.to_vec()) - DVector::from(tensions(&before)?.to_vec());
            pulls.set_column(k, &(rise / (2.0 * DIFFERENCE)));
            slopes.set_column(k, &(stacked(&planner.ways(&before, &after)) / (2.0 * DIFFERENCE)));
        }
        let lower = (slopes.tr_mul(&slopes) / CABLES as f64).cholesky()?.l();
        Some(Self { here: tensions(at)?, pulls, slopes, lower })
    }

    /// L⁻¹J'r/6.
    fn towards(&self, ways: &PerCable<Vector3<f64>>) -> DVector<f64> {
        let target = self.slopes.tr_mul(&stacked(ways)) / CABLES as f64;
        self.lower.solve_lower_triangular(&target).unwrap_or(target)
    }
}

fn stacked(ways: &PerCable<Vector3<f64>>) -> DVector<f64> {
    DVector::from_iterator(3 * CABLES, ways.iter().flat_map(|way| [way.x, way.y, way.z]))
}

/// The goal, or if it is farther than `far` the pose at that distance in its direction.
fn within_reach(from: &Pose, goal: &Pose, far: f64) -> Pose {
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
    use crate::robot::Coordinates;

    fn planner(max_tension: f64) -> Planner {
        Planner::from(ControllerParameters { max_tension, ..Default::default() })
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
            let aim = planner.exact_aim(&Pose::default(), &goal);
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

    /// The last pose on the straight way was called the nearest.
    #[test]
    fn no_pose_round_about_is_nearer_to_a_turned_goal() {
        let mut rng = Pcg64::seed_from_u64(46);
        for goal in [
            turned(0.1, 0.0, 1.0, 0.0, 0.0, 1.2),
            turned(0.05, 0.0, 1.0, 0.0, 0.0, 1.3),
            turned(0.3, -0.1, 0.8, 0.2, -0.3, 0.5),
            turned(-0.104, -0.22247706, 0.3, -0.0099, -0.0099, -0.0099),
        ] {
            let planner = planner(100.0);
            let aim = planner.exact_aim(&Pose::default(), &goal);
            let (kept, found) = (2.0 * planner.allowance(), planner.distance(&aim, &goal));
            let straight = planner.distance(&planner.last_rest(&Pose::default(), &goal, kept), &goal);
            assert!(planner.rests_at(&aim, kept) && found <= straight, "{found} m, straight on {straight} m");
            let mut least = found;
            for _ in 0..200_000 {
                let size = 10f64.powf(rng.random_range(-4.0..-0.5));
                let near = Pose(aim.0 + Coordinates::from_fn(|_, _| rng.random_range(-size..size)));
                let distance = planner.distance(&near, &goal);
                if distance < least && planner.rests_at(&near, kept) {
                    least = distance;
                }
            }
            println!("{goal:?}: {found:.5} m, straight on {straight:.5} m, by chance {least:.5} m, {aim:?}");
            assert!(least > found - 2e-4, "{found} m, by chance {least} m");
        }
    }
}
