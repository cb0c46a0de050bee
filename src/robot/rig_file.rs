//! Rigs written as TOML: what a file may say, and what is wrong with one that is refused (docs/rigs.md).

use nalgebra::Vector3;
use schemars::{JsonSchema, schema_for};
use serde::Deserialize;
use thiserror::Error;
use toml::Spanned;

use super::{DegenerateRig, Pose, Rig, TensionLimits};

/// The paper's rig: Table I.
const PAPER: &str = include_str!("../../rigs/paper.toml");

/// A rig and what a controller needs besides.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
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
pub enum RigFileError {
    /// No TOML, an unknown or missing field, or a value of the wrong kind.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A value that makes no sense.
    #[error("line {line}: {field} = {value} is not allowed: {allowed}")]
    Value {
        /// Line in the file, from 1.
        line: usize,
        /// The field, with its table; cables and components counted from 1.
        field: String,
        /// The value given.
        value: f64,
        /// What would be right.
        allowed: &'static str,
    },
    /// Every value is right by itself, but the cables cannot hold the platform.
    #[error("line {line}: {cause}")]
    Degenerate {
        /// Line of the first cable.
        line: usize,
        /// Why.
        cause: DegenerateRig,
    },
}

/// A rig for cable-robot. SI units, angles in rad; the base frame has its origin where you like on the base, z pointing down.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "cable-robot rig")]
struct File {
    /// What people call the rig.
    name: String,
    /// Gravitational acceleration along +z, m/s²: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    gravity: Spanned<f64>,
    /// x, y, z of the centre of mass, m, base frame: a place where, with zero orientation, the wrench matrix is regular.
    #[schemars(with = "[f64; 3]")]
    home: Spanned<[f64; 3]>,
    /// What hangs from the cables.
    platform: Platform,
    /// What drives and cables allow.
    tension: Tension,
    /// Gains of the control law.
    gains: Gains,
    /// Six or more, in the order of the cable numbers.
    #[schemars(with = "Vec<Cable>", length(min = 6))]
    cables: Vec<Spanned<Cable>>,
}

/// What hangs from the cables.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Platform {
    /// Mass, kg: greater than 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    mass: Spanned<f64>,
    /// Principal moments of inertia about the centre of mass, along the platform's axes x, y, z, kg m²: each greater than 0.
    #[schemars(with = "[f64; 3]", extend("items" = {"type": "number", "exclusiveMinimum": 0}))]
    inertia: Spanned<[f64; 3]>,
    /// Centre of mass, m, platform frame; (0, 0, 0) if left out.
    #[schemars(with = "[f64; 3]", default, extend("default" = [0, 0, 0]))]
    center_of_mass: Option<Spanned<[f64; 3]>>,
}

/// What drives and cables allow.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Tension {
    /// Least tension of a cable, N: 0 (slack) or greater.
    #[schemars(with = "f64", extend("minimum" = 0))]
    min: Spanned<f64>,
    /// Greatest tension of a cable, N: greater than `min`.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    max: Spanned<f64>,
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
struct Cable {
    /// x, y, z of the end on the base, m, base frame.
    #[schemars(with = "[f64; 3]")]
    anchor: Spanned<[f64; 3]>,
    /// x, y, z of the end on the platform, m, platform frame.
    #[schemars(with = "[f64; 3]")]
    attachment: Spanned<[f64; 3]>,
}

/// JSON Schema of rig files, for editors: everything that can be said of one field at a time.
pub fn schema() -> schemars::Schema {
    schema_for!(File)
}

impl RigFile {
    /// Reads the text of a rig file.
    ///
    /// # Errors
    /// [`RigFileError`]: the line, the field, its value and what is allowed, or why the rig is degenerate.
    pub fn parse(text: &str) -> Result<Self, RigFileError> {
        let file: File = toml::from_str(text)?;
        let check = Check { text };
        let center = match &file.platform.center_of_mass {
            Some(center) => check.vector(center, "platform.center_of_mass")?,
            None => Vector3::zeros(),
        };
        let [mut anchors, mut attachments] = [vec![], vec![]];
        for (i, cable) in file.cables.iter().enumerate() {
            let field = |end: &str| format!("cables[{}].{end}", i + 1);
            anchors.push(check.vector(&cable.get_ref().anchor, &field("anchor"))?);
            attachments.push(check.vector(&cable.get_ref().attachment, &field("attachment"))? - center);
        }
        let home = check.vector(&file.home, "home")?;
        let rig = Rig {
            name: file.name,
            anchors,
            attachments,
            mass: check.positive(&file.platform.mass, "platform.mass")?,
            inertia: check.inertia(&file.platform.inertia)?,
            g: check.positive(&file.gravity, "gravity")?,
            limits: check.limits(&file.tension)?,
        };
        let home = Pose::at(home.x, home.y, home.z);
        let line = check.line(file.cables.first().map_or(0, |cable| cable.span().start));
        rig.check(&home).map_err(|cause| RigFileError::Degenerate { line, cause })?;
        let lambda = check.positive(&file.gains.lambda, "gains.lambda")?;
        let eta = check.positive(&file.gains.eta, "gains.eta")?;
        Ok(Self { rig, home, lambda, eta })
    }
}

impl Default for RigFile {
    /// Table I.
    fn default() -> Self {
        Self::parse(PAPER).expect("a test reads the embedded file")
    }
}

/// Checks values and knows where they stand in the text.
struct Check<'a> {
    text: &'a str,
}

impl Check<'_> {
    fn line(&self, offset: usize) -> usize {
        self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
    }

    /// `ok` or an error for `value`, which stands at `offset`.
    fn require(
        &self,
        ok: bool,
        offset: usize,
        field: &str,
        value: f64,
        allowed: &'static str,
    ) -> Result<(), RigFileError> {
        let error =
            || RigFileError::Value { line: self.line(offset), field: field.to_owned(), value, allowed };
        if ok { Ok(()) } else { Err(error()) }
    }

    fn positive(&self, number: &Spanned<f64>, field: &str) -> Result<f64, RigFileError> {
        let value = *number.get_ref();
        let ok = value.is_finite() && value > 0.0;
        self.require(ok, number.span().start, field, value, "must be finite and greater than 0")?;
        Ok(value)
    }

    fn vector(&self, vector: &Spanned<[f64; 3]>, field: &str) -> Result<Vector3<f64>, RigFileError> {
        for (k, value) in vector.get_ref().iter().enumerate() {
            let component = format!("{field}[{}]", k + 1);
            self.require(value.is_finite(), vector.span().start, &component, *value, "must be finite (m)")?;
        }
        Ok((*vector.get_ref()).into())
    }

    fn inertia(&self, inertia: &Spanned<[f64; 3]>) -> Result<Vector3<f64>, RigFileError> {
        for (k, value) in inertia.get_ref().iter().enumerate() {
            let (ok, component) = (value.is_finite() && *value > 0.0, format!("platform.inertia[{}]", k + 1));
            let allowed = "must be finite and greater than 0 (kg m²)";
            self.require(ok, inertia.span().start, &component, *value, allowed)?;
        }
        Ok((*inertia.get_ref()).into())
    }

    fn limits(&self, tension: &Tension) -> Result<TensionLimits, RigFileError> {
        // A least tension of -0 is 0, and reads better.
        let limits = TensionLimits { min: *tension.min.get_ref() + 0.0, max: *tension.max.get_ref() };
        let ok = limits.min.is_finite() && limits.min >= 0.0;
        let allowed = "must be finite and 0 or greater (N): cables cannot push";
        self.require(ok, tension.min.span().start, "tension.min", limits.min, allowed)?;
        let ok = limits.max.is_finite() && limits.max > limits.min;
        let allowed = "must be finite and greater than tension.min (N)";
        self.require(ok, tension.max.span().start, "tension.max", limits.max, allowed)?;
        Ok(limits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Geometry, RobotParameters};

    /// What is said of the paper's file with one text replaced by another.
    fn refusal(from: &str, to: &str) -> String {
        assert!(PAPER.contains(from), "{from}");
        RigFile::parse(&PAPER.replacen(from, to, 1)).expect_err(to).to_string()
    }

    #[test]
    fn the_embedded_file_is_table_i() {
        let file = RigFile::default();
        let robot = RobotParameters::default();
        let expected = Rig::triangular(&robot, file.rig.limits);
        assert_eq!((file.lambda, file.eta), (3.0, 3.0));
        assert_eq!(file.rig, Rig { name: file.rig.name.clone(), ..expected });
        assert_eq!(file.home, Pose::default());
        let geometry = Geometry::new(&file.rig.as_triangular().unwrap());
        for i in 0..6 {
            assert!((geometry.anchor[i] - Geometry::new(&robot).anchor[i]).amax() < 1e-15);
        }
    }

    #[test]
    fn the_schema_that_is_checked_in_is_that_of_the_file() {
        let there: serde_json::Value =
            serde_json::from_str(include_str!("../../rigs/rig.schema.json")).unwrap();
        let schema = schema().to_value();
        assert!(there == schema, "drifted: `cargo run -- schema rig > rigs/rig.schema.json`");
        // A misspelt field is an error, and every one says what it is.
        for part in schema["$defs"].as_object().unwrap().values().chain([&schema]) {
            assert_eq!(part["additionalProperties"], false);
            for (name, field) in part["properties"].as_object().unwrap() {
                assert!(field.get("description").is_some(), "{name}");
            }
        }
    }

    #[test]
    fn the_example_of_eight_cables_is_right() {
        let file = RigFile::parse(include_str!("../../rigs/eight.toml")).unwrap();
        assert_eq!(file.rig.anchors.len(), 8);
        assert_eq!(file.rig.as_triangular(), None);
    }

    #[test]
    fn attachments_are_taken_from_the_centre_of_mass() {
        let text = PAPER.replacen("[tension]", "center_of_mass = [0.01, -0.02, 0.03]\n[tension]", 1);
        let moved = RigFile::parse(&text).unwrap().rig.attachments[0];
        let plain = RigFile::default().rig.attachments[0];
        assert!((moved - plain - Vector3::new(-0.01, 0.02, -0.03)).amax() < 1e-15);
    }

    #[test]
    fn bad_values_are_named_with_their_line() {
        let line = |text: &str| PAPER.lines().position(|l| l.starts_with(text)).unwrap() + 1;
        let gravity = refusal("gravity = 9.81", "gravity = 0");
        assert_eq!(
            gravity,
            format!(
                "line {}: gravity = 0 is not allowed: must be finite and greater than 0",
                line("gravity")
            )
        );
        let mass = refusal("mass = 6.0", "mass = -6.0");
        assert!(mass.starts_with(&format!("line {}: platform.mass = -6", line("mass"))), "{mass}");
        let swapped = refusal("max = 100.0", "max = -1.0");
        assert!(swapped.contains("tension.max = -1") && swapped.contains("tension.min"), "{swapped}");
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
        assert!(rig.limits.min.is_sign_positive());
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
