//! What tensions that stay as they are do to a platform that is not quite where they were computed for.
//!
//! Derived in docs/controller.md, "Tensions that are held".

use nalgebra::{Matrix3, Matrix6};

use crate::robot::{PerCable, Pose, Rig, dynamics};

/// How a platform at rest under constant tensions answers to a small displacement x: x'' = κ x along each of six directions, 1/s². The least
/// and the greatest κ: it swings back where κ is below 0, and leaves where it is above.
///
/// The potential of the cables is Σ u l. Its second derivative in a shift and a turn of the platform, over the inertia, is -κ.
pub fn swing(rig: &Rig, pose: &Pose, tensions: &PerCable<f64>) -> [f64; 2] {
    let cables = rig.cables_at(pose);
    let mut curvature = Matrix6::zeros();
    for (i, &tension) in tensions.iter().enumerate() {
        let (direction, arm) = (cables.direction[i], cables.arm[i]);
        // Across the cable: it turns. ∂l = -d·(δ + θ × r), so that its end moves by J (δ, θ).
        let mut moved = nalgebra::Matrix3x6::zeros();
        moved.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
        moved.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
        let across = Matrix3::identity() - direction * direction.transpose();
        curvature += moved.transpose() * across * moved * (tension / cables.free[i]);
        // Along it: the end of the arm turns on an arc, by θ × (θ × r)/2.
        let twist = (arm * direction.transpose() + direction * arm.transpose()) * 0.5;
        let arc = Matrix3::identity() * arm.dot(&direction) - twist;
        let mut turn = curvature.fixed_view_mut::<3, 3>(3, 3);
        turn += arc * tension;
    }
    let eigen = dynamics::inertia(rig, pose).symmetric_eigen();
    let root = eigen.eigenvectors
        * Matrix3::from_diagonal(&eigen.eigenvalues.map(|value| 1.0 / value.sqrt()))
        * eigen.eigenvectors.transpose();
    let mut scale = Matrix6::zeros();
    scale.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() / rig.mass.sqrt()));
    scale.fixed_view_mut::<3, 3>(3, 3).copy_from(&root);
    let kappa = -(scale * curvature * scale).symmetric_eigenvalues();
    [kappa.min(), kappa.max()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::static_tensions;
    use crate::robot::{Coordinates, RigFile};

    /// Newton and Euler's equations, differenced, have the same least and greatest eigenvalue.
    #[test]
    fn swing_is_what_the_equations_of_motion_say() {
        for text in [
            include_str!("../../rigs/paper.toml"),
            include_str!("../../rigs/eight.toml"),
            include_str!("../../rigs/public/segesta10.toml"),
        ] {
            let RigFile { rig, home, .. } = RigFile::parse(text).unwrap();
            let pose = Pose(home.0 + Coordinates::new(0.02, -0.03, 0.01, 0.0, 0.0, 0.0) * rig.radius());
            let tensions = static_tensions(&rig, &pose, 0.0).unwrap();
            let answer = |displacement: Coordinates| {
                let rates = Coordinates::zeros();
                dynamics::accelerations(&rig, &Pose(pose.0 + displacement), &rates, &tensions)
            };
            let step = 1e-5;
            let column = |k: usize| {
                let by = Coordinates::ith(k, step);
                (answer(by) - answer(-by)) / (2.0 * step)
            };
            let jacobian = Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(column));
            let expected: Vec<f64> = jacobian.complex_eigenvalues().iter().map(|kappa| kappa.re).collect();
            let [least, greatest] = swing(&rig, &pose, &tensions);
            let [min, max] =
                [f64::min, f64::max].map(|pick| expected.iter().copied().reduce(pick).unwrap_or_default());
            let size = min.abs().max(max.abs());
            assert!(
                (least - min).abs() < 1e-5 * size && (greatest - max).abs() < 1e-5 * size,
                "{expected:?} {least} {greatest}"
            );
        }
    }
}
