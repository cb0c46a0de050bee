//! What a fieldbus file says of its controller.

use thiserror::Error;

use super::rig_file;
use crate::models::{Interface, Model, controller};
use crate::values::Values;
use crate::variables::{Causality, Kind};
use cable_robot::plan::ControllerParameters;
use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::config::Parameter;

/// A parameter of the fieldbus file that the controller does not have.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GivenError {
    /// No such name.
    #[error("controller.parameters.{name}: the controller has {}", .known.join(", "))]
    Name {
        /// What the file says.
        name: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// No such item of an enumeration.
    #[error("controller.parameters.{name} = {item}: it is one of {}", .known.join(", "))]
    Item {
        /// Of the parameter.
        name: String,
        /// What the file says.
        item: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// Another type.
    #[error("controller.parameters.{name} = {value}: it is a {kind}")]
    Type {
        /// Of the parameter.
        name: String,
        /// What the file says.
        value: String,
        /// What it is.
        kind: &'static str,
    },
}

/// The parameters of the controller that a fieldbus file describes.
///
/// # Errors
/// [`GivenError`].
pub fn controller_parameters(config: &Config) -> Result<ControllerParameters, GivenError> {
    let file = rig_file(config);
    let interface = Interface::of_rig(Model::Controller, &file);
    let mut values = interface.start().clone();
    let own =
        ControllerParameters { lambda: file.lambda, eta: file.eta, ..ControllerParameters::of(&file.rig) };
    write_parameters(config, &interface, &own, &mut values)?;
    Ok(controller::controller_parameters(&interface, &values))
}

/// Writes `own` parameters of a controller, with what the fieldbus file says of it and of its drives.
///
/// # Errors
/// [`GivenError`].
pub fn write_parameters(
    config: &Config,
    interface: &Interface,
    own: &ControllerParameters,
    values: &mut Values,
) -> Result<(), GivenError> {
    controller::write_parameters(interface, own, values);
    write_given(config, interface, values)?;
    // The planner may be among what the file says.
    let planned = controller::controller_parameters(interface, values);
    controller::write_parameters(interface, &config.of_drives(planned), values);
    write_given(config, interface, values)
}

/// Writes what the fieldbus file says of the controller.
fn write_given(config: &Config, interface: &Interface, values: &mut Values) -> Result<(), GivenError> {
    for (name, parameter) in &config.controller.parameters {
        let (reference, number) = parameter_value(interface, name, parameter)?;
        values.put(reference, number);
    }
    Ok(())
}

/// Value reference and number of a parameter of the fieldbus file.
fn parameter_value(
    interface: &Interface,
    name: &str,
    parameter: &Parameter,
) -> Result<(u32, f64), GivenError> {
    let mut rows = interface.rows_with(Causality::Parameter);
    let found = rows.find(|row| row.name == name);
    let name = || name.to_owned();
    let Some(row) = found else {
        let known = interface.rows_with(Causality::Parameter).map(|row| row.name).collect();
        return Err(GivenError::Name { name: name(), known });
    };
    let number = match (row.kind, parameter) {
        (Kind::Boolean, Parameter::Boolean(flag)) => f64::from(u8::from(*flag)),
        (Kind::Float64 | Kind::Int32, Parameter::Number(number)) => *number,
        (Kind::Enumeration(kind), Parameter::Item(item)) => {
            let Some((number, ..)) = kind.numbered().find(|(_, known, _)| known == item) else {
                let known = kind.numbered().map(|(_, known, _)| known).collect();
                return Err(GivenError::Item { name: name(), item: item.clone(), known });
            };
            f64::from(number)
        }
        _ => {
            let (value, kind) = (parameter.to_string(), row.kind.name());
            return Err(GivenError::Type { name: name(), value, kind });
        }
    };
    Ok((row.first, number))
}
