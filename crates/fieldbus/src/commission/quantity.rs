//! Measures of the files that may be off by some amount.

use std::fmt;

use cable_robot::robot::Pose;
use nalgebra::{Rotation3, Vector3};

use super::World;

/// Something measured that a file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The home position, along an axis of the base frame; m.
    Home(usize),
    /// The platform at home, turned about an axis of the base frame; rad.
    HomeTurn(usize),
    /// The winding: pulley radius over counts a turn; a share of it; of one cable, or all.
    Winding(Option<usize>),
    /// The distances of all anchors; a share of them.
    Base,
    /// The distances of all attachments; a share of them.
    Platform,
    /// The anchor of a cable, along an axis of the base frame; m.
    Anchor(usize, usize),
    /// The attachment of a cable, along an axis of the platform's frame; m.
    Attachment(usize, usize),
}

impl Quantity {
    /// All that are looked at on a rig of so many cables.
    pub fn all(cables: usize) -> Vec<Self> {
        let each = |of: fn(usize, usize) -> Self| {
            (0..cables).flat_map(move |cable| (0..3).map(move |axis| of(cable, axis)))
        };
        let windings = (0..cables).map(|cable| Self::Winding(Some(cable)));
        (0..3)
            .map(Self::Home)
            .chain((0..3).map(Self::HomeTurn))
            .chain([Self::Winding(None), Self::Base, Self::Platform])
            .chain(windings)
            .chain(each(Self::Anchor))
            .chain(each(Self::Attachment))
            .collect()
    }

    /// The truth if the quantity is more than `file` says by `amount`.
    pub fn truth(self, file: &World, amount: f64) -> World {
        let mut truth = *file;
        match self {
            Self::Home(axis) => truth.home.0[axis] += amount,
            Self::HomeTurn(axis) => truth.home = turned(&file.home, axis, amount),
            // More cable comes in for each count than the bridge reads.
            Self::Winding(which) => {
                for (i, scale) in truth.scale.iter_mut().enumerate() {
                    if which.is_none_or(|cable| cable == i) {
                        *scale /= 1.0 + amount;
                    }
                }
            }
            Self::Base => truth.rig.cables.iter_mut().for_each(|cable| cable.anchor *= 1.0 + amount),
            Self::Platform => truth.rig.cables.iter_mut().for_each(|cable| cable.attachment *= 1.0 + amount),
            Self::Anchor(cable, axis) => truth.rig.cables[cable].anchor[axis] += amount,
            Self::Attachment(cable, axis) => truth.rig.cables[cable].attachment[axis] += amount,
        }
        truth
    }

    /// What its amounts are to be compared with: the rig's radius (m), a radian, or the whole.
    pub fn size(self, file: &World) -> f64 {
        match self {
            Self::Home(_) | Self::Anchor(..) | Self::Attachment(..) => file.rig.radius(),
            Self::HomeTurn(_) | Self::Winding(_) | Self::Base | Self::Platform => 1.0,
        }
    }

    /// The unit of its amounts, and how many of them are one of [`World`]'s.
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Self::Home(_) | Self::Anchor(..) | Self::Attachment(..) => ("mm", 1e3),
            Self::HomeTurn(_) => ("degrees", 1f64.to_degrees()),
            Self::Winding(_) | Self::Base | Self::Platform => ("%", 1e2),
        }
    }
}

/// A pose turned about an axis of the base frame, rad.
fn turned(pose: &Pose, axis: usize, angle: f64) -> Pose {
    let mut rotation = Vector3::zeros();
    rotation[axis] = angle;
    Pose::from_parts(&pose.position(), &(Rotation3::from_scaled_axis(rotation) * pose.rotation()))
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = |axis: usize| ["x", "y", "z"][axis];
        match *self {
            Self::Home(k) => write!(f, "home, {}", axis(k)),
            Self::HomeTurn(k) => write!(f, "home, turned about {}", axis(k)),
            Self::Winding(None) => write!(f, "pulley radius, all cables"),
            Self::Winding(Some(cable)) => write!(f, "pulley radius, cable {}", cable + 1),
            Self::Base => write!(f, "size of the base"),
            Self::Platform => write!(f, "size of the platform"),
            Self::Anchor(cable, k) => write!(f, "anchor of cable {}, {}", cable + 1, axis(k)),
            Self::Attachment(cable, k) => write!(f, "attachment of cable {}, {}", cable + 1, axis(k)),
        }
    }
}
