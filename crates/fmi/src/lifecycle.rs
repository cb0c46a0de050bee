//! Which call is allowed when: the tables of FMI 2.0.4, section 4.2.4, and of FMI 3.0.1, sections 2.3 and 4.2, as data.
//! It is also the list of all functions that the library exports.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::error::FmiError;
use super::models::Use;

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Parameters and start values may be set.
    Instantiated,
    /// Outputs follow parameters and inputs; both may be set.
    Initialization,
    /// FMI 2 calls it *stepComplete*: time goes on with every doStep.
    StepMode,
    /// Model Exchange: inputs may jump, and cables go slack or taut.
    EventMode,
    /// Model Exchange: the importer integrates.
    ContinuousTimeMode,
    /// The run is over, its last values can be read.
    Terminated,
    /// A call has failed. FMI 3 has no name of its own for it (it is in *Terminated*).
    Error,
    /// Structural parameters may be set.
    Configuration,
}

impl State {
    /// Whether Initialization Mode is over.
    pub fn is_initialised(self) -> bool {
        !matches!(self, State::Instantiated | State::Configuration | State::Initialization)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            State::Instantiated => "Instantiated",
            State::Initialization => "Initialization Mode",
            State::StepMode => "Step Mode",
            State::EventMode => "Event Mode",
            State::ContinuousTimeMode => "Continuous-Time Mode",
            State::Terminated => "Terminated",
            State::Error => "Error",
            State::Configuration => "Configuration Mode",
        })
    }
}

/// One function of the standard.
#[derive(Debug)]
pub struct Function {
    /// Name in C.
    pub name: &'static str,
    /// When it may be called.
    pub allowed: Allowed,
}

/// When a function may be called.
#[derive(Debug)]
pub enum Allowed {
    /// Needs no instance.
    Always,
    /// In these states.
    In(&'static [State]),
    /// The same, if the instance is for one of these uses.
    For(&'static [Use], &'static [State]),
    /// The same, if the instance is a node on buses; others have no use for it for this reason.
    OfNodes(&'static [State], &'static str),
    /// Never, for this reason.
    Never(&'static str),
}

use Allowed::{Always, For, In, Never, OfNodes};
use State::{
    Configuration, ContinuousTimeMode, Error, EventMode, Initialization, Instantiated, StepMode, Terminated,
};
use Use::{CoSimulation, CoSimulationWithEvents, ModelExchange, OnBuses};

const ALL: &[State] =
    &[Instantiated, Initialization, StepMode, EventMode, ContinuousTimeMode, Terminated, Error];
const ANY: Allowed = In(ALL);
const ANY_3: Allowed = In(&[
    Instantiated,
    Initialization,
    StepMode,
    EventMode,
    ContinuousTimeMode,
    Terminated,
    Error,
    Configuration,
]);
const SET: Allowed = In(&[Instantiated, Initialization, StepMode, EventMode]);
const SET_BOOLEAN: Allowed = In(&[Instantiated, Initialization, StepMode, EventMode, Configuration]);
/// Saved states: a node's is spread over the buses.
const SAVE: Allowed = For(&[CoSimulation, CoSimulationWithEvents, ModelExchange], ALL);
const SET_REAL: Allowed = In(&[Instantiated, Initialization, StepMode, EventMode, ContinuousTimeMode]);
const GET_2: Allowed = In(&[Initialization, StepMode, EventMode, ContinuousTimeMode, Terminated, Error]);
const GET_3: Allowed = ANY_3;
const RUNNING: Allowed = In(&[StepMode, EventMode, ContinuousTimeMode]);
const STEPS: &[Use] = &[CoSimulation, CoSimulationWithEvents, OnBuses];
const EVENTS: &[Use] = &[ModelExchange, CoSimulationWithEvents, OnBuses];
const STEPPING: Allowed = For(STEPS, &[StepMode]);
const STATUS_2: Allowed = For(STEPS, &[StepMode, Terminated]);
const IN_EVENT_MODE: Allowed = For(EVENTS, &[EventMode]);
const TO_EVENTS: Allowed = For(EVENTS, &[ContinuousTimeMode, StepMode]);
const TO_STEPS: Allowed = For(&[CoSimulationWithEvents, OnBuses], &[EventMode]);
const CLOCK: Allowed = For(&[CoSimulationWithEvents, OnBuses], &[Initialization, EventMode]);
const SET_CLOCK: Allowed = OfNodes(&[EventMode], NO_CLOCK_TO_SET);
const TO_CONTINUOUS_TIME: Allowed = For(&[ModelExchange], &[EventMode]);
const IN_CONTINUOUS_TIME: Allowed = For(&[ModelExchange], &[ContinuousTimeMode]);
const IN_EITHER: Allowed = For(&[ModelExchange], &[EventMode, ContinuousTimeMode]);
const OF_AN_INTEGRATOR: Allowed =
    For(&[ModelExchange], &[Initialization, EventMode, ContinuousTimeMode, Terminated, Error]);
const NUMBERS: Allowed =
    For(&[ModelExchange], &[Instantiated, Initialization, EventMode, ContinuousTimeMode, Terminated, Error]);

const NOT_SCHEDULED: Allowed = Never("this FMU is not for Scheduled Execution");
const NO_DERIVATIVES: Allowed =
    Never("this FMU provides no such derivatives, as its modelDescription.xml says");
const NO_DEPENDENCIES: Allowed = Never("the dependencies are in modelDescription.xml and never change");
const NO_EVENTS: &str =
    "it is instantiated without events, or the FMU has none, as its modelDescription.xml says";
const NO_CLOCK_TO_SET: &str = "this FMU has no clock that can be set, nor one of intervals";
const NO_CLOCKS: Allowed = Never(NO_CLOCK_TO_SET);
const NO_STRUCTURE: &str = "this FMU has no structural parameters";
const NEVER_PENDING: Allowed = Never("a step is never pending: doStep returns when it is done");

const fn row(name: &'static str, allowed: Allowed) -> Function {
    Function { name, allowed }
}

/// Every function of both standards.
pub const FUNCTIONS: &[Function] = &[
    row("fmi2GetTypesPlatform", Always),
    row("fmi2GetVersion", Always),
    row("fmi2Instantiate", Always),
    row("fmi2FreeInstance", ANY),
    row("fmi2SetDebugLogging", ANY),
    row("fmi2SetupExperiment", In(&[Instantiated])),
    row("fmi2EnterInitializationMode", In(&[Instantiated])),
    row("fmi2ExitInitializationMode", In(&[Initialization])),
    row("fmi2Terminate", RUNNING),
    row("fmi2Reset", ANY),
    row("fmi2GetReal", GET_2),
    row("fmi2GetInteger", GET_2),
    row("fmi2GetBoolean", GET_2),
    row("fmi2GetString", GET_2),
    row("fmi2SetReal", SET_REAL),
    row("fmi2SetInteger", SET),
    row("fmi2SetBoolean", SET),
    row("fmi2SetString", SET),
    row("fmi2GetFMUstate", ANY),
    row("fmi2SetFMUstate", ANY),
    row("fmi2FreeFMUstate", ANY),
    row("fmi2SerializedFMUstateSize", ANY),
    row("fmi2SerializeFMUstate", ANY),
    row("fmi2DeSerializeFMUstate", ANY),
    row("fmi2DoStep", STEPPING),
    row("fmi2GetStatus", STATUS_2),
    row("fmi2GetRealStatus", STATUS_2),
    row("fmi2GetIntegerStatus", STATUS_2),
    row("fmi2GetBooleanStatus", STATUS_2),
    row("fmi2GetStringStatus", STATUS_2),
    row("fmi2CancelStep", NEVER_PENDING),
    row("fmi2GetDirectionalDerivative", OF_AN_INTEGRATOR),
    row("fmi2SetRealInputDerivatives", NO_DERIVATIVES),
    row("fmi2GetRealOutputDerivatives", NO_DERIVATIVES),
    row("fmi2EnterEventMode", IN_CONTINUOUS_TIME),
    row("fmi2NewDiscreteStates", IN_EVENT_MODE),
    row("fmi2EnterContinuousTimeMode", TO_CONTINUOUS_TIME),
    row("fmi2CompletedIntegratorStep", IN_CONTINUOUS_TIME),
    row("fmi2SetTime", IN_EITHER),
    row("fmi2SetContinuousStates", IN_CONTINUOUS_TIME),
    row("fmi2GetDerivatives", OF_AN_INTEGRATOR),
    row("fmi2GetEventIndicators", OF_AN_INTEGRATOR),
    row("fmi2GetContinuousStates", OF_AN_INTEGRATOR),
    row("fmi2GetNominalsOfContinuousStates", NUMBERS),
    //
    row("fmi3GetVersion", Always),
    row("fmi3InstantiateCoSimulation", Always),
    row("fmi3InstantiateModelExchange", Always),
    row("fmi3InstantiateScheduledExecution", Always),
    row("fmi3FreeInstance", ANY_3),
    row("fmi3SetDebugLogging", ANY_3),
    row("fmi3EnterInitializationMode", In(&[Instantiated])),
    row("fmi3ExitInitializationMode", In(&[Initialization])),
    row("fmi3Terminate", RUNNING),
    row("fmi3Reset", ANY_3),
    row("fmi3GetFloat32", GET_3),
    row("fmi3GetFloat64", GET_3),
    row("fmi3GetInt8", GET_3),
    row("fmi3GetUInt8", GET_3),
    row("fmi3GetInt16", GET_3),
    row("fmi3GetUInt16", GET_3),
    row("fmi3GetInt32", GET_3),
    row("fmi3GetUInt32", GET_3),
    row("fmi3GetInt64", GET_3),
    row("fmi3GetUInt64", GET_3),
    row("fmi3GetBoolean", GET_3),
    row("fmi3GetString", GET_3),
    row("fmi3GetBinary", GET_3),
    row("fmi3SetFloat32", SET),
    row("fmi3SetFloat64", SET_REAL),
    row("fmi3SetInt8", SET),
    row("fmi3SetUInt8", SET),
    row("fmi3SetInt16", SET),
    row("fmi3SetUInt16", SET),
    row("fmi3SetInt32", SET),
    row("fmi3SetUInt32", SET),
    row("fmi3SetInt64", SET),
    row("fmi3SetUInt64", SET),
    row("fmi3SetBoolean", SET_BOOLEAN),
    row("fmi3SetString", SET),
    row("fmi3SetBinary", SET),
    row("fmi3GetFMUState", SAVE),
    row("fmi3SetFMUState", SAVE),
    row("fmi3FreeFMUState", SAVE),
    row("fmi3SerializedFMUStateSize", SAVE),
    row("fmi3SerializeFMUState", SAVE),
    row("fmi3DeserializeFMUState", SAVE),
    row("fmi3DoStep", STEPPING),
    row("fmi3EnterStepMode", TO_STEPS),
    row("fmi3EnterEventMode", TO_EVENTS),
    row("fmi3EvaluateDiscreteStates", IN_EVENT_MODE),
    row("fmi3UpdateDiscreteStates", IN_EVENT_MODE),
    row("fmi3EnterConfigurationMode", OfNodes(&[Instantiated], NO_STRUCTURE)),
    row("fmi3ExitConfigurationMode", OfNodes(&[Configuration], NO_STRUCTURE)),
    row("fmi3GetNumberOfVariableDependencies", NO_DEPENDENCIES),
    row("fmi3GetVariableDependencies", NO_DEPENDENCIES),
    row("fmi3GetDirectionalDerivative", OF_AN_INTEGRATOR),
    row("fmi3GetAdjointDerivative", NO_DERIVATIVES),
    row("fmi3GetOutputDerivatives", NO_DERIVATIVES),
    row("fmi3GetClock", CLOCK),
    row("fmi3SetClock", SET_CLOCK),
    row("fmi3GetIntervalDecimal", NO_CLOCKS),
    row("fmi3GetIntervalFraction", NO_CLOCKS),
    row("fmi3GetShiftDecimal", NO_CLOCKS),
    row("fmi3GetShiftFraction", NO_CLOCKS),
    row("fmi3SetIntervalDecimal", NO_CLOCKS),
    row("fmi3SetIntervalFraction", NO_CLOCKS),
    row("fmi3SetShiftDecimal", NO_CLOCKS),
    row("fmi3SetShiftFraction", NO_CLOCKS),
    row("fmi3EnterContinuousTimeMode", TO_CONTINUOUS_TIME),
    row("fmi3CompletedIntegratorStep", IN_CONTINUOUS_TIME),
    row("fmi3SetTime", IN_EITHER),
    row("fmi3SetContinuousStates", IN_CONTINUOUS_TIME),
    row("fmi3GetContinuousStateDerivatives", OF_AN_INTEGRATOR),
    row("fmi3GetEventIndicators", OF_AN_INTEGRATOR),
    row("fmi3GetContinuousStates", OF_AN_INTEGRATOR),
    row("fmi3GetNominalsOfContinuousStates", NUMBERS),
    row("fmi3GetNumberOfEventIndicators", NUMBERS),
    row("fmi3GetNumberOfContinuousStates", NUMBERS),
    row("fmi3ActivateModelPartition", NOT_SCHEDULED),
];

/// The row of a function. Used in `const` blocks, so that a name missing from the table does not compile.
pub const fn function(name: &str) -> &'static Function {
    let mut i = 0;
    while i < FUNCTIONS.len() {
        if same(FUNCTIONS[i].name.as_bytes(), name.as_bytes()) {
            return &FUNCTIONS[i];
        }
        i += 1;
    }
    panic!("no such function in the table")
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

impl Function {
    /// Whether the call is allowed in `state` of an FMU for this use.
    ///
    /// # Errors
    /// [`FmiError::OutOfOrder`] or [`FmiError::Unsupported`].
    pub fn check(&self, state: State, usage: Use) -> Result<(), FmiError> {
        match &self.allowed {
            Always => Ok(()),
            In(states) if states.contains(&state) => Ok(()),
            For(wanted, _) if !wanted.contains(&usage) => {
                let without_events = usage == CoSimulation && wanted.contains(&CoSimulationWithEvents);
                let why = if without_events { NO_EVENTS } else { usage.refusal() };
                Err(FmiError::Unsupported { function: self.name, why })
            }
            OfNodes(_, why) if usage != OnBuses => Err(FmiError::Unsupported { function: self.name, why }),
            For(_, states) | OfNodes(states, _) if states.contains(&state) => Ok(()),
            In(states) | For(_, states) | OfNodes(states, _) => {
                let allowed = states.iter().map(State::to_string).collect::<Vec<_>>().join(", ");
                Err(FmiError::OutOfOrder { function: self.name, state, allowed })
            }
            Never(why) => Err(FmiError::Unsupported { function: self.name, why }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The declarations `FMI2_Export fmi2GetRealTYPE fmi2GetReal;` of a header.
    fn declared(header: &str, mark: &str) -> Vec<String> {
        let lines =
            header.lines().map(str::trim).filter(|line| line.starts_with(mark) && line.ends_with(';'));
        lines.map(|line| line.trim_end_matches(';').split_whitespace().last().unwrap().to_owned()).collect()
    }

    #[test]
    fn the_table_has_exactly_the_functions_of_the_headers() {
        let mut wanted = declared(include_str!("../../../fmi-headers/2.0/fmi2Functions.h"), "FMI2_Export");
        wanted.extend(declared(include_str!("../../../fmi-headers/3.0/fmi3Functions.h"), "FMI3_Export"));
        let mut listed: Vec<String> = FUNCTIONS.iter().map(|function| function.name.to_owned()).collect();
        wanted.sort();
        listed.sort();
        assert_eq!(listed, wanted);
        assert!(wanted.len() > 100);
    }

    #[test]
    fn a_refusal_names_function_state_and_what_is_allowed() {
        let message =
            function("fmi2DoStep").check(State::Instantiated, CoSimulation).unwrap_err().to_string();
        assert_eq!(
            message,
            "fmi2DoStep is not allowed in the state Instantiated; it is allowed in Step Mode"
        );
    }
}
