//! Mistakes that files and wiring can have, whole ones: a pair exchanged, a sign, a mirror image.

use std::fmt;

use cable_robot::robot::{Cable, PerCable, Pulley, Rig};
use nalgebra::{Matrix3, Vector3};

use super::World;

/// The truth is another than the files say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// Two drives are exchanged; cables from 0.
    Exchanged(usize, usize),
    /// Cable k of the file is cable k + `shift` of the rig, or `shift` - k where they are counted the other way round.
    Numbered {
        /// From 0.
        shift: usize,
        /// The other way round.
        is_reversed: bool,
    },
    /// The frame of the file is another than the one poses are measured in.
    Frame(Frame),
    /// The encoder counts the other way: of one cable, or all.
    Sign(Option<usize>),
    /// So many metres are read for a true one: of one cable, or all.
    Scale(Option<usize>, f64),
}

/// What is done to the file's frame, both of base and platform, to get the true one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// Turned about the vertical by so many quarters.
    Turned(u8),
    /// Turned so, then mirrored in a vertical plane.
    Mirrored(u8),
}

/// Encoders read at one edge, two or all four of a period, and the wrong way round.
const SCALES: [f64; 4] = [0.25, 0.5, 2.0, 4.0];

impl Mistake {
    /// All that are looked for on a rig of so many cables.
    pub fn all(cables: usize) -> Vec<Self> {
        let one_or_all = || (0..cables).map(Some).chain([None]);
        let pairs = (0..cables).flat_map(|i| (i + 1..cables).map(move |k| Self::Exchanged(i, k)));
        let numbered = |is_reversed| (0..cables).map(move |shift| Self::Numbered { shift, is_reversed });
        let frames = (1..4).map(Frame::Turned).chain((0..4).map(Frame::Mirrored)).map(Self::Frame);
        let scales = one_or_all().flat_map(|cable| SCALES.map(|scale| Self::Scale(cable, scale)));
        pairs
            .chain(numbered(false).skip(1))
            .chain(numbered(true))
            .chain(frames)
            .chain(one_or_all().map(Self::Sign))
            .chain(scales)
            .collect()
    }

    /// The truth that `file` mistakes.
    pub fn truth(&self, file: &World) -> World {
        let cables = file.scale.len();
        let mut truth = *file;
        match *self {
            Self::Exchanged(i, k) => (truth.cable[i], truth.cable[k]) = (file.cable[k], file.cable[i]),
            Self::Numbered { shift, is_reversed } => {
                let of = |i: usize| if is_reversed { shift + cables - i } else { shift + i };
                truth.cable = PerCable::from_fn(cables, |i| file.cable[of(i) % cables]);
            }
            Self::Frame(frame) => {
                let change = frame.matrix(&file.rig);
                truth.rig.cables = file.rig.cables.map(|cable| Cable {
                    anchor: change * cable.anchor,
                    attachment: change * cable.attachment,
                    pulley: cable.pulley.map(|pulley| Pulley { axis: change * pulley.axis, ..pulley }),
                    ..cable
                });
            }
            Self::Sign(which) => scale(&mut truth, which, -1.0),
            Self::Scale(which, factor) => scale(&mut truth, which, factor),
        }
        truth
    }
}

fn scale(world: &mut World, which: Option<usize>, factor: f64) {
    for (i, scale) in world.scale.iter_mut().enumerate() {
        if which.is_none_or(|cable| cable == i) {
            *scale *= factor;
        }
    }
}

impl Frame {
    fn matrix(self, rig: &Rig) -> Matrix3<f64> {
        let up = -rig.gravity.normalize();
        let across = Matrix3::identity().column(up.iamin()).into_owned();
        let first = (across - up * up.dot(&across)).normalize();
        let quarter = up.cross_matrix() + up * up.transpose();
        let (quarters, mirror) = match self {
            Self::Turned(quarters) => (quarters, Matrix3::identity()),
            Self::Mirrored(quarters) => (quarters, reflection(&first)),
        };
        (0..quarters).fold(Matrix3::identity(), |turned, _| quarter * turned) * mirror
    }
}

/// In the plane through the origin with this unit normal.
fn reflection(normal: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() - normal * normal.transpose() * 2.0
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |which: Option<usize>| match which {
            Some(cable) => format!("of cable {}", cable + 1),
            None => "of all cables".to_owned(),
        };
        match *self {
            Self::Exchanged(i, k) => write!(f, "drives of cables {} and {} exchanged", i + 1, k + 1),
            Self::Numbered { shift, is_reversed: false } => {
                write!(f, "cables numbered from another one: cable 1 of the file is cable {}", shift + 1)
            }
            Self::Numbered { shift, is_reversed: true } => {
                write!(f, "cables numbered the other way round: cable 1 of the file is cable {}", shift + 1)
            }
            Self::Frame(Frame::Turned(quarters)) => {
                write!(f, "frame turned about the vertical by {} degrees", 90 * u32::from(quarters))
            }
            Self::Frame(Frame::Mirrored(quarters)) => {
                write!(
                    f,
                    "frame mirrored in a vertical plane, then turned by {} degrees",
                    90 * u32::from(quarters)
                )
            }
            Self::Sign(which) => write!(f, "sign of the encoder {}", of(which)),
            Self::Scale(which, factor) => write!(f, "lengths {} read {factor} times as long", of(which)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cable_robot::robot::{Pose, RigFile};

    #[test]
    fn frames_keep_the_vertical_and_are_turns_or_mirrors() {
        let rig = RigFile::default().rig;
        let down = rig.gravity.normalize();
        for (frame, determinant) in
            (1..4).map(|k| (Frame::Turned(k), 1.0)).chain((0..4).map(|k| (Frame::Mirrored(k), -1.0)))
        {
            let matrix = frame.matrix(&rig);
            assert!((matrix.determinant() - determinant).abs() < 1e-12, "{frame:?}");
            assert!((matrix * matrix.transpose() - Matrix3::identity()).norm() < 1e-12, "{frame:?}");
            assert!((matrix * down - down).norm() < 1e-12, "{frame:?}");
        }
    }

    #[test]
    fn every_mistake_is_another_world_and_has_words_of_its_own() {
        let rig = RigFile::default().rig;
        let cables = rig.cables.len();
        let file = World {
            rig,
            home: Pose::at(0.0, 0.0, 1.0),
            cable: PerCable::from_fn(cables, |i| i),
            scale: PerCable::filled(cables, 1.0),
        };
        let all = Mistake::all(cables);
        let mut words: Vec<_> = all.iter().map(ToString::to_string).collect();
        assert!(all.iter().all(|mistake| mistake.truth(&file) != file));
        words.sort();
        words.dedup();
        assert_eq!((words.len(), all.len()), (15 + 5 + 6 + 7 + 7 + 28, all.len()));
    }
}
