//! A way through the six coordinates: sections that join without a corner, s from 0 to 1.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

use crate::reach::certificate::section::Section;
use crate::robot::{Coordinates, Pose};

/// Sections of a way.
pub const MOST_SECTIONS: usize = 8;

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

    fn of(section: Section) -> Self {
        Self { sections: [section].into_iter().collect() }
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

    /// The sections that s is on: two where they join.
    pub fn touching(&self, s: f64) -> impl Iterator<Item = &Section> {
        let last = self.sections.iter().rposition(|section| section.begin <= s).unwrap_or(0);
        let first = if last > 0 && self.sections[last].begin == s { last - 1 } else { last };
        self.sections[first..=last].iter()
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
