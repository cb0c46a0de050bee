//! What an error of the geometry costs: anchors and attachments anywhere in balls about where they are said to be.

use nalgebra::{Vector3, Vector6};

use super::distribution::Solutions;
use super::tensions::static_tensions;
use crate::robot::{PerCable, Pose, Rig};

/// By how much, to first order, the tensions that hold the platform at `pose` can differ from those of the rig as it is said to be while its
/// anchors and attachments are off by up to `accuracy`, N: the greatest of any cable, for the worst errors of all. Of more than six cables the
/// least change of all tensions is meant, which one tension distribution or another makes. `None` where the wrench matrix is singular.
///
/// With rows (f, t) of W⁺ for cable i, a cable j that pulls u along d at the arm a, and is l long, adds u (f + t × a)·ε + u (d × t)·α,
/// where ε, across d, is the error of its direction, at most 2 accuracy/l, and α that of its attachment.
pub fn geometry_margin(rig: &Rig, pose: &Pose) -> Option<f64> {
    let cables = rig.cables_at(pose);
    let columns = cables.wrench_matrix();
    let tensions = static_tensions(rig, pose, 0.0)?;
    let mut inverse = PerCable::filled(columns.len(), Vector6::zeros());
    for k in 0..6 {
        let mut unit = Vector6::zeros();
        unit[k] = 1.0;
        let solutions = Solutions::new(&columns, &unit, rig.platform_radius())?;
        for (row, value) in inverse.iter_mut().zip(solutions.least().iter()) {
            row[k] = *value;
        }
    }
    let change = |row: &Vector6<f64>| -> f64 {
        let (force, torque): (Vector3<f64>, Vector3<f64>) =
            (row.fixed_rows::<3>(0).into_owned(), row.fixed_rows::<3>(3).into_owned());
        let of_cable = |j: usize| {
            let direction = cables.direction[j];
            let turned = force + torque.cross(&cables.arm[j]);
            let across = turned - direction * turned.dot(&direction);
            let moved = direction.cross(&torque);
            tensions[j].abs() * (2.0 * across.norm() / cables.free[j] + moved.norm())
        };
        (0..columns.len()).map(of_cable).sum()
    };
    Some(rig.accuracy * inverse.iter().map(change).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::robot::RigFile;

    /// The rig with both ends of each cable off by exactly `by`, in random directions.
    fn off(rng: &mut Pcg64, rig: &Rig, by: f64) -> Rig {
        let mut off = *rig;
        for cable in off.cables.iter_mut() {
            for end in [&mut cable.anchor, &mut cable.attachment] {
                let way = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
                *end += way.normalize() * by;
            }
        }
        off
    }

    #[test]
    fn no_random_rig_is_farther_off_and_the_worst_comes_near() {
        let mut rng = Pcg64::seed_from_u64(51);
        let mut rig = RigFile::default().rig;
        rig.accuracy = 1e-5;
        for pose in [Pose::default(), Pose::at(0.1, 0.05, 1.0), Pose::at(0.0, -0.15, 0.6)] {
            let bound = geometry_margin(&rig, &pose).unwrap();
            let believed = static_tensions(&rig, &pose, 0.0).unwrap();
            let mut most = 0.0f64;
            for _ in 0..20_000 {
                let truth = static_tensions(&off(&mut rng, &rig, rig.accuracy), &pose, 0.0).unwrap();
                most = (0..6).map(|i| (truth[i] - believed[i]).abs()).fold(most, f64::max);
            }
            println!(
                "{pose:?}: at most {bound:.2e} N, by chance {most:.2e} N; a millimetre {:.3} N",
                100.0 * bound
            );
            assert!(most < 1.001 * bound && most > 0.4 * bound, "{most} N, bound {bound} N");
        }
    }
}
