//! What a survey is to find.

use std::fmt;

use cable_robot::robot::{PerCable, Pose};

use super::{Mistake, Quantity, World};

/// A quantity off by so large a share of [`Quantity::size`] is to be found.
const SHARE: f64 = 0.05;

/// Something that may be wrong, and by how much it is to be wrong to be looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// A whole mistake.
    Mistake(Mistake),
    /// A quantity, and m, rad or a share.
    Quantity(Quantity, f64),
}

impl Doubt {
    /// All mistakes, and the quantities of the rig as a whole and of its winches. Those of single anchors and attachments are not looked for.
    pub fn all(file: &World) -> Vec<Self> {
        let cables = file.scale.len();
        let is_looked_for =
            |quantity: &Quantity| !matches!(quantity, Quantity::Anchor(..) | Quantity::Attachment(..));
        let quantities = Quantity::all(cables).into_iter().filter(is_looked_for);
        let mistakes = Mistake::all(cables).into_iter().map(Self::Mistake);
        mistakes
            .chain(quantities.map(|quantity| Self::Quantity(quantity, SHARE * quantity.size(file))))
            .collect()
    }

    /// How much longer the bridge reads each cable at a pose than it would if `file` were the truth, m.
    pub fn deviation(&self, file: &World, pose: &Pose) -> PerCable<f64> {
        match self {
            Self::Mistake(mistake) => mistake.truth(file).deviation(file, pose),
            Self::Quantity(quantity, amount) => {
                let change = World::slope(|amount| quantity.truth(file, amount), pose);
                PerCable::from_fn(change.len(), |i| amount * change[i])
            }
        }
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mistake(mistake) => mistake.fmt(f),
            Self::Quantity(quantity, amount) => {
                let (unit, factor) = quantity.unit();
                write!(f, "{quantity}, by {:.1} {unit}", factor * amount)
            }
        }
    }
}
