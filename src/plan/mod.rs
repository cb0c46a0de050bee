//! Section V: the planner, and the controller that executes what it plans.

pub mod controller;
