//! The C functions, called as an importer calls them: in order, out of order, and with everything wrong.
#![allow(unsafe_code, non_snake_case, reason = "this is the importer's side of a C interface")]

#[cfg(target_arch = "x86_64")]
mod environment;
mod exchange;
mod lifecycle;
mod messages;
mod slave;
mod states;
mod values;

use cable_robot_fmi::models::Scalar;
use cable_robot_fmi::variables::{Causality, Kind};
use cable_robot_fmi::{CO_SIMULATION, Model};
use slave::{BOTH, ERROR, Fmi, OK, Slave};

/// The scalars of type real with this causality: names and references.
fn reals(model: Model, causality: Causality) -> Vec<(String, u32)> {
    let interface = model.interface();
    let of = |scalar: &Scalar| scalar.row.causality == causality && matches!(scalar.row.kind, Kind::Float64);
    interface.scalars().filter(of).map(|scalar| (scalar.name(), scalar.reference)).collect()
}

fn all_pairs() -> impl Iterator<Item = (Fmi, Model)> {
    BOTH.into_iter().flat_map(|fmi| CO_SIMULATION.map(|model| (fmi, model)))
}

/// All reals that can be read, to see whether anything has changed.
fn picture(slave: &Slave) -> Vec<f64> {
    let all = [Causality::Parameter, Causality::Input, Causality::Output, Causality::Independent];
    let references: Vec<u32> = all
        .into_iter()
        .flat_map(|causality| reals(slave.model, causality))
        .map(|(_, reference)| reference)
        .collect();
    let (status, values) = slave.get_reals(&references);
    assert_eq!(status, OK, "{}", slave.last_message());
    values
}

/// A slave in the state with this letter: Instantiated, iNitialization, Step Mode, Terminated, Error.
fn in_state(letter: char, fmi: Fmi, model: Model) -> Slave {
    let slave = Slave::new(fmi, model);
    let ok = match letter {
        'I' => OK,
        'N' => slave.enter(0.0, None),
        'S' => slave.enter(0.0, None) + slave.exit(),
        'T' => slave.enter(0.0, None) + slave.exit() + slave.terminate(),
        _ => (slave.enter(0.0, None) + slave.exit() + slave.step(0.0, -1.0)).wrapping_sub(ERROR),
    };
    assert_eq!(ok, OK);
    slave
}
