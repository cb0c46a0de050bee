//! A six-cable suspended robot that never lets a cable go slack.

pub mod control;
pub mod cosim;
pub mod fmi;
pub mod plan;
pub mod reach;
pub mod report;
pub mod robot;
pub mod sim;
