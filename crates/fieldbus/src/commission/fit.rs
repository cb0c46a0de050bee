//! Amounts of quantities that explain lengths best, by the method of Gauss and Newton.

use std::fmt;

use cable_robot::robot::{PerCable, Pose};
use nalgebra::{DMatrix, DVector};

use super::survey::{Deviation, Survey};
use super::{Placement, Quantity, World};

/// A fit ends when each step is this share of its standard deviation, or fails after so many steps.
const CLOSE: f64 = 0.01;
const STEPS: usize = 20;
/// A quantity off by more than this share of [`Quantity::size`] is a whole mistake.
const LARGEST: f64 = 0.3;

/// A quantity that is another than the files say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// Which.
    pub quantity: Quantity,
    /// More than the files say by this, m, rad or a share.
    pub amount: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

impl fmt::Display for Fitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, factor) = self.quantity.unit();
        let (amount, deviation) = (factor * self.amount, factor * self.deviation);
        write!(f, "{}: {amount:+.1} {unit} (standard deviation {deviation:.1})", self.quantity)
    }
}

/// What `base` would be with these quantities more by these amounts.
fn truth(base: &World, quantities: &[Quantity], amounts: &DVector<f64>) -> World {
    quantities
        .iter()
        .zip(amounts.iter())
        .fold(*base, |world, (quantity, amount)| quantity.truth(&world, *amount))
}

/// The amounts, and the square of the standard deviations that they leave; `None` where no small amounts are found. `believed` is how far each is from
/// zero beforehand, as a standard deviation; infinite where nothing is believed.
pub(super) fn fit(
    base: &World,
    quantities: &[Quantity],
    believed: impl Fn(Quantity) -> f64,
    placements: &[Placement],
    survey: &Survey,
) -> Option<(Vec<Fitted>, f64)> {
    let count = quantities.len();
    let belief = DVector::from_fn(count, |k, _| believed(quantities[k]).powi(-2));
    let mut amounts = DVector::zeros(count);
    for _ in 0..STEPS {
        let world = truth(base, quantities, &amounts);
        let rest = survey.deviation(&against(&world, placements));
        let changes: Vec<_> =
            (0..count).map(|k| change(base, quantities, &amounts, k, placements, survey)).collect();
        let normal = DMatrix::from_fn(count, count, |i, k| survey.product(&changes[i], &changes[k]))
            + DMatrix::from_diagonal(&belief);
        let along = DVector::from_fn(count, |k, _| survey.product(&changes[k], &rest))
            - belief.component_mul(&amounts);
        let inverse = normal.try_inverse()?;
        let step = &inverse * along;
        amounts += &step;
        let deviation = |k: usize| inverse[(k, k)].sqrt();
        let is_small = |k: usize| amounts[k].abs() <= LARGEST * quantities[k].size(base);
        if (0..count).all(|k| step[k].abs() < CLOSE * deviation(k)) {
            let fitted =
                |k: usize| Fitted { quantity: quantities[k], amount: amounts[k], deviation: deviation(k) };
            let all = (0..count).all(is_small).then(|| (0..count).map(fitted).collect())?;
            return Some((all, survey.product(&rest, &rest)));
        }
    }
    None
}

/// How the lengths change with the amount of one of the quantities.
fn change(
    base: &World,
    quantities: &[Quantity],
    amounts: &DVector<f64>,
    which: usize,
    placements: &[Placement],
    survey: &Survey,
) -> Deviation {
    let world = |step| {
        let mut amounts = amounts.clone();
        amounts[which] += step;
        truth(base, quantities, &amounts)
    };
    let of_pose = |pose: &Pose| World::slope(world, pose);
    survey.deviation(&placements.iter().map(|placement| of_pose(&placement.pose)).collect::<Vec<_>>())
}

/// What was read, less what `world` would have read, m.
pub(super) fn against(world: &World, placements: &[Placement]) -> Vec<PerCable<f64>> {
    let less = |placement: &Placement| {
        let expected = world.lengthening(&placement.pose);
        PerCable::from_fn(expected.len(), |i| placement.lengthening[i] - expected[i])
    };
    placements.iter().map(less).collect()
}
