//! The two models of the library: which variables they have, and how values become a running controller or plant.

pub mod controller;
pub mod plant;
mod robot;

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::error::FmiError;
use super::values::Values;
use super::variables::{Causality, Row};
use crate::plan::controller::Controller;
use crate::sim::plant::Plant;

/// Which of the two models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Model {
    /// Section V: pose in, motor tensions out.
    Controller,
    /// Section VI: motor tensions in, pose out.
    Plant,
}

/// Both models, in the order of their FMUs.
pub const MODELS: [Model; 2] = [Model::Controller, Model::Plant];

/// A model under way: a copy is cheap and allocates nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "boxing would allocate in every step")]
pub enum Running {
    /// See [`Controller`].
    Controller(Controller),
    /// See [`Plant`].
    Plant(Plant),
}

impl Model {
    /// modelIdentifier: the name of the FMU and of the library in it.
    pub fn identifier(self) -> &'static str {
        match self {
            Model::Controller => "CableRobotController",
            Model::Plant => "CableRobotPlant",
        }
    }

    /// One sentence for the XML.
    pub fn description(self) -> &'static str {
        match self {
            Model::Controller => {
                "Controller and planner of a six-cable suspended robot: set points from which no cable goes slack"
            }
            Model::Plant => {
                "A rigid platform on six cables that pull and never push, with a rig's imperfections"
            }
        }
    }

    /// The variable table, in ascending order of value references.
    pub fn rows(self) -> &'static [&'static Row] {
        match self {
            Model::Controller => controller::ROWS,
            Model::Plant => plant::ROWS,
        }
    }

    /// The row that a value reference belongs to.
    pub fn row(self, reference: u32) -> Option<&'static Row> {
        let rows = self.rows();
        let following = rows.partition_point(|row| row.first <= reference);
        let row = rows[following.checked_sub(1)?];
        row.references().contains(&reference).then_some(row)
    }

    /// The rows with this causality.
    pub fn rows_with(self, causality: Causality) -> impl Iterator<Item = &'static Row> {
        self.rows().iter().copied().filter(move |row| row.causality == causality)
    }

    /// GUID (FMI 2) and instantiation token (FMI 3): derived from the variable table, so that an XML and a library
    /// that do not belong together are told apart.
    pub fn token(self) -> &'static str {
        static TOKENS: LazyLock<[String; 2]> = LazyLock::new(|| {
            MODELS.map(|model| {
                let table =
                    format!("{} {} {:?}", model.identifier(), env!("CARGO_PKG_VERSION"), model.rows());
                Uuid::new_v5(&Uuid::NAMESPACE_URL, table.as_bytes()).to_string()
            })
        });
        &TOKENS[self as usize]
    }

    /// The model that has this token.
    pub fn with_token(token: &str) -> Option<Self> {
        MODELS.into_iter().find(|model| model.token() == token)
    }

    /// Starts the model with the parameters and inputs in `values`, and writes its first outputs there.
    ///
    /// # Errors
    /// [`FmiError::Parameter`] naming the first parameter that makes no sense.
    pub fn start(self, values: &mut Values, time: f64) -> Result<Running, FmiError> {
        let running = match self {
            Model::Controller => Running::Controller(controller::start(values, time)?),
            Model::Plant => Running::Plant(plant::start(values)?),
        };
        running.write_outputs(values);
        Ok(running)
    }

    /// What is allowed and yet worth a word.
    pub fn warning(self, values: &Values) -> Option<String> {
        let robot = robot::parameters(values);
        (!robot.inertia_is_physical()).then(|| {
            format!(
                "I1 = {}, I2 = {}, I3 = {} kg.m2 cannot belong to a rigid body: the largest exceeds the sum of the other \
                 two. Table I of the paper is such a set; the equations accept it.",
                robot.i1, robot.i2, robot.i3
            )
        })
    }
}

impl Running {
    /// Which model this is.
    pub fn model(&self) -> Model {
        match self {
            Running::Controller(_) => Model::Controller,
            Running::Plant(_) => Model::Plant,
        }
    }

    /// Goes from `time` to `time + h` with the inputs in `values` held. The controller samples them at `time`.
    ///
    /// # Errors
    /// [`FmiError::Plant`] when the motion cannot be integrated.
    pub fn step(&mut self, values: &Values, time: f64, h: f64) -> Result<(), FmiError> {
        match self {
            Running::Controller(controller) => controller.step(time, &controller::inputs(values)),
            Running::Plant(plant) => plant.step(&plant::inputs(values), h)?,
        }
        Ok(())
    }

    /// Copies the outputs into `values`.
    pub fn write_outputs(&self, values: &mut Values) {
        match self {
            Running::Controller(controller) => controller::write(controller.outputs(), values),
            Running::Plant(plant) => plant::write(plant.outputs(), values),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::fmi::variables::Kind;

    #[test]
    fn value_references_ascend_without_overlap() {
        for model in MODELS {
            for pair in model.rows().windows(2) {
                assert!(pair[0].references().end <= pair[1].first, "{} meets {}", pair[0].name, pair[1].name);
            }
        }
    }

    #[test]
    fn every_reference_finds_its_row_and_no_other_does() {
        for model in MODELS {
            let known: Vec<u32> = model.rows().iter().flat_map(|row| row.references()).collect();
            for reference in (0..400).chain([u32::MAX]) {
                let found = model.row(reference).is_some_and(|row| row.references().contains(&reference));
                assert_eq!(found, known.contains(&reference), "{reference}");
            }
        }
    }

    #[test]
    fn start_values_exist_where_the_standard_wants_them() {
        for row in MODELS.iter().flat_map(|model| model.rows()) {
            let wanted = matches!(row.causality, Causality::Parameter | Causality::Input);
            let each = row.references().all(|reference| row.start_of(reference).is_some());
            assert_eq!(each, wanted, "{}", row.name);
        }
    }

    /// What the domain refuses and what the table says are two statements of one fact.
    #[test]
    fn parameters_beyond_their_range_do_not_start() {
        for model in MODELS {
            for row in model.rows_with(Causality::Parameter) {
                for bad in row.min.map(|min| min - 1.0).into_iter().chain(row.max.map(|max| max + 1.0)) {
                    let mut values = Values::new(model.rows());
                    values.put(row.first, bad);
                    let message = model.start(&mut values, 0.0).unwrap_err().to_string();
                    assert!(message.contains(&format!("{} = {bad}", row.name)), "{message}");
                }
            }
        }
    }

    /// Start values from which every dependency shows: the ordinary start, the other settings, bad measurements.
    fn points(model: Model) -> Vec<Values> {
        let start = Values::new(model.rows());
        const LOW: [(&str, f64); 8] = [
            ("poseSource", 2.0),
            ("encoderPose.z", 0.15),
            ("cableLength[1]", 0.47),
            ("cableLength[2]", 0.47),
            ("cableLength[3]", 0.47),
            ("cableLength[4]", 0.47),
            ("cableLength[5]", 0.47),
            ("cableLength[6]", 0.47),
        ];
        let settings: &[&[(&str, f64)]] = match model {
            Model::Controller => &[
                &[],
                &[("enable", 0.0)],
                &[("enable", 0.0), ("minTension", 2.0)],
                &[("poseSource", 2.0)],
                &[("poseSource", 2.0), ("encoderPose.x", 0.02)],
                &[("poseSource", 2.0), ("cableLength[1]", 0.1), ("maxTension", 5.0)],
                &LOW,
                &[("forceLoop", 1.0)],
                &[("encoderPose.z", -1.0)],
                &[("minTension", 15.0)],
                &[("maxTension", 5.0)],
            ],
            Model::Plant => &[
                &[],
                &[("encoderResolution", 1e-3)],
                &[("loadCellNoise", 0.1)],
                &[("friction", 1.0), ("motorLag", 0.1)],
                &[("initialPose.x", 0.1), ("initialPose.roll", 0.1)],
            ],
        };
        let with = |changes: &&[(&str, f64)]| {
            let mut values = start.clone();
            changes.iter().for_each(|(name, value)| values.put(reference(model, name), *value));
            values
        };
        settings.iter().map(with).collect()
    }

    fn reference(model: Model, name: &str) -> u32 {
        let mut all =
            model.rows().iter().flat_map(|row| row.references().map(move |i| (row.scalar_name(i), i)));
        all.find(|(known, _)| known == name).unwrap().1
    }

    /// (name of an output row, name of a row it was seen to depend on at the start), by changing one value at a time.
    fn observed(model: Model) -> BTreeSet<(&'static str, &'static str)> {
        let mut found = BTreeSet::new();
        for point in points(model) {
            let mut before = point.clone();
            model.start(&mut before, 0.0).unwrap();
            for known in model.rows().iter().filter(|row| row.causality != Causality::Output) {
                for reference in known.references() {
                    for value in others(known, point.at(reference)) {
                        let mut after = point.clone();
                        after.put(reference, value);
                        if model.start(&mut after, 0.0).is_ok() {
                            let outputs = model.rows_with(Causality::Output);
                            let changed =
                                outputs.filter(|row| row.references().any(|i| before.at(i) != after.at(i)));
                            found.extend(changed.map(|row| (row.name, known.name)));
                        }
                    }
                }
            }
        }
        found
    }

    fn others(row: &Row, value: f64) -> Vec<f64> {
        match row.kind {
            Kind::Float64 => vec![value * 1.001 + 1e-4, value - 1e-3, 0.3 * value, -value, 0.0, 20.0],
            Kind::Int32 => vec![value + 1.0],
            Kind::Boolean => vec![1.0 - value],
            Kind::Enumeration(kind) => (1..=kind.items.len()).map(|item| item as f64).collect(),
        }
    }

    #[test]
    fn outputs_depend_at_the_start_on_exactly_what_the_table_says() {
        for model in MODELS {
            let outputs = model.rows_with(Causality::Output);
            let declared: BTreeSet<_> =
                outputs.flat_map(|row| row.depends_on.iter().map(|known| (row.name, known.name))).collect();
            let observed = observed(model);
            let (missing, false_ones): (Vec<_>, Vec<_>) =
                (observed.difference(&declared).collect(), declared.difference(&observed).collect());
            assert_eq!(
                (missing, false_ones),
                (vec![], vec![]),
                "(missing, never seen) in {}",
                model.identifier()
            );
        }
    }

    #[test]
    fn the_models_have_different_tokens() {
        assert_ne!(Model::Controller.token(), Model::Plant.token());
        assert_eq!(Model::with_token(Model::Plant.token()), Some(Model::Plant));
        assert_eq!(Model::with_token("something else"), None);
    }
}
