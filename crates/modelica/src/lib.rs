//! Controller and planner behind a small C interface, `modelica/CableRobot/Resources/Include/CableRobot.h`: for Modelica's external objects.
//!
//! Every function answers 0, or another number and a message; no panic crosses the boundary.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod boundary;
mod controller;
mod planner;
