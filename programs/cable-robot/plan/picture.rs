//! A plan as a picture: base, static workspace, the way with its set points and their domains, what cannot be reached and what can.

use std::f64::consts::TAU;
use std::iter;

use cable_robot::plan::extremes::TensionAt;
use cable_robot::plan::minimum_time::Course;
use cable_robot::plan::sequence::Sequence;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
use cable_robot::reach::Slice;
use cable_robot::robot::{Coordinates, Pose, RigFile};
use nalgebra::Vector2;
use rayon::prelude::*;

use super::Plan;
use crate::command::figure::chart::{BLACK, COLOURS, Chart, GREY, Look, Panel, Series};
use crate::command::plane::{self, View};
use crate::command::progress::Progress;
use crate::command::workspace;

/// Rays to the border of a domain.
const RAYS: usize = 180;
/// Halvings of a ray: 5 m to 0.02 mm.
const HALVINGS: i32 = 18;
/// Instants of a motion that are drawn.
const INSTANTS: usize = 200;

/// What is drawn, in the base frame.
pub struct Shown<'a> {
    pub file: &'a RigFile,
    /// Start and set points, or the poses that are passed.
    pub points: Vec<Pose>,
    pub goal: Pose,
    pub path: Vec<Pose>,
    /// Of the points, from the first on: where a set point may be, m.
    pub domains: Vec<Vec<[f64; 2]>>,
    /// As near to the goal as one gets, where it cannot be reached.
    pub nearest: Option<Pose>,
    pub smallest: Option<TensionAt>,
    /// What is said below.
    pub text: String,
}

impl<'a> Shown<'a> {
    /// The set points to a goal.
    pub fn of(
        plan: &Plan,
        file: &'a RigFile,
        planned: &Sequence,
        parameters: &ControllerParameters,
        text: String,
    ) -> Self {
        let points: Vec<_> = iter::once(plan.from).chain(planned.set_points.iter().copied()).collect();
        let path = match plan.courses(planned, parameters) {
            courses if parameters.planner == PlannerKind::MinimumTime => {
                courses.iter().flatten().flat_map(path_of).collect()
            }
            _ => points.clone(),
        };
        let left = if planned.is_complete() { planned.set_points.len() } else { points.len() };
        let domains = match parameters.planner {
            PlannerKind::MinimumTime => vec![],
            PlannerKind::Bounded | PlannerKind::Exact => {
                let from = &points[..left.min(COLOURS.len())];
                let progress = Progress::new("drawing", from.len() as u64);
                let drawn = |from| {
                    let domain = domain(parameters, from);
                    progress.done(1);
                    domain
                };
                from.iter().map(drawn).collect()
            }
        };
        let nearest = planned.obstacle.as_ref().and_then(|obstacle| obstacle.nearest);
        let smallest = planned.smallest.map(|(_, smallest)| smallest);
        Self { file, points, goal: plan.to, path, domains, nearest, smallest, text }
    }

    /// The whole base, and beside it the way from near, or from the side if it does not keep its height.
    pub fn chart(&self) -> Chart {
        let (rig, start) = (&self.file.rig, self.points[0]);
        let is_level = self.way().all(|pose| (pose.0[2] - start.0[2]).abs() < 1e-6 * rig.radius());
        let border = workspace::border(self.file, &start);
        let level = |pose: &Pose| View::LEVEL.of(&pose.position());
        let anchors = plane::anchors(rig, View::LEVEL).into_iter().map(|(at, _)| at);
        let of_domains = self.domains.iter().flatten().copied();
        let all: Vec<_> =
            of_domains.chain(border.iter().copied()).chain(anchors).chain(self.way().map(level)).collect();
        let mut whole = View::LEVEL.panel(plane::side_seen(rig), all.iter().copied());
        whole.series.push(Series::new("workspace", Look::Region, GREY, border.clone()));
        self.draw_domains(&mut whole);
        plane::draw_base(&mut whole, rig, View::LEVEL);
        self.draw_way(&mut whole, View::LEVEL);
        plane::name_in_key(&mut whole, &["workspace", "domain", "set points"]);
        let second = if is_level { self.near(border) } else { self.aside() };
        let first = format!("{}; {}", self.file.name, plane::frame(rig));
        let mut text = vec![first, format!("workspace: at rest at {}", plane::level_of(&start))];
        if !self.domains.is_empty() {
            let of = format!("domain of a point (of {} here)", self.domains.len());
            text.push(of + ": where the planner may put the next set point from rest there, at that height and orientation");
        }
        text.extend(self.text.lines().map(str::to_owned));
        plane::chart(vec![whole, second], 2, &text)
    }

    fn way(&self) -> impl Iterator<Item = &Pose> {
        self.path.iter().chain(&self.points).chain(&self.nearest).chain([&self.goal])
    }

    /// The way alone, and what of the workspace and the domains is there.
    fn near(&self, border: Vec<[f64; 2]>) -> Panel {
        let way: Vec<_> = self.way().map(|pose| View::LEVEL.of(&pose.position())).collect();
        let mut panel = View::LEVEL.panel("the way", way.iter().copied());
        panel.series.push(Series::new("workspace", Look::Region, GREY, border));
        self.draw_domains(&mut panel);
        plane::clip(&mut panel);
        self.draw_way(&mut panel, View::LEVEL);
        self.name_points(&mut panel, View::LEVEL);
        panel
    }

    /// From the side on which more of the way is seen.
    fn aside(&self) -> Panel {
        let (rig, start) = (&self.file.rig, self.points[0]);
        let far = |k: usize| self.way().map(|pose| (pose.0[k] - start.0[k]).abs()).fold(0.0, f64::max);
        let view = View::upright(usize::from(far(1) > far(0)), rig);
        let anchors = plane::anchors(rig, view).into_iter().map(|(at, _)| at);
        let all: Vec<_> = anchors.chain(self.way().map(|pose| view.of(&pose.position()))).collect();
        let mut panel = view.panel("from the side", all.into_iter());
        plane::draw_base(&mut panel, rig, view);
        self.draw_way(&mut panel, view);
        self.name_points(&mut panel, view);
        panel
    }

    /// Each in the colour of the point that the step is from.
    fn draw_domains(&self, panel: &mut Panel) {
        for (i, (border, colour)) in self.domains.iter().zip(COLOURS).enumerate() {
            let name = if i == 0 { "domain".to_owned() } else { format!("domain of {i}") };
            let domain = Series::new(name, Look::Region, colour, border.clone());
            panel.series.push(domain);
        }
    }

    fn draw_way(&self, panel: &mut Panel, view: View) {
        let at = |pose: &Pose| view.of(&pose.position());
        let mut push = |name: &str, look, colour, poses: &[Pose]| {
            if !poses.is_empty() {
                let series = Series::new(name, look, colour, poses.iter().map(at).collect());
                panel.series.push(series);
            }
        };
        push("way", Look::Thin, BLACK, &self.path);
        if self.points.last().is_some_and(|end| *end != self.goal) {
            push("not had", Look::Dashed, COLOURS[4], &[self.points[self.points.len() - 1], self.goal]);
        }
        push("set points", Look::Dots, BLACK, &self.points);
        push("goal", Look::Crosses, COLOURS[4], &[self.goal]);
        push("nearest", Look::Rings, COLOURS[0], self.nearest.as_slice());
        if let Some(smallest) = self.smallest {
            push("least tension", Look::Rings, COLOURS[3], &[smallest.pose]);
        }
    }

    /// Start, goal, and the set points by their numbers in the plan.
    fn name_points(&self, panel: &mut Panel, view: View) {
        let at = |pose: &Pose| view.of(&pose.position());
        let set_points = self.points.iter().enumerate().skip(1).map(|(i, pose)| (at(pose), i.to_string()));
        let ends = [(at(&self.points[0]), "start".to_owned()), (at(&self.goal), "goal".to_owned())];
        plane::name_in_key(panel, &["goal", "nearest", "least tension"]);
        plane::name_points(panel, BLACK, ends.into_iter().chain(set_points));
    }
}

/// The set points that the planner may give next to a robot that rests at `from`, at that height and orientation: the ends of rays, m.
fn domain(parameters: &ControllerParameters, from: &Pose) -> Vec<[f64; 2]> {
    let planner = Planner::from(ControllerParameters { bisection_steps: HALVINGS, ..*parameters });
    let slice = Slice { rig: &parameters.rig, height: from.0[2], angles: from.angles() };
    let (low, high) = slice.extent();
    let farthest = |k: usize| {
        let azimuth = TAU * k as f64 / RAYS as f64;
        let mut goal = *from;
        let way = Vector2::new(azimuth.cos(), azimuth.sin()) * (high - low).norm();
        goal.0 += Coordinates::new(way.x, way.y, 0.0, 0.0, 0.0, 0.0);
        View::LEVEL.of(&planner.next_from_rest(from, &goal).unwrap_or(*from).position())
    };
    (0..RAYS).into_par_iter().map(farthest).collect()
}

pub fn path_of(course: &Course) -> Vec<Pose> {
    let time = |k: usize| course.end() * k as f64 / INSTANTS as f64;
    (0..=INSTANTS).map(|k| course.at(time(k)).pose).collect()
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::command::figure::draw::svg;
    use crate::command::plan::show;
    use crate::command::{Arguments, Task};

    fn drawn(arguments: &str) -> Chart {
        let words = ["cable-robot", "plan"].into_iter().chain(arguments.split(' '));
        let Task::Plan(plan) = Arguments::parse_from(words).task else { unreachable!() };
        let (file, parameters) = plan.rig.read_with_controller(plan.planner).unwrap();
        let planned = Sequence::new(&parameters, &plan.from, &plan.to).unwrap();
        let said = show::verdict(&plan, &planned, &parameters);
        Shown::of(&plan, &file, &planned, &parameters, said).chart()
    }

    fn points<'a>(chart: &'a Chart, panel: usize, name: &str) -> &'a [[f64; 2]] {
        let found = chart.panels[panel].series.iter().find(|series| series.name == name);
        found.map_or(&[], |series| &series.points)
    }

    /// Plotters would move a point beyond the axes to their edge without a word.
    #[test]
    fn every_point_of_a_plan_lies_within_its_axes() {
        for plan in [
            "--from 0,0,1 --to 0.15,0.15,1",
            "--from 0,0,1 --to 0,0.4,1",
            "--from 0,0,1 --to 0.1,0,0.8 --planner exact",
        ] {
            let chart = drawn(plan);
            for panel in &chart.panels {
                let holds = |range: &std::ops::Range<f64>, v: f64| {
                    let [low, high] = [range.start.min(range.end), range.start.max(range.end)];
                    (low - 1e-9..=high + 1e-9).contains(&v)
                };
                let size = |range: &std::ops::Range<f64>| (range.end - range.start).abs();
                assert!((size(&panel.x.range) - size(&panel.y.range)).abs() < 1e-9, "{plan}: scales");
                for [x, y] in panel.series.iter().flat_map(|series| &series.points) {
                    assert!(holds(&panel.x.range, *x) && holds(&panel.y.range, *y), "{plan}: ({x}, {y})");
                }
            }
        }
    }

    /// Its corners stand in docs/command-line.md.
    #[test]
    fn the_domain_of_the_start_is_the_hexagon_15() {
        let chart = drawn("--from 0,0,1 --to 0.15,0.15,1");
        assert_eq!(points(&chart, 0, "set points").len(), 5);
        let domain = points(&chart, 0, "domain");
        for [x, y] in [[0.1355, 0.0], [0.0677, 0.1173], [-0.0677, 0.1173], [0.0677, -0.1173]] {
            let gap = domain.iter().map(|[u, v]| (x - u).hypot(y - v)).fold(1.0, f64::min);
            assert!(gap < 1e-4, "({x}, {y}): {gap}");
        }
        let farthest = domain.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
        assert!(farthest < 0.1356, "{farthest}");
        assert!(points(&chart, 1, "nearest").is_empty());
    }

    #[test]
    fn a_goal_that_cannot_be_had_is_drawn_with_the_nearest_point_and_the_reason() {
        let chart = drawn("--from 0,0,1 --to 0,0.4,1 --planner exact");
        assert_eq!(points(&chart, 1, "goal"), [[0.0, 0.4]]);
        let nearest = points(&chart, 1, "nearest");
        assert!(nearest.len() == 1 && (nearest[0][1] - 0.2204).abs() < 1e-4, "{nearest:?}");
        let picture = svg(&chart).unwrap();
        for said in
            ["held back by cable 2", "z points down, seen from below", "x (m)", "prefers-color-scheme: dark"]
        {
            assert!(picture.contains(said), "{said}");
        }
    }
}
