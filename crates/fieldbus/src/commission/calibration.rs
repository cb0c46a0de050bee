//! What the files would better say: home, windings and anchors fitted to the lengths of a survey together. Attachments are believed: platforms are
//! machined, and at poses that are level an attachment off looks as its anchor off the other way.

use super::fit::{Fitted, fit};
use super::survey::{Accuracy, Survey};
use super::{Placement, Quantity, World};

/// Before the survey each quantity is believed within this share of [`Quantity::size`], as a standard deviation: a stand that was put there, a drum with
/// its cable,
const BELIEVED: f64 = 0.05;
/// and an anchor that was measured with a tape.
const BELIEVED_OF_ANCHOR: f64 = 0.01;
/// The survey tells a quantity if it leaves this share of what was not known of it.
const LEFT: f64 = 0.5;

/// Measures that explain the lengths best, between what the files say and what the lengths do.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// All that were fitted.
    pub fitted: Vec<Fitted>,
    /// What the files would say then.
    pub world: World,
    /// What is left: standard deviations, root of the mean square over all lengths; about 1 if it is right.
    pub residual: f64,
}

impl Calibration {
    /// Of these placements; none if no small amounts explain them: a whole mistake is named by [`super::Verdict`].
    pub fn new(file: &World, placements: &[Placement], accuracy: &Accuracy) -> Option<Self> {
        let poses: Vec<_> = placements.iter().map(|placement| placement.pose).collect();
        let survey = Survey::new(file, &poses, accuracy);
        let is_fitted = |quantity: &Quantity| {
            matches!(
                quantity,
                Quantity::Home(_) | Quantity::HomeTurn(_) | Quantity::Winding(Some(_)) | Quantity::Anchor(..)
            )
        };
        let quantities: Vec<_> = Quantity::all(file.scale.len()).into_iter().filter(is_fitted).collect();
        let (fitted, square) =
            fit(file, &quantities, |quantity| believed(quantity, file), placements, &survey)?;
        let world = fitted.iter().fold(*file, |world, fitted| fitted.quantity.truth(&world, fitted.amount));
        let lengths = (file.scale.len() * placements.len()) as f64;
        Some(Self { fitted, world, residual: (square.max(0.0) / lengths).sqrt() })
    }

    /// Those that the lengths tell, rather than the files.
    pub fn measured<'a>(&'a self, file: &'a World) -> impl Iterator<Item = &'a Fitted> {
        let is_measured = |fitted: &&Fitted| fitted.deviation < LEFT * believed(fitted.quantity, file);
        self.fitted.iter().filter(is_measured)
    }
}

/// m, rad or a share.
fn believed(quantity: Quantity, file: &World) -> f64 {
    let share = if matches!(quantity, Quantity::Anchor(..)) { BELIEVED_OF_ANCHOR } else { BELIEVED };
    share * quantity.size(file)
}

#[cfg(test)]
mod tests {
    use cable_robot::robot::Pose;
    use nalgebra::Vector3;
    use rand::RngExt;
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::SeedableRng;

    use super::*;
    use crate::commission::Mistake;
    use crate::commission::tests::{measure, normal};
    use crate::config::Config;
    use crate::config::tests::{AKD, eight, parse};

    /// Level, anywhere within `limits.space`, above the stand.
    fn pose(config: &Config, random: &mut Pcg64Mcg) -> Pose {
        let (home, up) = (config.home.position(), -config.rig.gravity.normalize());
        loop {
            let [x, y, z] = config.limits.space.map(|[from, to]| from + random.random::<f64>() * (to - from));
            if (Vector3::new(x, y, z) - home).dot(&up) > 0.0 {
                return Pose::at(x, y, z);
            }
        }
    }

    /// Anchors off by as much as is believed of them, home by 5 mm, windings by 1 %, as standard deviations.
    fn amounts(file: &World, random: &mut Pcg64Mcg) -> Vec<(Quantity, f64)> {
        let mut amount = |quantity: Quantity| match quantity {
            Quantity::Anchor(..) => (quantity, believed(quantity, file) * normal(random)),
            Quantity::Winding(Some(_)) => (quantity, 0.01 * normal(random)),
            Quantity::Home(_) => (quantity, 0.005 * normal(random)),
            _ => (quantity, 0.0),
        };
        Quantity::all(file.scale.len()).into_iter().map(&mut amount).collect()
    }

    /// Mean distance of the anchors of two worlds, m.
    fn apart(a: &World, b: &World) -> f64 {
        let of_cable = |i: usize| (a.rig.cables[i].anchor - b.rig.cables[i].anchor).norm();
        (0..a.scale.len()).map(of_cable).sum::<f64>() / a.scale.len() as f64
    }

    #[test]
    fn measures_fitted_to_a_survey_are_off_by_no_more_than_is_said_of_them() {
        const SURVEYS: u32 = 20;
        let accuracy = Accuracy { position: 0.001, angle: 0.002, length: 0.001 };
        for config in [parse(AKD).unwrap(), eight()] {
            let file = World::of(&config);
            for count in [2, 6, 12, 24] {
                let mut random = Pcg64Mcg::seed_from_u64(count);
                let (mut square, mut number, mut before, mut after) = (0.0, 0u32, 0.0, 0.0);
                for _ in 0..SURVEYS {
                    let amounts = amounts(&file, &mut random);
                    let truth = amounts
                        .iter()
                        .fold(file, |world, (quantity, amount)| quantity.truth(&world, *amount));
                    let poses: Vec<_> = (0..count).map(|_| pose(&config, &mut random)).collect();
                    let placements = measure(&truth, &poses, &accuracy, &mut random);
                    let found = Calibration::new(&file, &placements, &accuracy).unwrap();
                    assert!(found.residual < 1.5, "{}", found.residual);
                    for fitted in found.measured(&file) {
                        let is_it = |(quantity, _): &&(Quantity, f64)| *quantity == fitted.quantity;
                        let (_, amount) = amounts.iter().find(is_it).unwrap();
                        square += ((fitted.amount - amount) / fitted.deviation).powi(2);
                        number += 1;
                    }
                    before += 1e3 * apart(&file, &truth) / f64::from(SURVEYS);
                    after += 1e3 * apart(&found.world, &truth) / f64::from(SURVEYS);
                }
                let (measured, off) = (number / SURVEYS, (square / f64::from(number)).sqrt());
                println!(
                    "{}, {count} poses: {measured} measures, off by {off:.2} of what is said; anchors off by {after:.1} mm, {before:.1} before",
                    config.name
                );
                assert!(off < 1.2, "{off}");
                assert!(count < 12 || after < 0.5 * before, "{after} {before}");
            }
        }
    }

    #[test]
    fn a_whole_mistake_is_not_fitted_away() {
        let (config, accuracy) =
            (parse(AKD).unwrap(), Accuracy { position: 0.001, angle: 0.002, length: 0.001 });
        let file = World::of(&config);
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let poses: Vec<_> = (0..6).map(|_| pose(&config, &mut random)).collect();
        let truth = Mistake::all(6)[0].truth(&file);
        let placements = measure(&truth, &poses, &accuracy, &mut random);
        assert!(Calibration::new(&file, &placements, &accuracy).is_none_or(|found| found.residual > 3.0));
    }
}
