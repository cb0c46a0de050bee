//! `cable-robot modelica`: the plant of a rig in plain Modelica, with its n cables.

use std::fmt::Write;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use cable_robot::robot::{Cable, Pose, Rig};
use cable_robot_report::files::write_whole;
use clap::{Args, ValueHint};
use nalgebra::Vector3;

use crate::command::rig::RigArgument;
use crate::command::{Outcome, print};

pub const EXAMPLE: &str = "\
Example: cable-robot modelica --rig rigs/eight.toml --name Eight --output Eight.mo
The model uses CableRobot.Plants.Cable and CableRobot.Interfaces of the package in modelica/ (docs/modelica.md).";

#[derive(Args)]
pub struct Modelica {
    #[command(flatten)]
    rig: RigArgument,
    /// Name of the model: letters, digits and _, no digit first
    #[arg(long, default_value = "Plant")]
    name: String,
    /// File to write; without it stdout
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
}

impl Modelica {
    pub fn run(&self) -> Result<Outcome> {
        let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
        let is_name =
            self.name.starts_with(is_letter) && self.name.chars().all(|c| is_letter(c) || c.is_ascii_digit());
        ensure!(
            is_name,
            "--name {} is no name of a Modelica class: letters, digits and _, no digit first",
            self.name
        );
        let file = self.rig.read()?;
        if let Some(i) = file.rig.cables.iter().position(|cable| cable.pulley.is_some()) {
            anyhow::bail!("cable {} has a pulley: the plant in Modelica knows none", i + 1);
        }
        let text = plant(&self.name, &file.rig, &file.home);
        match &self.output {
            Some(path) => write_whole(path, |file| file.write_all(text.as_bytes()))?,
            None => print(text.trim_end())?,
        }
        Ok(Outcome::Done)
    }
}

/// The parts that do not depend on the rig.
const STATES: &str = include_str!("modelica/states.mo");
const MOTION: &str = include_str!("modelica/motion.mo");
const EULER: &str = include_str!("modelica/euler.mo");
const DRAWING: &str = include_str!("modelica/drawing.mo");

/// The model of a rig, hanging at `home`.
pub fn plant(name: &str, rig: &Rig, home: &Pose) -> String {
    let count = rig.cables.len();
    let mut text = format!("within ;\nmodel {name} \"A platform on {count} cables, in plain equations\"\n");
    let mut line = |part: String| {
        let _ = writeln!(text, "{part}");
    };
    let ends = |cable: &Cable| {
        [("anchor", cable.anchor, "base frame"), ("attachment", cable.attachment, "platform's frame")]
    };
    for end in 0..2 {
        for (i, cable) in rig.cables.iter().enumerate() {
            let ((what, at, frame), i) = (ends(cable)[end], i + 1);
            line(format!(
                "  parameter Real {what}{i}[3](each unit = \"m\") = {} \"Of cable {i}, {frame}\";",
                list(at.as_slice())
            ));
        }
    }
    line(format!("  parameter Real mass(unit = \"kg\") = {:?} \"Mass of the platform\";", rig.mass));
    for ((row, column), name) in TENSOR {
        line(format!(
            "  parameter Real inertia_{name}(unit = \"kg.m2\") = {:?};",
            rig.inertia[(row, column)]
        ));
    }
    let gravity: Vector3<f64> = rig.gravity;
    line(format!(
        "  parameter Real gravity[3](each unit = \"m/s2\") = {} \"Gravitational acceleration, base frame\";",
        list(gravity.as_slice())
    ));
    line(format!(
        "  parameter Real initialPose[6] = {} \"Where the platform hangs, at rest, at the start: m and rad\";",
        list(home.0.as_slice())
    ));
    for (what, direction, extent, says) in CONNECTORS {
        let size = if what == "encoderPose" { 6 } else { count };
        line(format!(
            "  CableRobot.Interfaces.{direction} {what}[{size}] \"{says}\"\n    annotation(Placement(transformation(extent = {extent})));"
        ));
    }
    line(STATES.trim_end().to_owned());
    for i in 1..=count {
        line(cable(i));
    }
    line("equation".to_owned());
    line(MOTION.trim_end().to_owned());
    for (axis, k) in [("x", 1), ("y", 2), ("z", 3)] {
        line(format!("  mass * (der(v_{axis}) - gravity[{k}]) = {};", sum(count, &format!("force_{axis}"))));
    }
    for axis in ["x", "y", "z"] {
        line(format!("  torque_{axis} = {};", sum(count, &format!("torque_{axis}"))));
    }
    line(EULER.trim_end().to_owned());
    for (output, value) in [("cableLength", "length"), ("measuredTension", "pull")] {
        for i in 1..=count {
            line(format!("  {output}[{i}] = cable{i}.{value};"));
        }
    }
    line(DRAWING.trim_end().to_owned());
    line(format!("end {name};"));
    text
}

const TENSOR: [((usize, usize), &str); 6] =
    [((0, 0), "xx"), ((1, 1), "yy"), ((2, 2), "zz"), ((0, 1), "xy"), ((0, 2), "xz"), ((1, 2), "yz")];

const CONNECTORS: [(&str, &str, &str, &str); 4] = [
    ("motorTension", "RealInput", "{{-140, -20}, {-100, 20}}", "What the motors pull, N"),
    ("encoderPose", "RealOutput", "{{100, 50}, {120, 70}}", "Pose of the platform: m and rad"),
    ("cableLength", "RealOutput", "{{100, -10}, {120, 10}}", "m"),
    ("measuredTension", "RealOutput", "{{100, -70}, {120, -50}}", "What the cables pull, N"),
];

fn cable(i: usize) -> String {
    format!(
        "  CableRobot.Plants.Cable cable{i}(
    anchor_x = anchor{i}[1], anchor_y = anchor{i}[2], anchor_z = anchor{i}[3],
    attachment_x = attachment{i}[1], attachment_y = attachment{i}[2], attachment_z = attachment{i}[3],
    motorTension = motorTension[{i}], x = x, y = y, z = z,
    r11 = r11, r12 = r12, r13 = r13, r21 = r21, r22 = r22, r23 = r23, r31 = r31, r32 = r32, r33 = r33);"
    )
}

fn list(values: &[f64]) -> String {
    let numbers: Vec<_> = values.iter().map(|value| format!("{:?}", value + 0.0)).collect();
    format!("{{{}}}", numbers.join(", "))
}

fn sum(count: usize, what: &str) -> String {
    (1..=count).map(|i| format!("cable{i}.{what}")).collect::<Vec<_>>().join(" + ")
}
