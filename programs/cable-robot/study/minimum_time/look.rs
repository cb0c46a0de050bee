//! What is found of the tensions of a planned motion: by the inverse dynamics of all six coordinates, and apart from that by polynomials.

use cable_robot::control::tensions;
use cable_robot::plan::minimum_time::{Line, Timing};
use cable_robot::robot::{Coordinates, Rig, TensionLimits};

use super::moves::Move;
use super::polynomial::Verdict;

/// Instants looked at on each arc, its ends among them.
pub const INSTANTS: u32 = 5;
/// Tensions may be outside their limits by this share of the weight: rounding. A motion may have gaps of this share of its extent between arcs.
pub const ROUNDING: f64 = 1e-9;
const GAP: f64 = 1e-6;

/// What was found in some motions.
#[derive(Clone, Copy)]
pub struct Found {
    pub motions: u64,
    /// With a tension outside its limits, or a jump between arcs.
    pub broken: u64,
    pub arcs: u64,
    pub instants: u64,
    /// Smallest distance of a tension from a limit as a share of the weight; negative outside.
    pub smallest: f64,
    /// Arcs that polynomials looked at, and of those the ones not decided and those with a tension outside its limits.
    pub pieces: u64,
    pub undecided: u64,
    pub refuted: u64,
}

impl Found {
    pub fn none() -> Self {
        Self {
            motions: 0,
            broken: 0,
            arcs: 0,
            instants: 0,
            smallest: f64::INFINITY,
            pieces: 0,
            undecided: 0,
            refuted: 0,
        }
    }

    pub fn and(self, other: Self) -> Self {
        Self {
            motions: self.motions + other.motions,
            broken: self.broken + other.broken,
            arcs: self.arcs + other.arcs,
            instants: self.instants + other.instants,
            smallest: self.smallest.min(other.smallest),
            pieces: self.pieces + other.pieces,
            undecided: self.undecided + other.undecided,
            refuted: self.refuted + other.refuted,
        }
    }

    /// In a motion along the way of `planned`, its own or a stop.
    pub fn in_motion(planned: &Move, timing: &Timing) -> Self {
        let mut found = Self { motions: 1, ..Self::none() };
        let rig = &planned.rig;
        for (arc, duration) in timing.spans() {
            let section = planned.section(arc);
            found.arcs += 1;
            for k in 0..INSTANTS {
                let [s, v, a] = arc.at(duration * f64::from(k) / f64::from(INSTANTS - 1));
                let (slope, bend) = (section.slope(s), section.bend(s));
                let accelerations = slope * a + bend * (v * v);
                let u = tensions(rig, &section.pose(s), &(slope * v), &accelerations, 0.0);
                let margins = u.iter().flat_map(|u| u.iter().zip(&rig.cables));
                let margin = margins.map(|(u, cable)| cable.limits.margin(*u)).fold(f64::INFINITY, f64::min);
                let is_number = u.is_some_and(|u| u.iter().all(|u| u.is_finite()));
                let margin = if is_number { margin } else { f64::NEG_INFINITY };
                found.instants += 1;
                found.smallest = found.smallest.min(margin / rig.weight());
            }
            if let Some(robot) = &planned.robot {
                let limits = rig.common_limits().shrunk(-ROUNDING * rig.weight());
                let verdict = planned.piece(arc, duration).verdict(robot, &limits);
                found.pieces += 1;
                found.undecided += u64::from(verdict == Verdict::Undecided);
                found.refuted += u64::from(verdict == Verdict::Broken);
            }
        }
        let is_kept = found.smallest >= -ROUNDING && found.refuted == 0 && is_whole(planned, timing);
        found.broken = u64::from(!is_kept);
        found
    }
}

/// Whether each arc begins where and as fast as the one before ends, the last at rest at the motion's end, which is on the way.
fn is_whole(planned: &Move, timing: &Timing) -> bool {
    // Of the way that is planned: a stop that begins nearly at rest has the rounding of the whole way.
    let fastest = planned.timing.arcs().iter().map(|arc| arc.v).fold(0.0, f64::max);
    let next = timing.arcs().iter().skip(1).map(|arc| [arc.s, arc.v]).chain([[timing.end, 0.0]]);
    let mut joints = timing.spans().zip(next).map(|((arc, duration), [s, v])| {
        let [at, speed, _] = arc.at(duration);
        (at - s).abs() <= GAP * planned.end() && (speed - v).abs() <= GAP * fastest
    });
    joints.all(|is_joined| is_joined) && timing.end <= planned.end() * (1.0 + ROUNDING)
}

/// By how much longer a motion along a line takes than the optimum with the limits themselves, as a share: on a grid of so many cells, the range of s'' in each from
/// the inverse dynamics in its middle.
pub fn excess(planned: &Move, line: &Line, cells: u32) -> Option<f64> {
    let h = line.length() / f64::from(cells);
    let ranges: Vec<[f64; 2]> =
        (0..cells).map(|k| range(planned, (f64::from(k) + 0.5) * h)).collect::<Option<_>>()?;
    // W = s'²/2 where the cells meet: forwards from rest, backwards from rest.
    let sum = |gains: Vec<f64>| {
        let mut total = 0.0;
        let sums = gains.into_iter().map(move |gain| {
            total += gain * h;
            total
        });
        std::iter::once(0.0).chain(sums).collect::<Vec<f64>>()
    };
    let up = sum(ranges.iter().map(|[_, most]| *most).collect());
    let down = sum(ranges.iter().rev().map(|[least, _]| -least).collect());
    let speed: Vec<f64> =
        up.iter().zip(down.iter().rev()).map(|(up, down)| (2.0 * up.min(*down)).sqrt()).collect();
    let best: f64 = speed.windows(2).map(|ends| 2.0 * h / (ends[0] + ends[1])).sum();
    Some(planned.timing.duration / best - 1.0)
}

/// The least and the greatest s'' at a place of a line, at rest or not: the tensions are affine in it. `None` where the robot cannot rest.
fn range(planned: &Move, s: f64) -> Option<[f64; 2]> {
    let section = planned.section(planned.timing.arcs().first()?);
    let (pose, slope, none) = (section.pose(s), section.slope(s), Coordinates::zeros());
    let rig: &Rig = &planned.rig;
    let (rest, one) = (tensions(rig, &pose, &none, &none, 0.0)?, tensions(rig, &pose, &none, &slope, 0.0)?);
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for ((rest, one), cable) in rest.iter().zip(&one).zip(&rig.cables) {
        let TensionLimits { min, max } = cable.limits;
        let mut ends = [(min - rest) / (one - rest), (max - rest) / (one - rest)];
        ends.sort_by(f64::total_cmp);
        if ends.iter().all(|end| !end.is_nan()) {
            (least, most) = (least.max(ends[0]), most.min(ends[1]));
        }
    }
    (least < 0.0 && most > 0.0).then_some([least, most])
}
