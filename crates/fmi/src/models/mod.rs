//! The models of the library: which variables they have, and how values become a running controller or plant.

pub mod controller;
pub mod exchange;
mod interface;
pub mod node;
pub mod plant;
mod robot;

use serde::{Deserialize, Serialize};

use super::error::FmiError;
use super::values::Values;
use cable_robot::plan::{Check, Controller, Fault};
use cable_robot::sim::{ContinuousPlant, Plant};

pub use interface::{Interface, Scalar, VARIANTS, Variant};
pub use node::NodeKind;

/// Which model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Model {
    /// Section V: pose in, motor tensions out.
    Controller,
    /// Section VI: motor tensions in, pose out.
    Plant,
    /// The same for an importer's own integrator.
    PlantExchange,
    /// Behind the frames of a CAN bus (FMI-LS-BUS); not among [`MODELS`], since it is made for a fieldbus file.
    Node(NodeKind),
}

/// What an importer does with a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// It asks for steps.
    CoSimulation,
    /// It asks for steps, and handles events between them (FMI 3).
    CoSimulationWithEvents,
    /// The same of a node on buses, which exchanges frames in events.
    OnBuses,
    /// It integrates the derivatives.
    ModelExchange,
}

/// All models, in the order of their FMUs.
pub const MODELS: [Model; 3] = [Model::Controller, Model::Plant, Model::PlantExchange];
/// Those that step by themselves.
pub const CO_SIMULATION: [Model; 2] = [Model::Controller, Model::Plant];

/// A model under way: a copy is cheap and allocates nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "boxing would allocate in every step")]
pub enum Running {
    /// See [`Controller`].
    Controller(Controller),
    /// See [`Plant`].
    Plant(Plant),
    /// See [`ContinuousPlant`].
    PlantExchange(ContinuousPlant),
}

impl Use {
    /// Why what belongs to the other use is refused.
    pub fn refusal(self) -> &'static str {
        match self {
            Use::CoSimulation | Use::CoSimulationWithEvents => {
                "this FMU has Co-Simulation only, not Model Exchange"
            }
            Use::OnBuses => {
                "this FMU is a node on buses: it has Co-Simulation with Event Mode only, and no saved states"
            }
            Use::ModelExchange => "this FMU has Model Exchange only, not Co-Simulation",
        }
    }
}

impl Model {
    /// modelIdentifier: the name of the FMU and of the library in it.
    pub fn identifier(self) -> &'static str {
        match self {
            Model::Controller => "CableRobotController",
            Model::Plant => "CableRobotPlant",
            Model::PlantExchange => "CableRobotPlantME",
            Model::Node(NodeKind::Controller) => "CableRobotCanController",
            Model::Node(NodeKind::Rig) => "CableRobotCanRig",
        }
    }

    /// What it is for.
    pub fn usage(self) -> Use {
        match self {
            Model::Controller | Model::Plant => Use::CoSimulation,
            Model::PlantExchange => Use::ModelExchange,
            Model::Node(_) => Use::OnBuses,
        }
    }

    /// The model with the paper's rig.
    pub fn interface(self) -> Interface {
        Interface::of_paper(self)
    }
}

impl Running {
    /// Goes from `time` to `time + h` with the inputs in `values` held. The controller samples them at `time`.
    ///
    /// # Errors
    /// [`FmiError::Plant`] when the motion cannot be integrated, [`FmiError::Parameter`] for a parameter that was changed and makes no sense.
    pub fn step(
        &mut self,
        interface: &Interface,
        values: &Values,
        time: f64,
        h: f64,
    ) -> Result<(), FmiError> {
        match self {
            Running::Controller(controller) => {
                let tuning = controller::tuning(interface, values);
                if tuning != controller.tuning() {
                    controller.tune(&tuning)?;
                }
                controller.step(time, h, &controller::inputs(values));
            }
            Running::Plant(plant) => plant.step(&plant::inputs(values), h)?,
            // Its importer integrates.
            Running::PlantExchange(_) => {}
        }
        Ok(())
    }

    /// Whether a run with these values can have come to this at `time` (s): before a saved one is taken up.
    ///
    /// # Errors
    /// [`FmiError::Memory`] for the first part that makes no sense.
    pub fn check(&self, interface: &Interface, values: &Values, time: f64) -> Result<(), FmiError> {
        let is_of_these = match self {
            Running::Controller(controller) => {
                controller.check()?;
                interface.model() == Model::Controller
                    && controller::is_of(interface, values, controller, time)
            }
            Running::Plant(plant) => {
                plant.check()?;
                interface.model() == Model::Plant
                    && *plant.parameters() == plant::plant_parameters(interface, values)
            }
            Running::PlantExchange(plant) => {
                plant.check()?;
                interface.model() == Model::PlantExchange
                    && *plant.parameters() == plant::plant_parameters(interface, values)
            }
        };
        let mut written = values.clone();
        self.write_outputs(&mut written);
        // What an integrator is shown is calculated when it asks.
        if is_of_these && (interface.model() == Model::PlantExchange || written.are(values)) {
            return Ok(());
        }
        Err(FmiError::State("its values are not those of its memory".to_owned()))
    }

    /// The controller's fault, if it has one.
    pub fn fault(&self) -> Option<&Fault> {
        match self {
            Running::Controller(controller) => {
                Some(&controller.outputs().fault).filter(|fault| fault.check != Check::None)
            }
            Running::Plant(_) | Running::PlantExchange(_) => None,
        }
    }

    /// What the controller has found of when its commands act, if that is not as its parameters say: by how much later (s; less than 0: earlier) and
    /// what was said.
    pub fn late(&self) -> Option<[f64; 2]> {
        let Running::Controller(controller) = self else { return None };
        Some([controller.late()?, controller.parameters().command_delay])
    }

    /// When the planner decides next, s; not before the time reached. `None` for what plans nothing now.
    pub fn next_decision(&self) -> Option<f64> {
        let Running::Controller(controller) = self else { return None };
        controller.next_decision()
    }

    /// The longest step that may be asked for with the inputs in `values`, s. A controller that is not enabled promises nothing.
    pub fn longest_step(&self, values: &Values) -> f64 {
        match self {
            Running::Controller(controller) if controller::is_enabled(values) => {
                controller.parameters().longest_step()
            }
            _ => f64::INFINITY,
        }
    }

    /// Copies the outputs into `values`, and what is local.
    pub fn write_outputs(&self, values: &mut Values) {
        match self {
            Running::Controller(controller) => controller::write(controller.outputs(), values),
            Running::Plant(plant) => plant::write(plant.outputs(), values),
            Running::PlantExchange(plant) => exchange::write(plant, values),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::variables::{Causality, Kind, Row};
    use cable_robot::robot::RigFile;

    /// Of the paper's rig and of one with eight cables.
    fn interfaces() -> Vec<Interface> {
        let eight = RigFile::parse(include_str!("../../../../rigs/eight.toml")).unwrap();
        let of_eight = MODELS.map(|model| Interface::of_rig(model, &eight));
        MODELS.map(Model::interface).into_iter().chain(of_eight).collect()
    }

    #[test]
    fn no_value_reference_is_used_twice() {
        for interface in interfaces() {
            let mut seen = BTreeSet::new();
            for scalar in interface.scalars() {
                assert!(seen.insert(scalar.reference), "{}", scalar.name());
            }
        }
    }

    #[test]
    fn every_reference_finds_its_row_and_no_other_does() {
        for interface in interfaces() {
            let known: BTreeSet<u32> = interface.scalars().map(|scalar| scalar.reference).collect();
            for reference in (0..700).chain([u32::MAX]) {
                let found = interface.scalar(reference).map(|scalar| scalar.reference);
                assert_eq!(found, known.contains(&reference).then_some(reference), "{reference}");
            }
        }
    }

    #[test]
    fn start_values_exist_where_the_standard_wants_them() {
        for interface in interfaces() {
            for scalar in interface.scalars() {
                let causality = scalar.row.causality;
                let wanted = matches!(causality, Causality::Parameter | Causality::Input);
                assert_eq!(interface.start_of(&scalar).is_some(), wanted, "{}", scalar.name());
            }
        }
    }

    #[test]
    fn the_values_of_a_rig_are_the_rig() {
        let eight = RigFile::parse(include_str!("../../../../rigs/eight.toml")).unwrap();
        let interface = Interface::of_rig(Model::Controller, &eight);
        let parameters = controller::controller_parameters(&interface, interface.start());
        assert_eq!((parameters.rig, parameters.lambda), (eight.rig, eight.lambda));
    }

    /// What the domain refuses and what the table says are two statements of one fact.
    #[test]
    fn parameters_beyond_their_range_do_not_start() {
        for interface in MODELS.map(Model::interface) {
            for row in interface.rows_with(Causality::Parameter) {
                for bad in row.min.map(|min| min - 1.0).into_iter().chain(row.max.map(|max| max + 1.0)) {
                    let mut values = interface.start().clone();
                    values.put(row.first, bad);
                    let message = interface.begin(&mut values, 0.0).unwrap_err().to_string();
                    assert!(message.contains(&format!("{} = {bad}", row.name)), "{message}");
                }
            }
        }
    }

    /// Start values from which every dependency shows: the ordinary start, the other settings, bad measurements.
    fn points(interface: &Interface) -> Vec<Values> {
        let start = interface.start();
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
        let settings: &[&[(&str, f64)]] = match interface.model() {
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
            Model::PlantExchange => &[
                &[],
                &[("friction", 1.0), ("motorTension[1]", -1.0), ("motorTension[2]", -1.0)],
                &[("motorTension[1]", -1.0), ("motorTension[2]", -1.0)],
                &[("initialPose.x", 0.1), ("initialPose.roll", 0.1)],
            ],
            Model::Node(_) => &[],
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
            changes
                .iter()
                .for_each(|(name, value)| values.put(interface.named(name).unwrap().reference, *value));
            values
        };
        settings.iter().map(with).collect()
    }

    fn is_calculated(scalar: &Scalar) -> bool {
        matches!(scalar.row.causality, Causality::Output | Causality::Local)
    }

    /// (name of an output row, name of a row it was seen to depend on at the start), by changing one value at a time.
    fn observed(interface: &Interface) -> BTreeSet<(String, &'static str)> {
        let mut found = BTreeSet::new();
        for point in points(interface) {
            let mut before = point.clone();
            interface.begin(&mut before, 0.0).unwrap();
            for known in interface.scalars().filter(|scalar| !is_calculated(scalar)) {
                for value in others(known.row, point.at(known.reference)) {
                    let mut after = point.clone();
                    after.put(known.reference, value);
                    if interface.begin(&mut after, 0.0).is_ok() {
                        let outputs = interface.scalars().filter(is_calculated);
                        let changed = outputs.filter(|s| before.at(s.reference) != after.at(s.reference));
                        found.extend(changed.map(|scalar| (scalar.row.scalar_name(0), known.row.name)));
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
            Kind::Boolean | Kind::Clock => vec![1.0 - value],
            Kind::String => vec![],
            Kind::Enumeration(kind) => (1..=kind.items.len()).map(|item| item as f64).collect(),
        }
    }

    #[test]
    fn outputs_depend_at_the_start_on_exactly_what_the_table_says() {
        for interface in MODELS.map(Model::interface) {
            let outputs = [Causality::Output, Causality::Local].map(|of| interface.rows_with(of));
            let outputs = outputs.into_iter().flatten();
            let declared: BTreeSet<_> = outputs
                .flat_map(|row| interface.dependencies(row).map(|known| (row.scalar_name(0), known.name)))
                .collect();
            let observed = observed(&interface);
            let (missing, false_ones): (Vec<_>, Vec<_>) =
                (observed.difference(&declared).collect(), declared.difference(&observed).collect());
            assert_eq!(
                (missing, false_ones),
                (vec![], vec![]),
                "(missing, never seen) in {}",
                interface.model().identifier()
            );
        }
    }

    #[test]
    fn models_and_rigs_have_different_tokens() {
        let tokens: BTreeSet<String> = interfaces().iter().map(|i| i.token().to_owned()).collect();
        assert_eq!(tokens.len(), interfaces().len());
    }
}
