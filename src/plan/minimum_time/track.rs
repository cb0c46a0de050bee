//! A way through the six coordinates, s from 0 to 1: sections that join at places of the grid, with the same slope and the same bend.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

use super::path::{INTERVALS, place};
use crate::reach::certificate::section::Section;
use crate::robot::{Coordinates, Pose};

/// Sections of a way.
pub const MOST_SECTIONS: usize = 8;

const POINTS: usize = MOST_SECTIONS + 1;
/// Intervals of the grid that a section has at least.
const LEAST: usize = 4;

/// Sections in order of s; there is one at least, and the first begins at 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    sections: ArrayVec<Section, MOST_SECTIONS>,
}

impl Track {
    /// Straight on; angles the short way round.
    pub fn straight(from: &Pose, to: &Pose) -> Self {
        Self::of(Section::straight(from, &to.minus(from)))
    }

    /// The same, displaced by 4 s (1 - s) times `bump`: by `bump` half-way.
    pub fn bent(from: &Pose, to: &Pose, bump: &Coordinates) -> Self {
        let way = to.minus(from) + bump * 4.0;
        Self::of(Section { begin: 0.0, coefficients: [from.0, way, bump * -4.0, Coordinates::zeros()] })
    }

    /// The smooth way by these poses, a natural cubic spline over the distances between them: two poses at least, and at most [`MOST_SECTIONS`] sections. `None` for other
    /// numbers of poses, and where two that follow each other are the same; `radius` (m) is what an angle of 1 rad counts as.
    pub fn through(poses: &[Pose], radius: f64) -> Option<Self> {
        let sections = poses.len().checked_sub(1).filter(|count| (1..=MOST_SECTIONS).contains(count))?;
        let mut points: ArrayVec<Coordinates, POINTS> = [poses[0].0].into_iter().collect();
        let mut at: ArrayVec<f64, POINTS> = [0.0].into_iter().collect();
        for pair in poses.windows(2) {
            let way = pair[1].minus(&pair[0]);
            let length = way.fixed_rows::<3>(0).norm() + radius * way.fixed_rows::<3>(3).norm();
            if !(length.is_finite() && length > 0.0) {
                return None;
            }
            points.push(points[points.len() - 1] + way);
            at.push(at[at.len() - 1] + length);
        }
        let knots = on_the_grid(&at);
        let bends = bends(&points, &knots);
        let section = |k: usize| {
            let (h, [m0, m1]) = (knots[k + 1] - knots[k], [bends[k], bends[k + 1]]);
            let slope = (points[k + 1] - points[k]) / h - (m0 * 2.0 + m1) * (h / 6.0);
            Section { begin: knots[k], coefficients: [points[k], slope, m0 * 0.5, (m1 - m0) / (6.0 * h)] }
        };
        Some(Self { sections: (0..sections).map(section).collect() })
    }

    fn of(section: Section) -> Self {
        Self { sections: [section].into_iter().collect() }
    }

    /// Whether a run can have left this.
    pub(super) fn is_sound(&self) -> bool {
        !self.sections.is_empty() && self.sections.iter().all(Section::is_sound)
    }

    /// In order of s.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Whether it has no bend.
    pub fn is_straight(&self) -> bool {
        let [.., c, d] = self.sections[0].coefficients;
        self.sections.len() == 1 && c == Coordinates::zeros() && d == Coordinates::zeros()
    }

    /// The section that leads on from s.
    pub fn section(&self, s: f64) -> &Section {
        let before = self.sections.iter().rposition(|section| section.begin <= s);
        &self.sections[before.unwrap_or(0)]
    }

    /// Bounds of the speed (m) and of the sum of the angles' speeds (rad) where s' = 1.
    pub fn steepest(&self) -> [f64; 2] {
        let mut steepest = [0.0f64; 2];
        for (k, section) in self.sections.iter().enumerate() {
            let end = self.sections.get(k + 1).map_or(1.0, |next| next.begin);
            for slope in section.slopes(end) {
                let linear = slope.fixed_rows::<3>(0).norm();
                let angular = slope.fixed_rows::<3>(3).abs().sum();
                steepest = [steepest[0].max(linear), steepest[1].max(angular)];
            }
        }
        steepest
    }

    /// Where it is at s.
    pub fn pose(&self, s: f64) -> Pose {
        self.section(s).pose(s)
    }
}

/// The places of the grid nearest to these shares of the way, each section with [`LEAST`] intervals.
fn on_the_grid(at: &[f64]) -> ArrayVec<f64, POINTS> {
    let last = at.len() - 1;
    let mut before = 0;
    let knot = |k: usize| {
        let share = at[k] / at[last] * INTERVALS as f64;
        let most = INTERVALS - LEAST * (last - k);
        before = if k == 0 { 0 } else { (share.round() as usize).clamp(before + LEAST, most) };
        place(before)
    };
    (0..=last).map(knot).collect()
}

/// d²q/ds² where the sections join, zero at both ends, so that d q/ds has no jump: h₋ m₋ + 2 (h₋ + h₊) m + h₊ m₊ = 6 (Δ₊/h₊ - Δ₋/h₋), by elimination.
fn bends(points: &[Coordinates], knots: &[f64]) -> ArrayVec<Coordinates, POINTS> {
    let last = points.len() - 1;
    let h = |k: usize| knots[k + 1] - knots[k];
    let rate = |k: usize| (points[k + 1] - points[k]) / h(k);
    let mut eliminated: ArrayVec<(f64, Coordinates), POINTS> = ArrayVec::new();
    for k in 1..last {
        let right = (rate(k) - rate(k - 1)) * 6.0;
        let diagonal = 2.0 * (h(k - 1) + h(k));
        let (factor, known) = match eliminated.last() {
            Some((before, known)) => (diagonal - h(k - 1) * before, right - known * h(k - 1)),
            None => (diagonal, right),
        };
        eliminated.push((h(k) / factor, known / factor));
    }
    let mut bends: ArrayVec<Coordinates, POINTS> = points.iter().map(|_| Coordinates::zeros()).collect();
    for k in (1..last).rev() {
        let (share, known) = eliminated[k - 1];
        bends[k] = known - bends[k + 1] * share;
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_through_poses_meets_them_without_a_corner_and_without_a_jump_of_its_bend() {
        let poses = [
            Pose::at(0.0, 0.0, 1.0),
            Pose(Coordinates::new(0.1, 0.05, 0.9, 0.0, 0.1, 3.1)),
            Pose(Coordinates::new(0.12, -0.1, 1.1, 0.1, 0.0, -3.1)),
            Pose::at(-0.1, -0.1, 1.0),
        ];
        let track = Track::through(&poses, 0.3).unwrap();
        let sections = &track.sections;
        assert_eq!(sections.len(), 3);
        let ends = sections.iter().skip(1).map(|next| next.begin).chain([1.0]);
        for (k, (section, end)) in sections.iter().zip(ends).enumerate() {
            assert!(section.pose(section.begin).minus(&poses[k]).amax() < 1e-12);
            assert!(section.pose(end).minus(&poses[k + 1]).amax() < 1e-12);
            assert_eq!((section.begin * INTERVALS as f64).fract(), 0.0);
            if let Some(next) = sections.get(k + 1) {
                assert!((next.slope(end) - section.slope(end)).amax() < 1e-10);
                assert!((next.bend(end) - section.bend(end)).amax() < 1e-10);
            }
            let [linear, angular] = track.steepest();
            for i in 0..=100 {
                let slope = section.slope(section.begin + (end - section.begin) * f64::from(i) / 100.0);
                let angles = slope.fixed_rows::<3>(3).abs().sum();
                assert!(slope.fixed_rows::<3>(0).norm() <= linear + 1e-12 && angles <= angular + 1e-12);
            }
        }
        // The short way round: yaw goes on from 3.1 to 3.18.
        assert!((track.pose(sections[2].begin).0[5] - (std::f64::consts::TAU - 3.1)).abs() < 1e-12);
    }

    #[test]
    fn a_way_needs_two_poses_that_differ_and_not_too_many() {
        let (a, b) = (Pose::at(0.0, 0.0, 1.0), Pose::at(0.1, 0.0, 1.0));
        assert!(Track::through(&[a], 0.3).is_none() && Track::through(&[a, b, b], 0.3).is_none());
        let there_and_back: Vec<Pose> = [a, b].into_iter().cycle().take(MOST_SECTIONS + 2).collect();
        assert!(Track::through(&there_and_back, 0.3).is_none());
        let track = Track::through(&there_and_back[..=MOST_SECTIONS], 0.3).unwrap();
        assert_eq!(track.sections.len(), MOST_SECTIONS);
        assert!(Track::through(&[a, b], 0.3).unwrap().is_straight());
    }
}
