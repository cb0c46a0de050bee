//! What the integrator of an importer asks of an instance for Model Exchange.

use super::Instance;
use crate::error::FmiError;
use crate::lifecycle::{Function, State};
use crate::models::{Interface, Running, Scalar, exchange};
use crate::values::Values;
use crate::variables::{Causality, Row};
use cable_robot::sim::ContinuousPlant;

/// Where numbers go, with their positions.
pub type Give<'a> = &'a mut dyn FnMut(usize, f64);

impl Instance {
    /// Event Mode -> Continuous-Time Mode.
    pub fn enter_continuous_time(&mut self) {
        self.now.state = State::ContinuousTimeMode;
    }

    /// Continuous-Time Mode or Step Mode -> Event Mode.
    pub fn enter_events(&mut self) {
        self.now.state = State::EventMode;
    }

    /// What an event changes at once. On buses nothing: what is received is taken in when the event is over, and what is sent stays until then.
    pub fn evaluate_discrete_states(&mut self) {
        if self.node.is_none() {
            self.update_discrete_states();
        }
    }

    /// Events are done: decides which cables are slack from now on. On buses: takes in what was received.
    pub fn update_discrete_states(&mut self) {
        if self.node.is_some() {
            return self.update_node();
        }
        self.stop_clock();
        self.refresh();
        let before = self.now.values.clone();
        let inputs = crate::models::plant::inputs(&before);
        if let Some(plant) = self.plant() {
            plant.settle(&inputs);
        }
        self.refresh();
        self.report_changes(&before);
    }

    /// The integrator has come to `time`, s.
    ///
    /// # Errors
    /// [`FmiError::Argument`] for a time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), FmiError> {
        if !time.is_finite() {
            return Err(super::argument("time", time, "a finite number"));
        }
        self.now.set_time(time);
        Ok(())
    }

    /// How many states there are.
    pub fn number_of_states(&self) -> usize {
        self.states().count()
    }

    /// How many event indicators there are.
    pub fn number_of_indicators(&self) -> usize {
        self.interface.scalars_of(exchange::INDICATORS).count()
    }

    /// The integrator has come to these states.
    ///
    /// # Errors
    /// Names the first that is not finite, or the right number of them; then they are as they were.
    pub fn set_states(&mut self, values: &[f64]) -> Result<(), FmiError> {
        self.check_length("the array of states", values.len(), self.number_of_states())?;
        if let Some((scalar, value)) = self.states().zip(values).find(|(_, value)| !value.is_finite()) {
            return Err(FmiError::bad_value(&scalar, *value));
        }
        if let Some(plant) = self.plant() {
            plant.state.copy_from_slice(values);
        }
        Ok(())
    }

    /// Hands the magnitudes of the states to `give`: one each, in SI units.
    ///
    /// # Errors
    /// The right number of them, for another.
    pub fn give_nominals(&mut self, length: usize, give: Give) -> Result<(), FmiError> {
        self.check_length("the array of nominals", length, self.number_of_states())?;
        (0..length).for_each(|i| give(i, 1.0));
        Ok(())
    }

    /// Hands the states to `give`, with their positions.
    ///
    /// # Errors
    /// The right number of them, for another.
    pub fn give_states(&mut self, length: usize, give: Give) -> Result<(), FmiError> {
        self.give_rows("the array of states", exchange::STATES.map(|(state, _)| state), length, give)
    }

    /// Hands their derivatives to `give`.
    ///
    /// # Errors
    /// The right number of them, and names the first that is not finite.
    pub fn give_derivatives(&mut self, length: usize, give: Give) -> Result<(), FmiError> {
        self.give_rows("the array of derivatives", exchange::STATES.map(|(_, rate)| rate), length, give)
    }

    /// Hands the event indicators to `give`.
    ///
    /// # Errors
    /// The right number of them, for another.
    pub fn give_indicators(&mut self, length: usize, give: Give) -> Result<(), FmiError> {
        self.give_rows("the array of event indicators", [exchange::INDICATORS], length, give)
    }

    /// Hands to `give` by how much the `unknown` variables change when the `known` ones do by the `seed`.
    ///
    /// # Errors
    /// Names the first variable that is none of those that may be asked for, the first seed or the first result that is not finite.
    pub fn give_directional_derivative(
        &mut self,
        function: &'static Function,
        unknown: &[u32],
        known: &[u32],
        seed: &[f64],
        mut give: impl FnMut(usize, f64),
    ) -> Result<(), FmiError> {
        let all = |references: &[u32]| -> Result<Vec<Scalar>, FmiError> {
            references.iter().map(|&reference| self.any_scalar(function, reference)).collect()
        };
        let (unknown, known) = (all(unknown)?, all(known)?);
        let refused = |scalar: &Scalar, role| FmiError::NotDifferentiable {
            function: function.name,
            name: scalar.name(),
            role,
        };
        // What depends on the start is asked for where the start may still change.
        let initial = self.now.state == State::Initialization;
        let is_state =
            |scalar: &Scalar| exchange::STATES.iter().any(|(row, _)| row.first == scalar.row.first);
        let is_unknown = |scalar: &Scalar| {
            let calculated = matches!(scalar.row.causality, Causality::Output | Causality::Local);
            let real = matches!(scalar.row.kind, crate::variables::Kind::Float64);
            real && calculated && (initial || !is_state(scalar))
        };
        if let Some(scalar) = unknown.iter().find(|scalar| !is_unknown(scalar)) {
            let role = "unknown: those are real outputs, derivatives and event indicators, and states in Initialization Mode";
            return Err(refused(scalar, role));
        }
        if let Some((scalar, seed)) = known.iter().zip(seed).find(|(_, seed)| !seed.is_finite()) {
            return Err(FmiError::bad_value(scalar, *seed));
        }
        self.ready(&unknown)?;
        let mut changes = self.now.values.clone();
        if let Some(Running::PlantExchange(plant)) = &self.now.running {
            exchange::vary(&self.interface, plant, &mut changes, &known, seed, initial).map_err(|scalar| {
                let role = "known variable: those are states and real inputs, and real parameters in Initialization Mode";
                refused(&scalar, role)
            })?;
        }
        let references: Vec<u32> = unknown.iter().map(|scalar| scalar.reference).collect();
        check_finite(&references, &self.interface, &changes)?;
        unknown.iter().enumerate().for_each(|(i, scalar)| give(i, changes.at(scalar.reference)));
        Ok(())
    }

    /// Outputs and what is local, for the state and the inputs as they are.
    pub(super) fn refresh(&mut self) {
        let now = &mut self.now;
        if let Some(running) = &now.running {
            running.write_outputs(&mut now.values);
        }
    }

    fn plant(&mut self) -> Option<&mut ContinuousPlant> {
        match &mut self.now.running {
            Some(Running::PlantExchange(plant)) => Some(plant),
            _ => None,
        }
    }

    fn states(&self) -> impl Iterator<Item = Scalar> + use<> {
        self.interface.scalars_of_all(exchange::STATES.map(|(state, _)| state))
    }

    fn give_rows<const N: usize>(
        &mut self,
        argument: &'static str,
        rows: [&'static Row; N],
        length: usize,
        give: Give,
    ) -> Result<(), FmiError> {
        let scalars: Vec<Scalar> = self.interface.scalars_of_all(rows).collect();
        self.check_length(argument, length, scalars.len())?;
        self.ready(&scalars)?;
        let references: Vec<u32> = scalars.iter().map(|scalar| scalar.reference).collect();
        check_finite(&references, &self.interface, &self.now.values)?;
        scalars.iter().enumerate().for_each(|(i, scalar)| give(i, self.now.values.at(scalar.reference)));
        Ok(())
    }

    fn check_length(&self, argument: &'static str, given: usize, wanted: usize) -> Result<(), FmiError> {
        if given == wanted {
            return Ok(());
        }
        Err(FmiError::Length { argument, given, wanted: wanted.to_string() })
    }
}

/// Names the first of these variables that is no number.
pub(super) fn check_finite(
    references: &[u32],
    interface: &Interface,
    values: &Values,
) -> Result<(), FmiError> {
    let value_of = |reference: u32| values.at(reference);
    match references.iter().find(|reference| !value_of(**reference).is_finite()) {
        Some(reference) => {
            let name = interface.scalar(*reference).map_or_else(String::new, |scalar| scalar.name());
            Err(FmiError::NotFinite { name, value: value_of(*reference) })
        }
        None => Ok(()),
    }
}
