//! Where the cables are at a pose: lengths, directions, the wrench matrix.

use nalgebra::{Rotation3, Vector3, Vector6};

use super::{PerCable, Pose, Rig};

/// The cables at one pose, in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cables {
    /// Attachment relative to the centre of mass, m.
    pub arm: PerCable<Vector3<f64>>,
    /// Unit vector from the attachment along the cable: where it pulls.
    pub direction: PerCable<Vector3<f64>>,
    /// Length of the straight part, m; not finite where an attachment is inside a pulley.
    pub free: PerCable<f64>,
    /// Length from anchor to attachment, m (inverse kinematics): the straight part and the arc on the pulley.
    pub length: PerCable<f64>,
}

impl Rig {
    /// The cables with the platform's centre of mass at `position` and its orientation `rotation`.
    pub fn cables(&self, position: &Vector3<f64>, rotation: &Rotation3<f64>) -> Cables {
        let count = self.cables.len();
        let mut cables = Cables {
            arm: self.cables.map(|cable| rotation * cable.attachment),
            direction: PerCable::filled(count, Vector3::zeros()),
            free: PerCable::filled(count, 0.0),
            length: PerCable::filled(count, 0.0),
        };
        for (i, cable) in self.cables.iter().enumerate() {
            let along = cable.anchor - position - cables.arm[i];
            match cable.pulley {
                None => {
                    cables.length[i] = along.norm();
                    cables.free[i] = cables.length[i];
                    cables.direction[i] = along / cables.length[i];
                }
                Some(pulley) => {
                    let run = pulley.run(&-along);
                    (cables.direction[i], cables.free[i], cables.length[i]) =
                        (run.direction, run.free, run.length);
                }
            }
        }
        cables
    }

    /// By how much the directions of `cables`, with the centre of mass at `position`, change to first order when the attachments move by
    /// `shift` (m), base frame.
    pub fn turned_by(
        &self,
        cables: &Cables,
        position: &Vector3<f64>,
        shift: &PerCable<Vector3<f64>>,
    ) -> PerCable<Vector3<f64>> {
        PerCable::from_fn(shift.len(), |i| {
            let (direction, cable) = (cables.direction[i], &self.cables[i]);
            match cable.pulley {
                None => (direction * direction.dot(&shift[i]) - shift[i]) / cables.free[i],
                Some(pulley) => pulley.turned_by(&(position + cables.arm[i] - cable.anchor), &shift[i]),
            }
        })
    }

    /// The same at a pose.
    pub fn cables_at(&self, pose: &Pose) -> Cables {
        self.cables(&pose.position(), &pose.rotation())
    }
}

impl Cables {
    /// Columns of the wrench matrix -Jᵀ of Eq. (1): tensions to (force, torque about the centre of mass), base frame.
    pub fn wrench_matrix(&self) -> PerCable<Vector6<f64>> {
        PerCable::from_fn(self.direction.len(), |i| {
            let (force, torque) = (self.direction[i], self.arm[i].cross(&self.direction[i]));
            Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
        })
    }

    /// (force, torque about the centre of mass) of these tensions, N and N m, base frame.
    pub fn wrench(&self, tension: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let mut force = Vector3::zeros();
        let mut torque = Vector3::zeros();
        for i in 0..self.direction.len() {
            let pull = self.direction[i] * tension[i];
            force += pull;
            torque += self.arm[i].cross(&pull);
        }
        (force, torque)
    }

    /// Rates of the lengths, m/s, for the twist (velocity, angular velocity), base frame.
    pub fn length_rates(&self, twist: &Vector6<f64>) -> PerCable<f64> {
        let velocity = twist.fixed_rows::<3>(0).into_owned();
        let omega = twist.fixed_rows::<3>(3).into_owned();
        PerCable::from_fn(self.direction.len(), |i| {
            -self.direction[i].dot(&(velocity + omega.cross(&self.arm[i])))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Pulley, RobotParameters, TensionLimits};

    /// The paper's rig, with a pulley at every other anchor.
    fn rig() -> Rig {
        let mut rig = Rig::paper(&RobotParameters::default(), TensionLimits::default());
        let pulley = Pulley { radius: 0.05, axis: Vector3::new(0.0, 0.6, -0.8) };
        rig.cables.iter_mut().step_by(2).for_each(|cable| cable.pulley = Some(pulley));
        rig
    }

    #[test]
    fn length_rates_are_the_derivative_of_the_lengths() {
        let rig = rig();
        let position = Vector3::new(0.05, -0.1, 0.9);
        let rotation = Pose(Vector6::new(0.0, 0.0, 0.0, 0.1, -0.2, 0.3)).rotation();
        let twist = Vector6::new(0.3, -0.2, 0.1, 0.4, 0.5, -0.6);
        let omega = twist.fixed_rows::<3>(3).into_owned();
        let lengths = |t: f64| {
            let p = position + twist.fixed_rows::<3>(0) * t;
            rig.cables(&p, &(Rotation3::from_scaled_axis(omega * t) * rotation)).length
        };
        let rates = rig.cables(&position, &rotation).length_rates(&twist);
        let (before, after) = (lengths(-1e-6), lengths(1e-6));
        for i in 0..6 {
            assert!((rates[i] - (after[i] - before[i]) / 2e-6).abs() < 1e-8, "cable {}", i + 1);
        }
    }

    #[test]
    fn wrench_matrix_times_tensions_is_the_wrench() {
        let cables = rig().cables_at(&Pose(Vector6::new(0.05, 0.02, 1.1, 0.1, 0.2, -0.1)));
        let tension = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let (force, torque) = cables.wrench(&tension);
        let columns = cables.wrench_matrix();
        let product: Vector6<f64> = (0..6).map(|i| columns[i] * tension[i]).sum();
        assert!((product.fixed_rows::<3>(0) - force).norm() < 1e-12);
        assert!((product.fixed_rows::<3>(3) - torque).norm() < 1e-12);
    }
}
