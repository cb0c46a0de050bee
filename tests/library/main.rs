//! Tests of the library, through what it offers to others.

mod common;

mod any_rig;
mod certificate;
#[cfg(feature = "clarabel")]
mod certificate_of_many_cables;
mod controller_behaviour;
mod delays;
mod disturbances;
mod exact_planner;
mod exact_planner_held;
mod held_commands;
mod limits;
mod margins;
mod margins_of_any_rig;
mod mathematics;
mod minimum_time;
mod orbit;
mod paper_manoeuvre;
mod properties;
mod random_rigs;
mod recognised_rigs;
mod speeds;
mod stops;
mod tension_rate;
mod tuning;
mod way_points;
mod worst_case;
