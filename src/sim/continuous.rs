//! The plant in continuous time, for an integrator that is not ours (Model Exchange): no lag of the motors, no noise, no encoder steps.

use serde::{Deserialize, Serialize};

use super::body::{self, Body, State};
use super::plant::{PlantInputs, PlantOutputs, PlantParameters, held_back, pull_only};
use super::variation::{self, Change, Point};
use crate::robot::memory::{are_finite, expect};
use crate::robot::{Cables, MemoryError, ParameterError, PerCable, Pose};

/// The state, and which cables are taken to be taut until the integrator has found the instant at which one goes slack or taut.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContinuousPlant {
    parameters: PlantParameters,
    /// See [`body::State`].
    pub state: State,
    taut: PerCable<bool>,
}

/// N: a sign rather than a size.
const AWAY: f64 = f64::MIN_POSITIVE;

impl ContinuousPlant {
    /// At rest at the initial pose. Of the imperfections only friction is simulated.
    ///
    /// # Errors
    /// [`ParameterError`] for a parameter that makes no sense.
    pub fn new(parameters: PlantParameters, inputs: &PlantInputs) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let state = body::at_rest(&parameters.initial_pose);
        let taut = parameters.rig.cables.map(|_| true);
        let mut plant = Self { parameters, state, taut };
        plant.settle(inputs);
        Ok(plant)
    }

    /// The parameters it was started with.
    pub fn parameters(&self) -> &PlantParameters {
        &self.parameters
    }

    /// Whether a run can have left this memory, as [`Plant::check`](super::Plant::check). An integrator may come to any states that are finite.
    ///
    /// # Errors
    /// [`MemoryError`] for the first part that makes no sense.
    pub fn check(&self) -> Result<(), MemoryError> {
        self.parameters.validate()?;
        expect(are_finite(&self.state), "state", "13 finite numbers")?;
        let cables = self.parameters.rig.cables.len();
        expect(self.taut.len() == cables, "cables taken to be taut", "said of each")
    }

    /// Decides anew which cables are taut.
    pub fn settle(&mut self, inputs: &PlantInputs) {
        self.taut = self.pull(inputs).map(|pull| pull > 0.0);
    }

    /// The state's derivative with respect to time.
    pub fn derivative(&self, inputs: &PlantInputs) -> State {
        let tension = |cables: &Cables| self.tension(&self.pull_of(inputs, cables));
        let disturbance = (&inputs.disturbance_force, &inputs.disturbance_torque);
        body::derivative(&Body::new(&self.parameters.rig), &self.state, tension, disturbance)
    }

    /// The event indicators: the pull, moved away from zero by a little on the side on which the cable is taken to be, so that none is zero where an integrator starts
    /// anew. FMI asks for that; SciPy stops at such a zero for ever.
    pub fn indicators(&self, inputs: &PlantInputs) -> PerCable<f64> {
        let pull = self.pull(inputs);
        PerCable::from_fn(pull.len(), |i| pull[i] + if self.taut[i] { AWAY } else { -AWAY })
    }

    /// What each cable would pull if it could also push, N: it goes slack where this falls to zero. A command that passes through
    /// zero while friction holds its cable bends the pull and changes no sign.
    pub fn pull(&self, inputs: &PlantInputs) -> PerCable<f64> {
        self.pull_of(inputs, &self.cables())
    }

    /// What is seen of the state; between events the tensions are those of the cables taken to be taut.
    pub fn outputs(&self, inputs: &PlantInputs) -> PlantOutputs {
        let cables = self.cables();
        let pose = Pose::from_parts(&body::position(&self.state), &body::rotation(&self.state));
        PlantOutputs {
            encoder_pose: pose,
            velocity: body::velocity(&self.state),
            angular_velocity: body::angular_velocity(&self.state),
            cable_length: cables.length,
            measured_tension: self.tension(&self.pull_of(inputs, &cables)),
            slack: self.taut.map(|taut| !taut),
        }
    }

    /// By how much derivative, pull and outputs change, to first order, when state, inputs and parameters do.
    pub fn vary(&self, inputs: &PlantInputs, by: &Change) -> variation::Effect {
        let point = Point {
            rig: &self.parameters.rig,
            friction: self.parameters.friction,
            state: &self.state,
            inputs,
            taut: &self.taut,
            tension: self.tension(&self.pull(inputs)),
        };
        point.vary(by)
    }

    fn cables(&self) -> Cables {
        self.parameters.rig.cables(&body::position(&self.state), &body::rotation(&self.state))
    }

    fn pull_of(&self, inputs: &PlantInputs, cables: &Cables) -> PerCable<f64> {
        let friction = self.parameters.friction;
        if friction == 0.0 {
            return inputs.motor_tension;
        }
        let rates = cables.length_rates(&body::twist(&self.state));
        PerCable::from_fn(rates.len(), |i| pull_only(inputs.motor_tension[i]) + held_back(friction, rates[i]))
    }

    fn tension(&self, pull: &PerCable<f64>) -> PerCable<f64> {
        PerCable::from_fn(pull.len(), |i| if self.taut[i] { pull[i] } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::robot::{Coordinates, Pulley, RigFile};
    use crate::sim::Plant;
    use crate::sim::integrator::integrate;

    fn parameters(friction: f64) -> PlantParameters {
        PlantParameters { friction, ..PlantParameters::default() }
    }

    fn pulling(newtons: f64) -> PlantInputs {
        PlantInputs { motor_tension: PerCable::filled(6, newtons), ..PlantInputs::none(6) }
    }

    #[test]
    fn integrated_by_itself_it_is_the_plant() {
        let mut plant = Plant::new(parameters(0.0), &pulling(12.0)).unwrap();
        let inputs = PlantInputs { disturbance_force: Vector3::new(1.0, -2.0, 0.5), ..pulling(12.0) };
        let start = ContinuousPlant::new(parameters(0.0), &inputs).unwrap();
        let derivative =
            |_: f64, state: &State| ContinuousPlant { state: *state, ..start }.derivative(&inputs);
        let end = ContinuousPlant { state: integrate(&start.state, 0.3, derivative).unwrap(), ..start };
        plant.step(&inputs, 0.3).unwrap();
        let (ours, theirs) = (end.outputs(&inputs), plant.outputs());
        assert!((ours.encoder_pose.0 - theirs.encoder_pose.0).amax() < 1e-12);
        assert_eq!((ours.measured_tension, ours.slack), (theirs.measured_tension, theirs.slack));
    }

    #[test]
    fn a_cable_stays_taut_or_slack_until_that_is_settled() {
        let mut plant = ContinuousPlant::new(parameters(0.0), &pulling(10.0)).unwrap();
        let mut inputs = pulling(10.0);
        inputs.motor_tension[2] = -1.0;
        assert_eq!(plant.pull(&inputs)[2], -1.0);
        assert_eq!(
            (plant.outputs(&inputs).measured_tension[2], plant.outputs(&inputs).slack[2]),
            (-1.0, false)
        );
        plant.settle(&inputs);
        assert_eq!(
            (plant.outputs(&inputs).measured_tension[2], plant.outputs(&inputs).slack[2]),
            (0.0, true)
        );
        inputs.motor_tension[2] = 1.0;
        assert_eq!(plant.outputs(&inputs).measured_tension[2], 0.0);
        plant.settle(&inputs);
        assert_eq!(plant.outputs(&inputs).measured_tension[2], 1.0);
    }

    /// In free fall, without friction, all six were zero at every restart, and SciPy's integrators never left it.
    #[test]
    fn no_indicator_is_zero_where_an_integrator_starts_anew() {
        for newtons in [0.0, 10.0, -1.0] {
            let mut plant = ContinuousPlant::new(parameters(0.0), &pulling(10.0)).unwrap();
            plant.settle(&pulling(newtons));
            let found = plant.indicators(&pulling(newtons));
            assert!(found.iter().all(|z| (*z > 0.0) == (newtons > 0.0) && *z != 0.0), "{found:?}");
            assert!((found[0] - newtons).abs() < 1e-6);
        }
    }

    /// With pulleys at half of the anchors, friction, one slack cable, and a quaternion whose length is not one.
    #[test]
    fn effects_of_changes_are_differences_in_the_limit() {
        let mut rig = RigFile::default().rig;
        let pulley = Pulley { radius: 0.05, axis: Vector3::new(0.0, 0.6, -0.8) };
        rig.cables.iter_mut().step_by(2).for_each(|cable| cable.pulley = Some(pulley));
        (rig.inertia[(0, 1)], rig.inertia[(1, 0)]) = (0.005, 0.005);
        let pose = Pose(Coordinates::new(0.05, -0.02, 0.9, 0.1, -0.2, 0.3));
        for friction in [0.0, 0.4] {
            let parameters =
                PlantParameters { rig, initial_pose: pose, friction, ..PlantParameters::default() };
            let mut inputs = pulling(11.0);
            inputs.motor_tension[1] = -3.0;
            inputs.disturbance_torque = Vector3::new(0.1, 0.2, -0.3);
            let mut plant = ContinuousPlant::new(parameters, &inputs).unwrap();
            // Slow, so that friction has not turned over.
            plant.state = body::moving(&pose, &(Coordinates::new(0.1, 0.2, -0.1, 0.3, 0.4, -0.5) * 2e-3));
            plant.state.fixed_rows_mut::<4>(6).scale_mut(1.1);
            // Without friction a command below zero is no pull, with friction it is none: no derivative at 0.
            for k in 0..if friction > 0.0 { 31 } else { 30 } {
                let mut by = Change::none(6);
                let vector = |i: usize| Vector3::new(1.0, -0.5, 0.25) * (1.0 + 0.1 * i as f64);
                let parameters = &mut by.parameters;
                match k {
                    0..13 => by.state[k] = 1.0,
                    13..19 => by.inputs.motor_tension[k - 13] = 1.0,
                    19..22 => by.inputs.disturbance_force[k - 19] = 1.0,
                    22..25 => by.inputs.disturbance_torque[k - 22] = 1.0,
                    25 => parameters.anchor = PerCable::from_fn(6, vector),
                    26 => parameters.attachment = PerCable::from_fn(6, vector),
                    27 => parameters.mass = 1.0,
                    28 => {
                        parameters.inertia = Matrix3::new(0.1, 0.02, 0.01, 0.02, -0.1, 0.03, 0.01, 0.03, 0.2)
                    }
                    29 => parameters.gravity = vector(0),
                    _ => parameters.friction = 1.0,
                }
                differs_by_what_is_said(&plant, &inputs, &by, k);
            }
        }
    }

    fn differs_by_what_is_said(plant: &ContinuousPlant, inputs: &PlantInputs, by: &Change, k: usize) {
        const STEP: f64 = 1e-7;
        let at = |share: f64| {
            let mut moved = ContinuousPlant { state: plant.state + by.state * share, ..*plant };
            moved.parameters.friction += by.parameters.friction * share;
            let rig = &mut moved.parameters.rig;
            rig.mass += by.parameters.mass * share;
            rig.inertia += by.parameters.inertia * share;
            rig.gravity += by.parameters.gravity * share;
            for (i, cable) in rig.cables.iter_mut().enumerate() {
                cable.anchor += by.parameters.anchor[i] * share;
                cable.attachment += by.parameters.attachment[i] * share;
            }
            let add =
                |a: &PerCable<f64>, b: &PerCable<f64>| PerCable::from_fn(a.len(), |i| a[i] + share * b[i]);
            let inputs = PlantInputs {
                motor_tension: add(&inputs.motor_tension, &by.inputs.motor_tension),
                disturbance_force: inputs.disturbance_force + by.inputs.disturbance_force * share,
                disturbance_torque: inputs.disturbance_torque + by.inputs.disturbance_torque * share,
            };
            numbers(moved.derivative(&inputs), moved.pull(&inputs), moved.outputs(&inputs))
        };
        let effect = plant.vary(inputs, by);
        let said = numbers(effect.derivative, effect.pull, effect.outputs);
        for (n, (said, (after, before))) in
            said.into_iter().zip(at(STEP).into_iter().zip(at(-STEP))).enumerate()
        {
            let seen = (after - before) / (2.0 * STEP);
            assert!((said - seen).abs() < 1e-5 * (1.0 + seen.abs()), "{k}, {n}: {said}, differences {seen}");
        }
    }

    fn numbers(derivative: State, pull: PerCable<f64>, outputs: PlantOutputs) -> Vec<f64> {
        let mut all: Vec<f64> = derivative.iter().copied().collect();
        all.extend(pull.iter());
        all.extend(outputs.encoder_pose.0.iter());
        all.extend(outputs.velocity.iter().chain(outputs.angular_velocity.iter()));
        all.extend(outputs.cable_length.iter().chain(outputs.measured_tension.iter()));
        all
    }
}
