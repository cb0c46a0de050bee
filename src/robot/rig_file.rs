//! Rigs written as TOML: what a file may say, and what is wrong with one that is refused (docs/rigs.md).

use nalgebra::{Matrix3, Vector3, Vector6};
use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema, schema_for};
use serde::Deserialize;
use serde_json::Value;
use thiserror::Error;
use toml::Spanned;

use super::{Cable, DegenerateRig, MOST_CABLES, PerCable, Pose, Pulley, Rig, TensionLimits};
use crate::checked_toml::{Checked, Refused};

/// The paper's rig: Table I.
const PAPER: &str = include_str!("../../rigs/paper.toml");

/// A rig and what a controller needs besides.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// What people call the rig.
    pub name: String,
    /// The rig.
    pub rig: Rig,
    /// A pose at which the wrench matrix is regular.
    pub home: Pose,
    /// λ₀, 1/s.
    pub lambda: f64,
    /// η₀, 1/s.
    pub eta: f64,
}

/// A rig file that is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RigFileError {
    /// No TOML, an unknown or missing field, or a value of the wrong kind.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A value that makes no sense.
    #[error(transparent)]
    Value(#[from] Refused),
    /// Every value is right by itself, but the cables cannot hold the platform.
    #[error("line {line}: {cause}")]
    Degenerate {
        /// Line of the first cable.
        line: usize,
        /// Why.
        cause: DegenerateRig,
    },
    /// More cables than the program supports.
    #[error("line {line}: {count} cables: at most {MOST_CABLES} are supported")]
    TooManyCables {
        /// Line of the first cable.
        line: usize,
        /// How many there are.
        count: usize,
    },
    /// No cable pulls against gravity.
    #[error("line {line}: home lies above every anchor: no cable can hold the platform there. {hint}")]
    AboveAnchors {
        /// Line of `home`.
        line: usize,
        /// What may be meant.
        hint: &'static str,
    },
}

/// A rig for cable-robot. SI units, angles in rad, R = Rz(yaw) Ry(pitch) Rx(roll). The base frame has its origin where you like; `frame` says
/// which way z points. Poses are those of the centre of mass in this frame.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "cable-robot rig")]
struct File {
    /// What people call the rig.
    name: String,
    /// Which way the z axes of base and platform point at zero orientation; z-down if left out.
    #[serde(default)]
    frame: Frame,
    /// Gravitational acceleration, m/s²: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    gravity: Spanned<f64>,
    /// x, y, z of the centre of mass, m, base frame: a place where, with zero orientation, the wrench matrix is regular.
    #[schemars(with = "[f64; 3]")]
    home: Spanned<[f64; 3]>,
    /// Anchors and attachments lie within this distance of where the file says, m: 0 or greater; 0 if left out.
    #[schemars(with = "f64", default, extend("minimum" = 0, "default" = 0))]
    accuracy: Option<Spanned<f64>>,
    /// What hangs from the cables.
    platform: Platform,
    /// What drives and cables allow.
    tension: Tension,
    /// Gains of the control law.
    gains: Gains,
    /// Six to sixteen, in the order of the cable numbers.
    #[schemars(with = "Vec<CableEntry>", length(min = 6, max = 16))]
    cables: Vec<Spanned<CableEntry>>,
}

/// Which way z points.
#[derive(Clone, Copy, Default, Deserialize, JsonSchema)]
enum Frame {
    /// z points down, along gravity.
    #[default]
    #[serde(rename = "z-down")]
    ZDown,
    /// z points up, against gravity.
    #[serde(rename = "z-up")]
    ZUp,
}

impl Frame {
    fn gravity(self, g: f64) -> Vector3<f64> {
        match self {
            Self::ZDown => Vector3::new(0.0, 0.0, g),
            Self::ZUp => Vector3::new(0.0, 0.0, -g),
        }
    }

    fn other(self) -> &'static str {
        match self {
            Self::ZDown => "Does z point up in this file? Then say frame = \"z-up\"",
            Self::ZUp => "Does z point down in this file? Then leave out frame = \"z-up\"",
        }
    }
}

/// What hangs from the cables.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Platform {
    /// Mass, kg: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    mass: Spanned<f64>,
    /// Moments of inertia Ixx, Iyy, Izz about the centre of mass, along the platform's axes, kg m²: each greater than 0.
    #[schemars(with = "[f64; 3]", extend("items" = {"type": "number", "exclusiveMinimum": 0}))]
    inertia: Spanned<[f64; 3]>,
    /// Elements Ixy, Ixz, Iyz of the inertia tensor, kg m²; 0 if left out. (A product of inertia is often given with the other sign.)
    #[schemars(with = "[f64; 3]", default, extend("default" = [0, 0, 0]))]
    inertia_off_diagonal: Option<Spanned<[f64; 3]>>,
    /// Centre of mass, m, platform frame; (0, 0, 0) if left out.
    #[schemars(with = "[f64; 3]", default, extend("default" = [0, 0, 0]))]
    center_of_mass: Option<Spanned<[f64; 3]>>,
}

/// What drives and cables allow. A cable may have limits of its own.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Tension {
    /// Least tension of a cable, N: 0 (slack) or greater.
    #[schemars(with = "f64", extend("minimum" = 0))]
    min: Spanned<f64>,
    /// Greatest tension of a cable, N: greater than `min`; left out where nothing limits it.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    max: Option<Spanned<f64>>,
}

/// Gains of the control law.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Gains {
    /// λ₀ of Eq. (2), 1/s: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    lambda: Spanned<f64>,
    /// η₀ of Eq. (4), 1/s: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    eta: Spanned<f64>,
}

/// A cable from an anchor on the base to an attachment on the platform.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Cable")]
struct CableEntry {
    /// x, y, z of the end on the base, m, base frame. With a pulley: where the cable runs onto it, a point of its swivel axis.
    #[schemars(with = "[f64; 3]")]
    anchor: Spanned<[f64; 3]>,
    /// x, y, z of the end on the platform, m, platform frame.
    #[schemars(with = "[f64; 3]")]
    attachment: Spanned<[f64; 3]>,
    /// Least tension of this cable, N; `tension.min` if left out.
    #[schemars(with = "f64", default, extend("minimum" = 0))]
    min_tension: Option<Spanned<f64>>,
    /// Greatest tension of this cable, N; `tension.max` if left out.
    #[schemars(with = "f64", default, extend("exclusiveMinimum" = 0))]
    max_tension: Option<Spanned<f64>>,
    /// The swivelling pulley at the anchor; none if left out.
    #[schemars(default)]
    pulley: Option<PulleyEntry>,
}

/// A guide pulley that swivels about the line along which the cable comes from the winch.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Pulley")]
struct PulleyEntry {
    /// Radius to the middle of the cable, m: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    radius: Spanned<f64>,
    /// x, y, z of the way the cable runs at the anchor, from the winch, base frame; of any length.
    #[schemars(with = "[f64; 3]")]
    axis: Spanned<[f64; 3]>,
}

/// JSON Schema of rig files, for editors: everything that can be said of one field at a time.
pub fn schema() -> Schema {
    let mut schema = schema_for!(File);
    without_null(&mut schema);
    schema
}

/// What may be left out has no null in its place: TOML knows none, nor do proof files.
pub fn without_null(schema: &mut Schema) {
    let tidy = |part: &mut Schema| {
        if part.get("default").is_some_and(Value::is_null) {
            part.remove("default");
        }
    };
    RecursiveTransform(tidy).transform(schema);
}

impl RigFile {
    /// Reads the text of a rig file.
    ///
    /// # Errors
    /// [`RigFileError`]: the line, the field, its value and what is allowed, or why the rig is degenerate.
    pub fn parse(text: &str) -> Result<Self, RigFileError> {
        let file: File = toml::from_str(text)?;
        let check = Checked { text };
        let center = match &file.platform.center_of_mass {
            Some(center) => check.vector(center, "platform.center_of_mass", "m")?,
            None => Vector3::zeros(),
        };
        let line = check.line(file.cables.first().map_or(0, |cable| cable.span().start));
        let mut cables = vec![];
        for (i, cable) in file.cables.iter().enumerate() {
            let mut cable =
                self::cable(&check, cable.get_ref(), &file.tension, &format!("cables[{}]", i + 1))?;
            cable.attachment -= center;
            cables.push(cable);
        }
        let count = cables.len();
        let home = check.vector(&file.home, "home", "m")?;
        let rig = Rig {
            cables: PerCable::from_slice(&cables).ok_or(RigFileError::TooManyCables { line, count })?,
            mass: check.positive(&file.platform.mass, "platform.mass", "kg")?,
            inertia: inertia(&check, &file.platform)?,
            gravity: file.frame.gravity(check.positive(&file.gravity, "gravity", "m/s²")?),
            accuracy: accuracy(&check, file.accuracy.as_ref())?,
            disturbance: Vector6::zeros(),
        };
        let pose = Pose::at(home.x, home.y, home.z);
        rig.check(&pose).map_err(|cause| RigFileError::Degenerate { line, cause })?;
        if !rig.can_be_at(&pose) {
            let line = check.line(file.home.span().start);
            return Err(RigFileError::AboveAnchors { line, hint: file.frame.other() });
        }
        let lambda = check.positive(&file.gains.lambda, "gains.lambda", "1/s")?;
        let eta = check.positive(&file.gains.eta, "gains.eta", "1/s")?;
        Ok(Self { name: file.name, rig, home: pose, lambda, eta })
    }
}

impl Default for RigFile {
    /// Table I.
    fn default() -> Self {
        Self::parse(PAPER).expect("a test reads the embedded file")
    }
}

fn inertia(check: &Checked, platform: &Platform) -> Result<Matrix3<f64>, Refused> {
    let diagonal = &platform.inertia;
    for (k, value) in diagonal.get_ref().iter().enumerate() {
        let (ok, component) = (value.is_finite() && *value > 0.0, format!("platform.inertia[{}]", k + 1));
        check.require(ok, diagonal, &component, value, "must be finite and greater than 0 (kg m²)")?;
    }
    let [xx, yy, zz] = *diagonal.get_ref();
    let Some(off_diagonal) = &platform.inertia_off_diagonal else {
        return Ok(Matrix3::from_diagonal(&Vector3::new(xx, yy, zz)));
    };
    let off = check.vector(off_diagonal, "platform.inertia_off_diagonal", "kg m²")?;
    let tensor = Matrix3::new(xx, off.x, off.y, off.x, yy, off.z, off.y, off.z, zz);
    let allowed =
        "with platform.inertia it must make a tensor whose principal moments are greater than 0 (kg m²)";
    let ok = tensor.cholesky().is_some();
    check.require(ok, off_diagonal, "platform.inertia_off_diagonal[1]", off.x, allowed)?;
    Ok(tensor)
}

fn accuracy(check: &Checked, accuracy: Option<&Spanned<f64>>) -> Result<f64, Refused> {
    let Some(accuracy) = accuracy else { return Ok(0.0) };
    let value = *accuracy.get_ref() + 0.0;
    let ok = value.is_finite() && value >= 0.0;
    check.require(ok, accuracy, "accuracy", value, "must be finite and 0 or greater (m)")?;
    Ok(value)
}

fn cable(check: &Checked, cable: &CableEntry, tension: &Tension, name: &str) -> Result<Cable, Refused> {
    Ok(Cable {
        anchor: check.vector(&cable.anchor, &format!("{name}.anchor"), "m")?,
        attachment: check.vector(&cable.attachment, &format!("{name}.attachment"), "m")?,
        limits: limits(check, cable, tension, name)?,
        pulley: cable.pulley.as_ref().map(|entry| pulley(check, entry, name)).transpose()?,
    })
}

fn pulley(check: &Checked, pulley: &PulleyEntry, name: &str) -> Result<Pulley, Refused> {
    let axis = check.vector(&pulley.axis, &format!("{name}.pulley.axis"), "m")?;
    let length = axis.norm();
    let field = format!("length of {name}.pulley.axis");
    check.require(length.is_normal(), &pulley.axis, &field, length, "must be greater than 0")?;
    let radius = check.positive(&pulley.radius, &format!("{name}.pulley.radius"), "m")?;
    Ok(Pulley { radius, axis: axis / length })
}

/// A cable's own limits, or else those of all.
fn limits(
    check: &Checked,
    cable: &CableEntry,
    tension: &Tension,
    name: &str,
) -> Result<TensionLimits, Refused> {
    let named = |own: &Option<Spanned<f64>>, field: &str| match own {
        Some(_) => format!("{name}.{field}_tension"),
        None => format!("tension.{field}"),
    };
    let (min, max) = (named(&cable.min_tension, "min"), named(&cable.max_tension, "max"));
    let least = cable.min_tension.as_ref().unwrap_or(&tension.min);
    let greatest = cable.max_tension.as_ref().or(tension.max.as_ref());
    // A least tension of -0 is 0, and reads better.
    let limits = TensionLimits {
        min: *least.get_ref() + 0.0,
        max: greatest.map_or(f64::INFINITY, |greatest| *greatest.get_ref()),
    };
    let ok = limits.min.is_finite() && limits.min >= 0.0;
    let allowed = "must be finite and 0 or greater (N): cables cannot push";
    check.require(ok, least, &min, limits.min, allowed)?;
    let allowed = "must be greater than the least tension (N)";
    check.require(limits.max > limits.min, greatest.unwrap_or(least), &max, limits.max, allowed)?;
    Ok(limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::RobotParameters;

    /// What is said of the paper's file with one text replaced by another.
    fn refusal(from: &str, to: &str) -> String {
        assert!(PAPER.contains(from), "{from}");
        RigFile::parse(&PAPER.replacen(from, to, 1)).expect_err(to).to_string()
    }

    #[test]
    fn the_embedded_file_is_table_i() {
        let file = RigFile::default();
        let limits = TensionLimits { min: 0.0, max: 100.0 };
        assert_eq!((file.lambda, file.eta), (3.0, 3.0));
        assert_eq!(file.rig, Rig::paper(&RobotParameters::default(), limits));
        assert_eq!(file.home, Pose::default());
    }

    #[test]
    fn the_schema_that_is_checked_in_is_that_of_the_file() {
        let there: serde_json::Value =
            serde_json::from_str(include_str!("../../rigs/rig.schema.json")).unwrap();
        let schema = schema().to_value();
        assert!(there == schema, "drifted: `cargo run -- schema rig > rigs/rig.schema.json`");
        // A misspelt field is an error, and every one says what it is.
        let tables = schema["$defs"].as_object().unwrap().values().chain([&schema]);
        for part in tables.filter(|part| part["type"] == "object") {
            assert_eq!(part["additionalProperties"], false);
            for (name, field) in part["properties"].as_object().unwrap() {
                assert!(field.get("description").is_some() || field.get("$ref").is_some(), "{name}");
            }
        }
    }

    #[test]
    fn the_example_of_eight_cables_is_right() {
        let file = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
        assert_eq!(file.rig.cables.len(), 8);
    }

    #[test]
    fn attachments_are_taken_from_the_centre_of_mass() {
        let text = PAPER.replacen("[tension]", "center_of_mass = [0.01, -0.02, 0.03]\n[tension]", 1);
        let moved = RigFile::parse(&text).unwrap().rig.cables[0].attachment;
        let plain = RigFile::default().rig.cables[0].attachment;
        assert!((moved - plain - Vector3::new(-0.01, 0.02, -0.03)).amax() < 1e-15);
    }

    #[test]
    fn bad_values_are_named_with_their_line() {
        let line = |text: &str| PAPER.lines().position(|l| l.starts_with(text)).unwrap() + 1;
        let gravity = refusal("gravity = 9.81", "gravity = 0");
        assert_eq!(
            gravity,
            format!(
                "line {}: gravity = 0 is not allowed: must be finite and greater than 0 (m/s²)",
                line("gravity")
            )
        );
        let mass = refusal("mass = 6.0", "mass = -6.0");
        assert!(mass.starts_with(&format!("line {}: platform.mass = -6", line("mass"))), "{mass}");
        let swapped = refusal("max = 100.0", "max = -1.0");
        assert!(
            swapped.contains("tension.max = -1 is not allowed: must be greater than the least"),
            "{swapped}"
        );
        let push = refusal("min = 0.0", "min = -0.5");
        assert!(push.contains("tension.min = -0.5"), "{push}");
        let nan = refusal("anchor = [-0.519", "anchor = [nan, 0.0, 0.0] #");
        assert!(nan.contains("cables[5].anchor[1] = NaN"), "{nan}");
        let infinite = refusal("home = [0.0, 0.0, 1.0]", "home = [0.0, inf, 1.0]");
        assert!(infinite.contains("home[2] = inf"), "{infinite}");
        let far = refusal("attachment = [0.2886", "attachment = [0.0, -inf, 0.0] #");
        assert!(far.contains("cables[2].attachment[2] = -inf"), "{far}");
    }

    #[test]
    fn a_least_tension_of_minus_zero_is_zero() {
        let rig = RigFile::parse(&PAPER.replacen("min = 0.0", "min = -0.0", 1)).unwrap().rig;
        assert!(rig.cables[0].limits.min.is_sign_positive());
    }

    #[test]
    fn a_cable_may_have_limits_and_a_pulley_of_its_own() {
        let own = "min_tension = 2.0\nmax_tension = 50.0\npulley = { radius = 0.1, axis = [0, 0, -2] }\nattachment = [0.2886";
        let text = PAPER.replacen("attachment = [0.2886", own, 1);
        let rig = RigFile::parse(&text).unwrap().rig;
        assert_eq!(rig.cables[1].limits, TensionLimits { min: 2.0, max: 50.0 });
        assert_eq!(rig.cables[0].limits, TensionLimits { min: 0.0, max: 100.0 });
        assert_eq!(rig.cables[1].pulley, Some(Pulley { radius: 0.1, axis: -Vector3::z() }));
        let error = refusal("attachment = [0.2886", &own.replace("50.0", "1.0"));
        assert!(error.contains("cables[2].max_tension = 1 is not"), "{error}");
        let error = refusal("attachment = [0.2886", &own.replace("-2]", "0]"));
        assert!(error.contains("cables[2].pulley.axis"), "{error}");
    }

    #[test]
    fn without_a_greatest_tension_nothing_limits_it() {
        let rig = RigFile::parse(&PAPER.replacen("max = 100.0", "", 1)).unwrap().rig;
        assert_eq!(rig.cables[3].limits, TensionLimits::default());
        let rig = RigFile::parse(&PAPER.replacen("max = 100.0", "max = inf", 1)).unwrap().rig;
        assert_eq!(rig.cables[3].limits.max, f64::INFINITY);
    }

    #[test]
    fn the_full_inertia_tensor_can_be_given_and_must_be_one() {
        let with = |off: &str| format!("inertia = [0.018, 0.018, 0.075]\ninertia_off_diagonal = {off}");
        let line = PAPER.lines().find(|line| line.starts_with("inertia")).unwrap();
        let rig = RigFile::parse(&PAPER.replacen(line, &with("[0.001, 0.002, 0.003]"), 1)).unwrap().rig;
        assert_eq!((rig.inertia[(0, 1)], rig.inertia[(2, 0)], rig.inertia[(1, 2)]), (0.001, 0.002, 0.003));
        let error = refusal(line, &with("[0.02, 0.0, 0.0]"));
        assert!(error.contains("inertia_off_diagonal[1] = 0.02"), "{error}");
    }

    #[test]
    fn a_file_with_z_up_is_read_as_it_says_and_taken_for_z_down_with_a_hint() {
        let up: String = PAPER.replace("home = [0.0, 0.0, 1.0]", "home = [0.0, 0.0, -1.0]");
        let error = RigFile::parse(&up).unwrap_err().to_string();
        assert!(error.contains("above every anchor") && error.contains("frame = \"z-up\""), "{error}");
        let file = RigFile::parse(&format!("frame = \"z-up\"\n{up}")).unwrap();
        assert_eq!(file.rig.gravity, Vector3::new(0.0, 0.0, -9.81));
    }

    #[test]
    fn seventeen_cables_are_too_many() {
        let cable = "\n[[cables]]\nanchor = [1.0, 0.0, 0.0]\nattachment = [0.1, 0.0, 0.0]\n";
        let error = RigFile::parse(&format!("{PAPER}{}", cable.repeat(11))).unwrap_err().to_string();
        assert!(error.contains("17 cables: at most 16"), "{error}");
    }

    #[test]
    fn unknown_missing_and_mistyped_fields_are_named_with_their_line() {
        let unknown = refusal("mass = 6.0", "wheight = 6.0\nmass = 6.0");
        assert!(
            unknown.contains("line ") && unknown.contains("wheight") && unknown.contains("mass"),
            "{unknown}"
        );
        let missing = refusal("lambda = 3.0", "");
        assert!(missing.contains("line ") && missing.contains("lambda"), "{missing}");
        let text = refusal("mass = 6.0", "mass = \"heavy\"");
        assert!(text.contains("heavy") && text.contains("line "), "{text}");
        let two = refusal("home = [0.0, 0.0, 1.0]", "home = [0.0, 1.0]");
        assert!(two.contains("line ") && two.contains("3"), "{two}");
    }

    #[test]
    fn degenerate_rigs_are_refused_with_the_cause() {
        let five: String = PAPER.rsplit_once("[[cables]]").unwrap().0.to_owned();
        let error = RigFile::parse(&five).unwrap_err().to_string();
        assert!(error.contains("5 given, at least 6"), "{error}");
        let anchors = [0.26, 0.2, 0.1, 0.0, -0.2, -0.5].map(|x| format!("anchor = [{x}, 0.0, 0.0]"));
        let mut next = anchors.iter();
        let on_a_line: Vec<_> =
            PAPER.lines().map(|l| if l.starts_with("anchor =") { next.next().unwrap() } else { l }).collect();
        let error = RigFile::parse(&on_a_line.join("\n")).unwrap_err().to_string();
        assert!(error.contains("anchors all lie on one line") && error.starts_with("line "), "{error}");
        let error = refusal("home = [0.0, 0.0, 1.0]", "home = [0.0, 0.0, 0.0]");
        assert!(error.contains("one plane at the home pose"), "{error}");
    }
}
