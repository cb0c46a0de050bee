//! One instance of a model: its life, its values, its time. Knows nothing of C.

mod buses;
mod events;
mod exchange;

pub use exchange::Give;

use super::error::{FmiError, Status};
use super::lifecycle::{Function, State};
use super::log::{Category, Log};
use super::models::{Interface, Model, Running, Scalar, Use};
use super::node::OnBuses;
use super::state::Snapshot;
use super::values::Values;
use super::variables::{Causality, Kind, Variability};

/// An instance as `fmi2Instantiate` or `fmi3InstantiateCoSimulation` makes it.
pub struct Instance {
    interface: Interface,
    /// Where messages go.
    pub log: Log,
    /// All that get/setFMUState saves.
    now: Snapshot,
    usage: Use,
    /// Whether a step may end where the planner decides.
    returns_early: bool,
    /// Whether it was said that a fixed parameter is written again and again.
    has_warned_of_repetition: bool,
    /// When the experiment starts, s.
    start: f64,
    /// Of an instance on buses.
    node: Option<OnBuses>,
}

impl Instance {
    /// An instance with all variables at their start values.
    pub fn new(interface: Interface, usage: Use, may_return_early: bool, log: Log) -> Self {
        let now = Snapshot::new(&interface);
        let returns_early = may_return_early && usage == Use::CoSimulationWithEvents;
        let (has_warned_of_repetition, start, node) = (false, 0.0, None);
        Self { interface, log, now, usage, returns_early, has_warned_of_repetition, start, node }
    }

    /// What it is used for.
    pub fn usage(&self) -> Use {
        self.usage
    }

    /// Which model it is.
    pub fn model(&self) -> Model {
        self.interface.model()
    }

    /// Its variables.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Where it is in its life.
    pub fn state(&self) -> State {
        self.now.state
    }

    /// The communication point it has reached, s.
    pub fn time(&self) -> f64 {
        self.now.time()
    }

    /// A call has failed: only reset, saved states and reading remain.
    pub fn fail(&mut self) {
        self.now.state = State::Error;
    }

    /// Takes note of the experiment.
    ///
    /// # Errors
    /// [`FmiError::Argument`] for times that are not finite or in the wrong order.
    pub fn set_up_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), FmiError> {
        if !start.is_finite() {
            return Err(argument("startTime", start, "a finite number"));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return Err(argument(
                "stopTime",
                stop,
                &format!("a finite number not below startTime = {start}"),
            ));
        }
        self.now.set_time(start);
        self.start = start;
        self.now.stop = stop;
        Ok(())
    }

    /// Instantiated -> Initialization Mode.
    pub fn enter_initialization(&mut self) {
        self.now.state = State::Initialization;
    }

    /// Initialization Mode -> Step Mode, or Event Mode for Model Exchange: checks the parameters and starts the model.
    ///
    /// # Errors
    /// [`FmiError::Parameter`] naming the parameter that makes no sense.
    pub fn exit_initialization(&mut self) -> Result<(), FmiError> {
        if self.node.is_some() {
            self.start_node();
            return Ok(());
        }
        self.now.start(&self.interface)?;
        self.now.state = match self.usage {
            Use::CoSimulation => State::StepMode,
            Use::CoSimulationWithEvents | Use::OnBuses | Use::ModelExchange => State::EventMode,
        };
        self.set_clock();
        if let Some(warning) = self.interface.warning(&self.now.values) {
            self.log.send(Status::Ok, Category::Warning, &warning);
        }
        if let Some(fault) = self.now.running.as_ref().and_then(Running::fault) {
            self.warn(Status::Ok, || format!("SensorFault at t = {} s: {fault}", self.time()));
        }
        self.event(|now| format!("initialised at t = {} s", now.time()));
        Ok(())
    }

    /// Advances from `point` to `point + h`. Inputs are held; outputs and time change together, or nothing does.
    ///
    /// # Errors
    /// [`FmiError::Argument`] for a step that makes no sense, [`FmiError::TooLong`] for one that may be made in parts, [`FmiError::Plant`] for one that cannot be computed.
    pub fn step(&mut self, point: f64, h: f64) -> Result<(), FmiError> {
        self.check_step(point, h)?;
        if self.node.is_some() {
            return self.step_node(point, h);
        }
        let Some(mut running) = self.now.running.clone() else {
            return Err(FmiError::State("it is in Step Mode but was never initialised".to_owned()));
        };
        let h = self.shortened(point, h);
        running.step(&self.interface, &self.now.values, point, h)?;
        let before = self.log.is_enabled(Category::Events).then(|| self.now.values.clone());
        running.write_outputs(&mut self.now.values);
        let fault = self.now.running.as_ref().and_then(Running::fault).map(|fault| fault.check);
        if let Some(new) = running.fault().filter(|new| Some(new.check) != fault) {
            self.warn(Status::Ok, || format!("SensorFault at t = {point} s: {new}"));
        }
        let was_known = self.now.running.as_ref().is_some_and(|before| before.late().is_some());
        if let Some(late) = running.late().filter(|_| !was_known) {
            self.warn(Status::Warning, || wrong_delay(late, point));
        }
        self.now.running = Some(running);
        self.now.set_time(point + h);
        self.set_clock();
        if let Some(before) = before {
            self.report_changes(&before);
        }
        Ok(())
    }

    /// Importers add up step sizes in their own way (0.1 + 0.2 is not 0.3), so points are compared with a tolerance.
    fn check_step(&self, point: f64, h: f64) -> Result<(), FmiError> {
        let time = self.time();
        if !(h.is_finite() && h > 0.0) {
            return Err(argument("communicationStepSize", h, "a finite number greater than 0"));
        }
        let tolerance = 1e-9_f64.max(1e-6 * h).max(4.0 * f64::EPSILON * time.abs());
        if !point.is_finite() || (point - time).abs() > tolerance {
            return Err(argument(
                "currentCommunicationPoint",
                point,
                &format!("{time}, where the last step ended"),
            ));
        }
        let longest =
            self.now.running.as_ref().map_or(f64::INFINITY, |running| running.longest_step(&self.now.values));
        if h > longest + tolerance {
            return Err(FmiError::TooLong { h, longest });
        }
        match self.now.stop {
            Some(stop) if point + h > stop + tolerance => {
                let allowed = format!("from {point} to stopTime = {stop} there are {} s", stop - point);
                Err(argument("communicationStepSize", h, &allowed))
            }
            _ => Ok(()),
        }
    }

    /// The run is over.
    pub fn terminate(&mut self) {
        self.now.state = State::Terminated;
        self.event(|now| format!("terminated at t = {} s", now.time()));
    }

    /// Back to how it was when instantiated; the logging stays as it is set.
    pub fn reset(&mut self) {
        self.now = Snapshot::new(&self.interface);
        if let Some(buses) = &mut self.node {
            buses.reset();
        }
        self.write_node();
    }

    /// All that a later [`Instance::restore`] needs.
    pub fn snapshot(&self) -> &Snapshot {
        &self.now
    }

    /// Goes on from a saved state, whatever has happened since.
    ///
    /// # Errors
    /// [`FmiError::State`] for a state of the other model or of another rig.
    pub fn restore(&mut self, saved: &Snapshot) -> Result<(), FmiError> {
        if saved.model() != self.model() {
            let (theirs, ours) = (saved.model().identifier(), self.model().identifier());
            return Err(FmiError::State(format!("it was saved by {theirs}, this is {ours}")));
        }
        saved.check(&self.interface)?;
        if saved.state == State::EventMode && self.usage == Use::CoSimulation {
            return Err(FmiError::State(
                "it was saved in Event Mode, which this instance does not use".to_owned(),
            ));
        }
        self.now.clone_from(saved);
        Ok(())
    }

    /// Hands the values behind `references` to `give`, with their positions.
    ///
    /// # Errors
    /// Names the first reference that cannot be read with `function`; then `give` was not called at all.
    pub fn get(
        &mut self,
        function: &'static Function,
        handles: fn(Kind) -> bool,
        references: &[u32],
        mut give: impl FnMut(usize, f64),
    ) -> Result<(), FmiError> {
        let mut calculated = None;
        for &reference in references {
            let scalar = self.scalar(function, handles, reference)?;
            if matches!(scalar.row.causality, Causality::Output | Causality::Local) {
                calculated.get_or_insert(scalar);
            }
        }
        self.ready(calculated.as_slice())?;
        if self.usage == Use::ModelExchange {
            // An integrator may try states at which there is nothing to tell.
            exchange::check_finite(references, &self.interface, &self.now.values)?;
        }
        for (i, &reference) in references.iter().enumerate() {
            give(i, self.now.values.at(reference));
        }
        Ok(())
    }

    /// Sets the values behind `references` to what `take` has at their positions.
    ///
    /// # Errors
    /// Names the first value that cannot be set; then none was.
    pub fn set(
        &mut self,
        function: &'static Function,
        handles: fn(Kind) -> bool,
        references: &[u32],
        take: impl Fn(usize) -> f64,
    ) -> Result<(), FmiError> {
        let mut repeated = None;
        for (i, &reference) in references.iter().enumerate() {
            let scalar = self.scalar(function, handles, reference)?;
            scalar.check(take(i))?;
            if let Err(error) = self.check_settable(&scalar) {
                // Some importers write all parameters again before each step; what does not change is let pass.
                let is_same =
                    scalar.row.causality == Causality::Parameter && take(i) == self.now.values.at(reference);
                if !is_same {
                    return Err(error);
                }
                repeated.get_or_insert(scalar);
            }
        }
        if let Some(scalar) = repeated.filter(|_| !self.has_warned_of_repetition) {
            self.has_warned_of_repetition = true;
            self.warn(Status::Ok, || {
                let name = scalar.name();
                format!("{name} was written again after initialisation, with the value that it has: let pass, though it is a fixed parameter")
            });
        }
        for (i, &reference) in references.iter().enumerate() {
            self.now.values.put(reference, take(i));
        }
        if !self.now.state.is_initialised() && !references.is_empty() {
            // Outputs follow in Initialization Mode, but only when somebody reads them.
            self.now.running = None;
        }
        Ok(())
    }

    fn scalar(
        &self,
        function: &'static Function,
        handles: fn(Kind) -> bool,
        reference: u32,
    ) -> Result<Scalar, FmiError> {
        let scalar = self.any_scalar(function, reference)?;
        let kind = self.interface.kind(scalar.row);
        if handles(kind) {
            return Ok(scalar);
        }
        Err(FmiError::WrongType {
            function: function.name,
            name: scalar.name(),
            reference,
            kind: kind.name(),
        })
    }

    fn any_scalar(&self, function: &'static Function, reference: u32) -> Result<Scalar, FmiError> {
        let (function, model) = (function.name, self.model().identifier());
        self.interface.scalar(reference).ok_or(FmiError::UnknownReference { function, model, reference })
    }

    /// Has the values of calculated scalars, if there are any, ready.
    fn ready(&mut self, scalars: &[Scalar]) -> Result<(), FmiError> {
        let Some(scalar) = scalars.first() else { return Ok(()) };
        let why = match (&self.now.running, self.now.state) {
            (Some(Running::PlantExchange(_)), _) => {
                self.refresh();
                return Ok(());
            }
            (Some(_), _) => return Ok(()),
            (None, _) if self.node.is_some() => return Ok(()),
            (None, State::Initialization) => match self.now.start(&self.interface) {
                Ok(()) => return Ok(()),
                Err(error) => error.to_string(),
            },
            (None, _) => "outputs exist from Initialization Mode on".to_owned(),
        };
        Err(FmiError::NotReady { name: scalar.name(), why })
    }

    fn check_settable(&self, scalar: &Scalar) -> Result<(), FmiError> {
        let state = self.now.state;
        let allowed = match scalar.row.causality {
            Causality::Structural if state == State::Configuration => return Ok(()),
            Causality::Structural => "it is a structural parameter, to be set in Configuration Mode",
            _ if state == State::Configuration => "only structural parameters can be",
            Causality::Input => return Ok(()),
            Causality::Parameter if !state.is_initialised() => return Ok(()),
            Causality::Parameter if scalar.row.variability == Variability::Tunable => return Ok(()),
            Causality::Parameter => "it is a fixed parameter, to be set before initialisation ends",
            Causality::Output => "it is an output",
            Causality::Local => "it is calculated; an integrator sets states all together",
            Causality::Independent => "time advances with doStep, or is set by an integrator",
        };
        Err(FmiError::NotSettable { name: scalar.name(), state, allowed })
    }

    fn warn(&self, status: Status, text: impl FnOnce() -> String) {
        if self.log.is_enabled(Category::Warning) {
            self.log.send(status, Category::Warning, &text());
        }
    }

    fn event(&self, text: impl FnOnce(&Snapshot) -> String) {
        if self.log.is_enabled(Category::Events) {
            self.log.send(Status::Ok, Category::Events, &text(&self.now));
        }
    }

    /// One line for each discrete output that a step has changed.
    fn report_changes(&self, before: &Values) {
        let after = &self.now.values;
        let discrete = |scalar: &Scalar| {
            scalar.row.causality == Causality::Output && scalar.row.variability == Variability::Discrete
        };
        for scalar in self.interface.scalars().filter(discrete) {
            let reference = scalar.reference;
            if before.at(reference) != after.at(reference) {
                let (name, time) = (scalar.name(), self.time());
                let (old, new) = (before.text(scalar.row, reference), after.text(scalar.row, reference));
                self.event(|_| format!("{name} changed from {old} to {new} in the step to t = {time} s"));
            }
        }
    }
}

fn wrong_delay([late, said]: [f64; 2], time: f64) -> String {
    let (size, when) = (late.abs(), if late > 0.0 { "later" } else { "earlier" });
    let right = (said + late).max(0.0);
    format!(
        "at t = {time} s: commands act about {size:.4} s {when} than commandDelay = {said} s says; with {right:.4} s holdCompensation would make up for it"
    )
}

fn argument(argument: &'static str, value: f64, allowed: &str) -> FmiError {
    FmiError::Argument { argument, value, allowed: allowed.to_owned() }
}
