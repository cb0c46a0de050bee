//! Cable-suspended robots, of six and more cables, with every cable taut, within what docs/limits.md says: controller, planner and plant, as a library and as FMUs.
//!
//! After Oh and Agrawal, *Guaranteed Reachable Domain and Control Design for a Cable Robot Subject to Input Constraints*.
//! Where the program differs from the paper, `docs/paper.md` says so, with the figure.
//!
//! ```
//! use cable_robot::control::static_margin;
//! use cable_robot::plan::{ControllerParameters, Planner};
//! use cable_robot::robot::{Pose, Rig, RobotParameters, TensionLimits};
//!
//! let rig = Rig::paper(&RobotParameters::default(), TensionLimits { min: 0.0, max: 100.0 });
//! let (start, goal) = (Pose::at(0.0, 0.0, 1.0), Pose::at(0.15, 0.15, 1.0));
//! assert!(static_margin(&rig, &goal) > 1.0); // N: how far from its limits every tension is at rest there
//!
//! let planner = Planner::from(ControllerParameters::of(&rig));
//! let mut way = vec![start];
//! while let Some(next) = planner.next_from_rest(way.last().unwrap(), &goal) {
//!     way.push(next);
//! }
//! assert_eq!((way.len(), *way.last().unwrap()), (5, goal)); // the paper's four set points
//! ```
//!
//! # Modules and crates
//!
//! This crate is the domain: no input or output, no clock, no FMI. Arrows point down only: `robot <- control <- reach <- plan <- sim`.
//!
//! | paper | module | |
//! |---|---|---|
//! | II | [`robot`] | rigs with any cables, from files; inverse and forward kinematics, dynamics (1) |
//! | III | [`control`] | the law (2)-(6), gains (7)-(11), responses (12)-(14), tension distribution, velocity estimate, force loop |
//! | IV | [`reach`] | static workspace (16), bounded reachable domain (15), exact domain, certificate |
//! | V | [`plan`] | set points (17), the flow of Fig. 4, the controller as one struct |
//! | VI | [`sim`] | the plant and its integrator; scenarios and the closed loop that runs them |
//!
//! | crate | |
//! |---|---|
//! | `cable_robot_fmi` | the C boundary: one library, two models, FMI 2.0 and 3.0 (`cable_robot_bindings`: the standard's headers) |
//! | `cable_robot_import` | an importer of FMUs; it knows of no cables |
//! | `cable_robot_cosim` | FMUs in the place of the library's controller and plant |
//! | `cable_robot_fieldbus` | VII: drives and load cells on a CAN bus, the bridge, SocketCAN and serial adapters |
//! | `cable_robot_modelica` | controller and planner as a small C library, for Modelica's external objects |
//! | `cable_robot_report` | what a person looks at |
//! | `programs` | `cable-robot`, `can-bridge`, `rig-sim` |
//!
//! # Notation
//!
//! Base frame with its origin at the centre of the base plane, x and y in it, **z down**; SI units, radians.
//!
//! | paper | here | unit | |
//! |---|---|---|---|
//! | a, b | `a`, `b` | m | half the sides of the base and platform triangles |
//! | m, I₁, I₂, I₃ | `m`, `i1`, `i2`, `i3` | kg, kg m² | mass, principal moments of inertia |
//! | x = (x, y, z, roll, pitch, yaw) | [`robot::Pose`] | m, rad | coordinates, R = Rz Ry Rx |
//! | x' | `rates` | m/s, rad/s | their rates |
//! | u | `tension` | N | tensions of cables 1 to n |
//! | -Jᵀ | [`robot::Cables::wrench_matrix`] | | tensions to force and torque on the platform |
//! | λ, η | `lambda`, `eta` | 1/s | gains of (2) and (4) |
//! | ω_n, ξ, Z_M | `omega_n`, `xi`, `z_m` | 1/s, -, - | (8), (9), (14) |
//! | r, r', r'' | [`control::Reference`] | | what the law follows |
//! | s, V | `sliding_variable`, `lyapunov_function` | | (2), (3) |
//! | x_d^i, x_f | `set_point`, `goal` | | active set point, goal |
//! | β, N, T_s | `beta`, `bisection_steps`, `planner_period` | -, -, s | (17), Table II |
//! | z_c, c | `z_c`, `c` | m, - | height in (15), c = z_c ω_n²/g |

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod checked_toml;
pub mod control;
pub mod plan;
pub mod reach;
pub mod robot;
pub mod sim;
