//! Controller and planner behind a small C interface, `modelica/CableRobot/Resources/Include/CableRobot.h`: for Modelica's external objects.
//!
//! Every function answers 0, or another number and a message; no panic crosses the boundary.

mod boundary;
mod controller;
mod planner;
