//! `MinimumTime`: courses, and what they leave to the limits for what is not in the way itself. Derived in docs/minimum-time.md.

use arrayvec::ArrayVec;

use super::arc::Timing;
use super::course::{self, Course, Leg};
use super::holding::cost_of_holding;
use super::line::Line;
use super::path::{Path, Work, narrowed_at_first};
use super::smooth::Gentle;
use super::sum::Sum;
use super::track::{MOST_SECTIONS, Track};
use crate::control::{Sensitivity, static_tensions};
use crate::plan::exact::{LEFT, Way};
use crate::plan::margins::Unknown;
use crate::plan::planner::{Planner, Situation};
use crate::reach::Curve;
use crate::reach::certificate::along::Seen;
use crate::reach::certificate::section::Section;
use crate::robot::{Coordinates, LEAST_CABLES, Pose, Shape};

/// What counts as level, rad: rounding of rigs that stand turned.
const LEVEL: f64 = 1e-9;
/// Where holding the commands costs more than was left for it, a leg is planned again, with this many times as much.
const MORE: f64 = 1.05;
const PLANS: usize = 2;
/// Where the whole way is not proved, so much of it is tried.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Errors and disturbances are looked at where a leg begins and ends, about rest: in between they cost at most this many times as much, errors also as many times as
/// the cables pull more.
const BETWEEN: f64 = 2.0;

/// Instants looked at in the time that stopping first and going on then takes: the more where what they show is not proved in between.
const INSTANTS: [f64; 2] = [12.0, 24.0];

/// A stop that a motion is added to brakes so many times less hard than it could: that leaves tensions some of their range for the motion.
const GENTLER: f64 = 1.7;

/// Heights of a bent way that are looked at.
const HEIGHTS: i32 = 9;

/// Of the pose and the rates, from a reference.
pub(in crate::plan) type Error = (Coordinates, Coordinates);

/// A motion along a way, what holding the commands costs on it, and the greatest tension, N.
struct Timed {
    way: course::Way,
    timing: Timing,
    held: f64,
    greatest: f64,
    /// What else is left to the limits, N.
    disturbed: f64,
    /// As of a [`Leg`].
    gentle: Option<(Gentle, f64)>,
}

/// A motion that is added to a course.
struct Added<'a> {
    base: &'a Course,
    path: Path,
    timing: Timing,
    /// What it is to leave to the limits, N.
    kept: f64,
    /// Time between two looks at the tensions, s.
    stride: f64,
}

/// What a motion must leave to the limits, N.
struct Margins {
    /// What the error at the beginning costs, about rest, but for what comes of what is not known.
    of_error: f64,
    /// What is not known,
    unknown: Unknown,
    /// and what the observer has found of it.
    found: f64,
    /// The greatest tension at rest,
    at_rest: f64,
    /// and what can be left there.
    most: f64,
}

impl Margins {
    /// What to leave where cables pull `greatest` and `spare` is needed besides what is not known. Where less is left at rest, no more is asked for.
    fn kept(&self, spare: f64, greatest: f64) -> f64 {
        (self.unknown(greatest) + spare).min(self.most)
    }

    fn unknown(&self, greatest: f64) -> f64 {
        self.unknown.when_followed((greatest / self.at_rest).max(1.0), self.found)
    }

    /// What is needed besides where holding costs `held` and cables pull `greatest`: a shift costs the more the more they pull.
    fn spare(&self, held: f64, greatest: f64) -> f64 {
        self.of_error * BETWEEN.max(greatest / self.at_rest) + held
    }

    fn are_kept(&self, kept: f64, held: f64, greatest: f64) -> bool {
        let unknown = self.unknown(greatest).min(LEFT * self.most);
        unknown + self.spare(held, greatest) <= kept
    }
}

impl Planner {
    /// The course by way of `via` to `goal` that begins at `begin` (s): from rest, or from the course `under_way` by way of a stop; or as much of it as is proved, with where that
    /// ends. `None` where nothing is, and while the robot is too far from the reference.
    pub(in crate::plan) fn course(
        &self,
        now: &Situation,
        under_way: Option<&Course>,
        begin: f64,
        (via, goal): (&[Pose], &Pose),
    ) -> Option<(Course, Pose)> {
        let is_worth_it = !via.is_empty() || self.is_worth_it(now.set_point, goal);
        if !is_worth_it || now.hold > self.parameters.longest_hold() {
            return None;
        }
        if let Some(course) = under_way.filter(|course| begin < course.end()) {
            if course.is_for(goal) {
                return None;
            }
            let stopped = course.stopped(self.rig(), begin);
            let reference = course.at(begin);
            let error = (now.pose.minus(&reference.pose), now.rates - reference.rates);
            let from = stopped.end_pose();
            let (leg, to) = self.as_far_as(now, &error, (&from, via, goal), stopped.end())?;
            let is_direct = via.is_empty() && to == *goal;
            let added = is_direct.then(|| self.added(now, &error, course, (begin, &leg), goal));
            return match added.flatten() {
                Some(added) => Some((added, to)),
                None => Some((stopped.and(leg, goal)?, to)),
            };
        }
        // A robot that is not at rest there yet is in error: as much as the leg can bear.
        let error = (now.pose.minus(now.set_point), *now.rates);
        let (leg, to) = self.as_far_as(now, &error, (now.set_point, via, goal), begin)?;
        Some((Course::new(leg, goal), to))
    }

    /// The course to `goal` that is added to a stop from `begin` (s) on, or to the course under way itself, whichever is sooner; `None` where neither is proved to be
    /// there before the leg `after` a stop is.
    fn added(
        &self,
        now: &Situation,
        error: &Error,
        course: &Course,
        (begin, after): (f64, &Leg),
        goal: &Pose,
    ) -> Option<Course> {
        // What the sum's speed is, and how fast its tensions change, nothing says; and with more cables it takes too long to find.
        let is_limited = self.greatest_speed(1.0, 1.0).is_finite() || self.parameters.max_tension_rate > 0.0;
        if is_limited || self.rig().cables.len() > LEAST_CABLES {
            return None;
        }
        let stop = course.stopped_in_steps(self.rig(), begin).gentler(begin, GENTLER);
        let bases = [stop, course.going_on(begin)];
        for instants in INSTANTS {
            let stride = (after.end() - begin) / instants;
            let added = |base| self.added_to(base, (begin, after.end()), stride, goal);
            let mut sums: ArrayVec<Added, 2> = bases.iter().filter_map(added).collect();
            if sums.is_empty() {
                return None;
            }
            sums.sort_by(|a, b| a.timing.duration.total_cmp(&b.timing.duration));
            let proved = sums.into_iter().find_map(|sum| self.proved_sum(sum, now, error, (begin, goal)));
            if proved.is_some() {
                return proved;
            }
        }
        None
    }

    /// The fastest way to `goal` that is added to a course from `begin` (s) on; `None` where it is not there before `end` (s).
    fn added_to<'a>(
        &self,
        base: &'a Course,
        (begin, end): (f64, f64),
        stride: f64,
        goal: &Pose,
    ) -> Option<Added<'a>> {
        let rest = base.end_pose();
        if base.end() >= end || !self.is_worth_it(&rest, goal) {
            return None;
        }
        let kept = base.kept() - of_lines(base) * narrowed_at_first(self.rig());
        let way = Track::straight(&rest, goal);
        let path = Path { way, limits: self.limits(kept), fastest: f64::INFINITY };
        let timing = Sum::new(self.rig(), base.legs(), &path, stride).fastest(begin, end)?;
        Some(Added { base, path, timing, kept, stride })
    }

    /// The course with it, where that is proved and leaves enough to the limits.
    fn proved_sum(
        &self,
        Added { base, path, timing, kept, stride }: Added,
        now: &Situation,
        error: &Error,
        (begin, goal): (f64, &Pose),
    ) -> Option<Course> {
        let mut seen = Seen::none(self.rig());
        let sum = Sum::new(self.rig(), base.legs(), &path, stride);
        if !sum.is_proved(begin, &timing, &mut Work::of_a_decision(), &mut seen) {
            return None;
        }
        let margins = self.margins(error, &[base.end_pose(), *goal])?;
        let way = course::Way::Path(path);
        let held = self.cost_of(now.hold, [seen.first, seen.second, seen.change()])
            + self.cost_of_switches(&way, &timing, now.hold)?;
        let leg = Leg { way, timing, begin, held, kept, gentle: None };
        margins.are_kept(kept, held, seen.greatest()).then(|| base.clone().and(leg, goal))?
    }

    /// The leg by way of `via` to `goal`, or to the first of these, or a part of that.
    fn as_far_as(
        &self,
        now: &Situation,
        error: &Error,
        (from, via, goal): (&Pose, &[Pose], &Pose),
        begin: f64,
    ) -> Option<(Leg, Pose)> {
        if let [first, ..] = via {
            let through = self.leg_through(now, error, (from, via, goal), begin).map(|leg| (leg, *goal));
            return through.or_else(|| self.as_far_as(now, error, (from, &[], first), begin));
        }
        let mut work = Work::of_a_decision();
        PARTS.into_iter().find_map(|part| {
            let to = Way { from, goal }.at(1.0 - part);
            let is_meant = self.is_worth_it(from, &to) && self.rests_at(&to, 0.0);
            let leg = is_meant.then(|| self.leg(now, error, (from, &to), begin, &mut work))?;
            Some((leg?, to))
        })
    }

    /// The fastest motion between two poses at rest that leaves what is needed to the limits: straight, or bent upwards where that is quicker.
    fn leg(
        &self,
        now: &Situation,
        error: &Error,
        ends: (&Pose, &Pose),
        begin: f64,
        work: &mut Work,
    ) -> Option<Leg> {
        let places = [*ends.0, *ends.1];
        let straight = self.path(Track::straight(ends.0, ends.1));
        let bent = self.bent(ends, work);
        // With work of its own, so that what is not proved leaves enough for straight on.
        let mut own = Work::of_a_decision();
        let bent = bent.and_then(|path| self.leg_along(now, error, &places, &path, begin, &mut own));
        bent.or_else(|| self.leg_along(now, error, &places, &straight, begin, work))
    }

    /// The fastest motion by way of poses, on the smooth way through them.
    pub(in crate::plan) fn leg_through(
        &self,
        now: &Situation,
        error: &Error,
        (from, via, to): (&Pose, &[Pose], &Pose),
        begin: f64,
    ) -> Option<Leg> {
        if via.len() >= MOST_SECTIONS {
            return None;
        }
        let places = std::iter::once(from).chain(via).chain([to]).copied();
        let places: ArrayVec<Pose, { MOST_SECTIONS + 1 }> = places.collect();
        let way = Track::through(&places, self.rig().platform_radius())?;
        self.leg_along(now, error, &places, &self.path(way), begin, &mut Work::of_a_decision())
    }

    /// The fastest motion along a path by way of these places that leaves what is needed to the limits.
    fn leg_along(
        &self,
        now: &Situation,
        error: &Error,
        places: &[Pose],
        path: &Path,
        begin: f64,
        work: &mut Work,
    ) -> Option<Leg> {
        let last = places.last()?;
        let margins = self.margins(error, places)?;
        let spare = self.allowance().max(BETWEEN * margins.of_error);
        let mut kept = margins.kept(spare, margins.at_rest);
        for _ in 0..PLANS {
            let Timed { way, timing, held, greatest, disturbed, gentle } =
                self.timed((&places[0], last), path, kept, now.hold, work)?;
            // A ramp of s'' changes it in a step by what a step is of its width.
            let switched = gentle.map_or(1.0, |(_, width)| (now.hold / width).min(1.0));
            let held = held + switched * self.cost_of_switches(&way, &timing, now.hold)?;
            if margins.are_kept(kept, held, greatest) {
                return Some(Leg { way, timing, begin, held, kept: kept + disturbed, gentle });
            }
            kept = margins.kept(MORE * margins.spare(held, greatest), greatest);
        }
        None
    }

    /// What is to be left to the limits on a way by these places.
    fn margins(&self, error: &Error, places: &[Pose]) -> Option<Margins> {
        let (mut of_error, mut found, mut at_rest) = (0.0f64, 0.0f64, f64::INFINITY);
        for place in places {
            of_error = of_error.max(self.cost_of_error(place, error)?);
            found = found.max(self.cost_of_disturbance(place)?);
            at_rest = at_rest.min(self.greatest_at_rest(place)?);
        }
        let unknown = self.unknown_by(places);
        let of_error = (of_error - unknown.at_rest()).max(0.0);
        let most = (LEFT * self.known_margin_at(places.first()?)).max(0.0);
        Some(Margins { of_error, unknown, found, at_rest, most })
    }

    /// The fastest motion that keeps `spare` (N) from the limits, with commands that are held for `hold` (s): in closed form where that knows the way, else on a grid.
    fn timed(
        &self,
        ends: (&Pose, &Pose),
        path: &Path,
        spare: f64,
        hold: f64,
        work: &mut Work,
    ) -> Option<Timed> {
        let is_line =
            |shape: &Shape| path.way.is_straight() && is_level(shape, ends.0) && is_level(shape, ends.1);
        let rate = self.parameters.max_tension_rate;
        if rate > 0.0 {
            let path = Path { limits: self.limits(spare), ..path.clone() };
            return self.gently_along(path, self.gentle(rate, hold), hold, work);
        }
        // What is not known is reckoned about what the observer has found of it, which no line has in it.
        let shape = self.shape.filter(is_line).filter(|_| self.parameters.is_uncertain().is_none());
        let in_closed_form = shape.and_then(|shape| self.along_a_line(&shape, ends, spare, hold));
        in_closed_form.or_else(|| {
            let path = Path { limits: self.limits(spare), ..path.clone() };
            self.along_a_path(path, hold, work)
        })
    }

    /// Of the paper's robot without a turn. What is estimated to disturb is not in the closed form: more is left to the limits.
    fn along_a_line(
        &self,
        shape: &Shape,
        (from, to): (&Pose, &Pose),
        spare: f64,
        hold: f64,
    ) -> Option<Timed> {
        let disturbed = BETWEEN * self.cost_of_disturbance(from)?.max(self.cost_of_disturbance(to)?);
        let limits = self.rig().common_limits().shrunk(spare + disturbed);
        let [start, end] = [from, to].map(|pose| shape.to_paper(pose).position());
        let line = Line::new(&shape.robot, limits, &start, &end);
        let timing = line.fastest(0.0, self.greatest_speed(1.0, 0.0))?;
        let [first, second] = line.derivatives(&timing);
        let [change, greatest] = line.extent(&timing);
        let held = self.cost_of(hold, [first, second, change]);
        let section = Section::straight(from, &(to.minus(from) / line.length()));
        let way = course::Way::Line(line, section);
        Some(Timed { way, timing, held, greatest, disturbed, gentle: None })
    }

    /// A way of any rig, with the least that is left to the limits.
    fn path(&self, way: Track) -> Path {
        let [linear, angular] = way.steepest();
        let fastest = self.greatest_speed(linear, angular);
        Path { way, limits: self.limits(self.allowance()), fastest: fastest * fastest }
    }

    /// The way bent upwards by as much of `lift` half-way as makes it quickest, before anything is proved; `None` where straight on is quickest, and where that was
    /// looked for already.
    fn bent(&self, (from, to): (&Pose, &Pose), work: &mut Work) -> Option<Path> {
        let lift = self.parameters.lift;
        if lift == 0.0 || !work.may_bend() {
            return None;
        }
        let up = self.rig().gravity.try_normalize(0.0)? * -lift;
        let by = |k: i32| {
            let mut bump = Coordinates::zeros();
            bump.fixed_rows_mut::<3>(0).copy_from(&(up * (f64::from(k) / f64::from(HEIGHTS - 1))));
            let path = self.path(Track::bent(from, to, &bump));
            Some((k, path.quickest(self.rig())?, path))
        };
        let found = (0..HEIGHTS).filter_map(by).min_by(|a, b| a.1.total_cmp(&b.1))?;
        (found.0 > 0).then_some(found.2)
    }

    /// Along a way of any rig.
    fn along_a_path(&self, path: Path, hold: f64, work: &mut Work) -> Option<Timed> {
        let (timing, seen) = path.timed(self.rig(), work)?;
        let held = self.cost_of(hold, [seen.first, seen.second, seen.change()]);
        let (way, greatest) = (course::Way::Path(path), seen.greatest());
        Some(Timed { way, timing, held, greatest, disturbed: 0.0, gentle: None })
    }

    /// The same with tensions that change no faster than they may. What they change by within a step takes the place of their jumps.
    fn gently_along(&self, path: Path, gentle: Gentle, hold: f64, work: &mut Work) -> Option<Timed> {
        let (timing, width, seen) = path.timed_gently(self.rig(), &gentle, work)?;
        let jump = seen.change().min(seen.first * hold);
        let held = self.cost_of(hold, [seen.first, seen.second, jump]);
        let (way, greatest) = (course::Way::Path(path), seen.greatest());
        Some(Timed { way, timing, held, greatest, disturbed: 0.0, gentle: Some((gentle, width)) })
    }

    /// What is asked of a reference so that commands held for `hold` (s) change no faster than at `rate` (N/s), with what the law adds to take back what holding displaces.
    fn gentle(&self, rate: f64, hold: f64) -> Gentle {
        let (parameters, gains) = (&self.parameters, self.parameters.gains());
        let late = hold + parameters.command_delay;
        let of_law = if parameters.hold_compensation {
            gains.omega_n_squared() * hold * late / 4.0
        } else {
            (gains.lambda + gains.eta) * late
        };
        Gentle { rate: rate / (1.0 + of_law), apart: hold, margin: self.allowance() }
    }

    /// The greatest tension at rest, N.
    fn greatest_at_rest(&self, at: &Pose) -> Option<f64> {
        let tension = static_tensions(self.rig(), at, self.allowance())?;
        Some(tension.into_iter().fold(0.0, f64::max)).filter(|greatest| *greatest > 0.0)
    }

    /// What holding commands costs, N, where tensions have these derivatives and change by so much.
    fn cost_of(&self, hold: f64, [first, second, change]: [f64; 3]) -> f64 {
        let parameters = &self.parameters;
        if parameters.hold_compensation {
            let span = hold * (hold + parameters.command_delay);
            cost_of_holding(&parameters.gains(), span, [first, second, change])
        } else {
            self.share_of_holding(hold) * change
        }
    }

    /// What it costs, N, that a switch of s'' within an interval displaces the platform, by at most an eighth of what s'' changes by times h (h + d): an error that the law
    /// takes back as its gains allow, and that costs by itself where they are low.
    fn cost_of_switches(&self, way: &course::Way, timing: &Timing, hold: f64) -> Option<f64> {
        let by = hold * (hold + self.parameters.command_delay) / 8.0 * timing.change();
        let mut most = 0.0f64;
        for s in [0.0, timing.end] {
            let section = way.section(s);
            let error = (section.slope(s) * by, Coordinates::zeros());
            most = most.max(self.cost_of_error(&section.pose(s), &error)?);
        }
        Some(BETWEEN * most)
    }

    /// The greatest s', 1/s, of a way on which the platform moves by `linear` (m) and turns by `angular` (rad) for each unit of s. A cable's end moves
    /// no faster than its attachment.
    fn greatest_speed(&self, linear: f64, angular: f64) -> f64 {
        let parameters = &self.parameters;
        let of_cable = linear + angular * self.rig().platform_radius();
        let limits = [
            (parameters.max_speed, linear),
            (parameters.max_angular_rate, angular),
            (parameters.max_cable_speed, of_cable),
        ];
        let asked = limits.into_iter().filter(|(limit, way)| *limit > 0.0 && *way > 0.0);
        asked.map(|(limit, way)| limit / way).fold(f64::INFINITY, f64::min)
    }

    /// What an error that the law takes back changes a tension by at most, N, about a pose at rest.
    fn cost_of_error(&self, at: &Pose, (error, rates): &Error) -> Option<f64> {
        let gains = self.parameters.gains();
        let of_cables = Sensitivity::new(self.rig(), at)?.of_error(error, rates, &gains);
        let of_cable = |[b, c]: [f64; 2]| {
            let extremes = Curve { a: 0.0, b, c, d: 0.0 }.extremes(&gains);
            extremes.max.max(-extremes.min)
        };
        Some(of_cables.into_iter().map(of_cable).fold(0.0, f64::max))
    }

    /// What the estimated disturbance changes a tension by at most, N, at rest.
    fn cost_of_disturbance(&self, at: &Pose) -> Option<f64> {
        let disturbance = self.rig().disturbance;
        if disturbance == nalgebra::Vector6::zeros() {
            return Some(0.0);
        }
        Some(Sensitivity::new(self.rig(), at)?.of_wrench(&disturbance))
    }
}

/// A line takes all that its limits leave; what is added needs a little of it. 1 where a leg is one, else 0.
fn of_lines(course: &Course) -> f64 {
    f64::from(course.legs().iter().any(|leg| matches!(leg.way, course::Way::Line(..))))
}

fn is_level(shape: &Shape, pose: &Pose) -> bool {
    shape.to_paper(pose).minus(&Pose::default()).fixed_rows::<3>(3).amax() < LEVEL
}
