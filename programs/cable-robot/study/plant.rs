//! The packed plant, its parameters not those that the controller was given.

use anyhow::{Context, Result};
use cable_robot::robot::triangles::SIX;
use cable_robot::robot::{Coordinates, PerCable, Pose, RobotParameters};
use cable_robot_import::{Fmu, Instance, Value, Variable};
use nalgebra::Vector3;

/// What is true of the platform.
#[derive(Clone, Copy)]
pub struct Truth {
    pub robot: RobotParameters,
    /// From the centre of mass to where the controller believes it, in the platform's frame, m.
    pub offset: Vector3<f64>,
    /// Of each cable, N.
    pub friction: f64,
}

/// An instance of the plant FMU.
pub struct ImperfectPlant {
    instance: Instance,
    offset: Vector3<f64>,
    commands: Vec<Variable>,
    disturbances: Vec<Variable>,
    state: Vec<Variable>,
    pulled: Vec<Variable>,
    slack: Vec<Variable>,
}

impl ImperfectPlant {
    /// At rest at `start`, of the point that the controller takes for the centre of mass.
    pub fn new(fmu: &Fmu, truth: &Truth, start: &Pose, command: &PerCable<f64>) -> Result<Self> {
        let instance = fmu.instantiate("plant", Box::new(|_| {}))?;
        let RobotParameters { m, i1, i2, i3, .. } = truth.robot;
        let numbers = [("m", m), ("I1", i1), ("I2", i2), ("I3", i3), ("friction", truth.friction)];
        instance.set_parameters(&numbers.map(|(name, value)| (name, Value::Float(value))))?;
        let centre = start.position() - start.rotation() * truth.offset;
        let find = |names: Vec<String>| -> Result<Vec<Variable>> {
            names.iter().map(|name| Ok(instance.variable(name)?.clone())).collect()
        };
        let cables = |name: &str| find((1..=SIX).map(|i| format!("{name}[{i}]")).collect());
        let axes = |names: &[&str], axes: &[&str]| {
            find(
                names.iter().flat_map(|name| axes.iter().map(move |axis| format!("{name}.{axis}"))).collect(),
            )
        };
        const SPACE: [&str; 3] = ["x", "y", "z"];
        const ANGLES: [&str; 3] = ["roll", "pitch", "yaw"];
        let pose = |name| axes(&[name], &[SPACE, ANGLES].concat());
        write(&instance, &pose("initialPose")?, centre.iter().chain(start.angles().iter()))?;

        let commands = cables("motorTension")?;
        let disturbances = axes(&["disturbanceForce", "disturbanceTorque"], &SPACE)?;
        let state = [pose("encoderPose")?, axes(&["velocity", "angularVelocity"], &SPACE)?].concat();
        let (pulled, slack) = (cables("measuredTension")?, cables("slack")?);
        instance.enter_initialization(0.0, None)?;
        write(&instance, &commands, command)?;
        instance.exit_initialization()?;
        Ok(Self { instance, offset: truth.offset, commands, disturbances, state, pulled, slack })
    }

    /// Changes the force (N) and the torque (N m) from outside.
    pub fn disturb(&self, force: &Vector3<f64>, torque: &Vector3<f64>) -> Result<()> {
        write(&self.instance, &self.disturbances, force.iter().chain(torque.iter()))
    }

    /// Holds a command from `time` on for a period, s; what the cables pulled in the end, and whether one was slack.
    pub fn step(&self, command: &PerCable<f64>, time: f64, period: f64) -> Result<(Vec<f64>, bool)> {
        write(&self.instance, &self.commands, command)?;
        self.instance.do_step(time, period)?;
        let slack = read(&self.instance, &self.slack)?.iter().any(|slack| *slack != 0.0);
        Ok((read(&self.instance, &self.pulled)?, slack))
    }

    /// Pose and rates of the point that the controller takes for the centre of mass.
    pub fn state(&self) -> Result<(Pose, Coordinates)> {
        let numbers = read(&self.instance, &self.state)?;
        let (mut pose, mut rates) = (Pose(Coordinates::from_row_slice(&numbers[..6])), Coordinates::zeros());
        let (velocity, spin) =
            (Vector3::from_row_slice(&numbers[6..9]), Vector3::from_row_slice(&numbers[9..]));
        let arm = pose.rotation() * self.offset;
        let turning = pose.rate_matrix().try_inverse().context("pitch is a right angle")? * spin;
        rates.fixed_rows_mut::<3>(0).copy_from(&(velocity + spin.cross(&arm)));
        rates.fixed_rows_mut::<3>(3).copy_from(&turning);
        let point = pose.position() + arm;
        pose.0.fixed_rows_mut::<3>(0).copy_from(&point);
        Ok((pose, rates))
    }
}

fn write<'a>(
    instance: &Instance,
    variables: &[Variable],
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<()> {
    Ok(variables.iter().zip(values).try_for_each(|(variable, value)| instance.set(variable, *value))?)
}

fn read(instance: &Instance, variables: &[Variable]) -> Result<Vec<f64>> {
    variables.iter().map(|variable| Ok(instance.get(variable)?.as_f64())).collect()
}
