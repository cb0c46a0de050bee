//! How well the lengths read at some poses tell one world from another, when the platform is placed with errors.

use cable_robot::robot::{PerCable, Pose, Rig};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix6, Vector6};

use super::World;

/// How exactly a person places the platform and lengths are read: standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Of the centre of mass along each axis, m.
    pub position: f64,
    /// About each axis, rad.
    pub angle: f64,
    /// Of a cable's length with the cable taut, m.
    pub length: f64,
}

/// Lengths read at some poses, and how errors of placing and reading show in them.
///
/// The length of a cable at pose k is off by J_k δ_k - J_h δ_h + ε: δ_k the error of placing there, δ_h the one at home, which all poses have
/// in common, ε of reading. With Σ the covariance of a placing and A_k = J_k Σ J_kᵀ + σ² I, deviations a and b of the lengths have the product
///
/// ⟨a, b⟩ = Σ_k a_kᵀ A_k⁻¹ b_k - g(a)ᵀ M⁻¹ g(b), with g(a) = Σ_k J_hᵀ A_k⁻¹ a_k and M = Σ⁻¹ + Σ_k J_hᵀ A_k⁻¹ J_h,
///
/// which is aᵀ C⁻¹ b with the covariance C of all lengths together: √⟨a, a⟩ is how many standard deviations a is.
#[derive(Clone, Debug)]
pub struct Survey {
    placings: Vec<Placing>,
    /// M.
    home: Cholesky<f64, nalgebra::U6>,
    /// ln det C, but for a constant.
    log_determinant: f64,
}

/// One pose of a survey. What several tell adds up, but for the error at home that they have in common.
#[derive(Clone, Debug)]
pub(super) struct Placing {
    /// L with L Lᵀ = A_k.
    noise: Cholesky<f64, Dyn>,
    /// L⁻¹ J_h.
    home: DMatrix<f64>,
}

/// Deviations of the lengths, one for each pose of a survey: whitened, and what an error at home explains of them.
#[derive(Clone, Debug)]
pub struct Deviation {
    whitened: Vec<DVector<f64>>,
    at_home: Vector6<f64>,
}

impl Survey {
    /// Of the platform placed at `poses` if `world` is the truth.
    pub fn new(world: &World, poses: &[Pose], accuracy: &Accuracy) -> Self {
        let placings: Vec<_> = poses.iter().map(|pose| Placing::new(world, pose, accuracy)).collect();
        let information = accuracy.at_home() + placings.iter().map(Placing::at_home).sum::<Matrix6<f64>>();
        let home = Cholesky::new(information).expect("a positive definite matrix with more added stays so");
        // det C = det M Π det A_k det Σ, and Σ is the same for all worlds.
        let of_placings: f64 =
            placings.iter().map(|placing| log_determinant(placing.noise.l_dirty().diagonal().iter())).sum();
        let log_determinant = of_placings + log_determinant(home.l_dirty().diagonal().iter());
        Self { placings, home, log_determinant }
    }

    /// Deviations of the lengths at each of the poses, m.
    pub fn deviation(&self, at: &[PerCable<f64>]) -> Deviation {
        let whitened: Vec<_> =
            self.placings.iter().zip(at).map(|(placing, lengths)| placing.whiten(lengths)).collect();
        let explained = self.placings.iter().zip(&whitened);
        let at_home = explained.map(|(placing, lengths)| placing.explained_at_home(lengths)).sum();
        Deviation { whitened, at_home }
    }

    /// ⟨a, b⟩.
    pub fn product(&self, a: &Deviation, b: &Deviation) -> f64 {
        let all: f64 = a.whitened.iter().zip(&b.whitened).map(|(a, b)| a.dot(b)).sum();
        all - a.at_home.dot(&self.home.solve(&b.at_home))
    }

    /// -2 times the logarithm of the density of deviations, but for a constant.
    pub fn misfit(&self, a: &Deviation) -> f64 {
        self.product(a, a) + self.log_determinant
    }
}

impl Placing {
    pub fn new(world: &World, pose: &Pose, accuracy: &Accuracy) -> Self {
        let (here, home) = (rates(world, pose), rates(world, &world.home));
        let cables = home.nrows();
        let reading = DMatrix::identity(cables, cables) * (accuracy.length * accuracy.length);
        let variance = DMatrix::from_diagonal(&DVector::from_column_slice(accuracy.variance().as_slice()));
        let noise = Cholesky::new(&here * variance * here.transpose() + reading)
            .expect("a covariance with a positive part of the identity is positive definite");
        let home = noise.l_dirty().solve_lower_triangular(&home).expect("a Cholesky factor is regular");
        Self { noise, home }
    }

    /// J_hᵀ A⁻¹ J_h.
    pub fn at_home(&self) -> Matrix6<f64> {
        (self.home.transpose() * &self.home).fixed_view::<6, 6>(0, 0).into_owned()
    }

    /// L⁻¹ of deviations of the lengths, m.
    pub fn whiten(&self, lengths: &PerCable<f64>) -> DVector<f64> {
        let lengths = DVector::from_column_slice(lengths);
        self.noise.l_dirty().solve_lower_triangular(&lengths).expect("a Cholesky factor is regular")
    }

    /// J_hᵀ A⁻¹ of deviations that are whitened.
    pub fn explained_at_home(&self, whitened: &DVector<f64>) -> Vector6<f64> {
        (self.home.transpose() * whitened).fixed_rows::<6>(0).into_owned()
    }
}

/// Of L Lᵀ, from the diagonal of L.
fn log_determinant<'a>(diagonal: impl Iterator<Item = &'a f64>) -> f64 {
    diagonal.map(|entry| 2.0 * libm::log(*entry)).sum()
}

/// Rates of the lengths read (m) for a twist (m, rad), a row a winch.
fn rates(world: &World, pose: &Pose) -> DMatrix<f64> {
    let columns = world.rig.cables_at(pose).wrench_matrix();
    DMatrix::from_fn(world.scale.len(), 6, |i, k| -world.scale[i] * columns[world.cable[i]][k])
}

impl Accuracy {
    /// The diagonal of Σ.
    fn variance(&self) -> Vector6<f64> {
        let deviation = Vector6::from_fn(|k, _| if k < 3 { self.position } else { self.angle });
        deviation.component_mul(&deviation)
    }

    /// Σ⁻¹: what is known of the error at home beforehand.
    pub(super) fn at_home(&self) -> Matrix6<f64> {
        Matrix6::from_diagonal(&self.variance().map(f64::recip))
    }

    /// Lengths are read as exactly as the rig file says its anchors are; if it says nothing, as the platform is placed.
    pub fn of_placing(position: f64, angle: f64, rig: &Rig) -> Self {
        Self { position, angle, length: if rig.accuracy > 0.0 { rig.accuracy } else { position } }
    }
}
