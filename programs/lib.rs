//! What the programs have in common, and `cable-robot`, which is a module of the Python package, too.

#[path = "cable-robot/mod.rs"]
pub mod command;
pub mod errors;
pub mod plain;
pub mod shell;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;

/// JSON Schema of what a program only writes: every field is there.
pub fn output_schema<T: JsonSchema>() -> serde_json::Value {
    SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>().to_value()
}
