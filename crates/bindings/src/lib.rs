//! What the official FMI headers declare, generated with `cargo bindings`; nothing here is written by hand.

#[allow(missing_docs, unsafe_code, non_camel_case_types, non_snake_case, non_upper_case_globals, clippy::all)]
#[rustfmt::skip]
pub mod fmi2;
#[allow(missing_docs, unsafe_code, non_camel_case_types, non_snake_case, non_upper_case_globals, clippy::all)]
#[rustfmt::skip]
pub mod fmi3;
