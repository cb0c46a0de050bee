//! Cable-suspended robots, of six and more cables, with every cable taut, within what docs/limits.md says: controller, planner and plant, as a library and as FMUs.
//!
//! After Oh and Agrawal, *Guaranteed Reachable Domain and Control Design for a Cable Robot Subject to Input Constraints*.
//! Where the program differs from the paper, `docs/paper.md` says so, with the figure.
//!
//! A move is planned for a [`Rig`](robot::Rig), by a [`Planner`](plan::Planner) that proves that every tension stays within its limits, and followed by a
//! [`Controller`](plan::Controller), one bounded step at a time. Tried on a simulated [`Plant`](sim::Plant):
//!
//! ```
//! use cable_robot::plan::{ControllerParameters, Planner, PlannerKind};
//! use cable_robot::robot::{Pose, Rig, RobotParameters, TensionLimits};
//! use cable_robot::sim::{ClosedLoop, PlantParameters};
//!
//! // The paper's rig; `RigFile::parse` reads any other, of six to sixteen cables.
//! let limits = TensionLimits { min: 0.0, max: 100.0 }; // N
//! let rig = Rig::paper(&RobotParameters::default(), limits);
//! let (start, goal) = (Pose::at(0.0, 0.0, 1.0), Pose::at(0.15, 0.15, 1.0)); // m
//!
//! let parameters =
//!     ControllerParameters { planner: PlannerKind::MinimumTime, ..ControllerParameters::of(&rig) };
//! let motion = Planner::from(parameters).course_from_rest(&start, &goal).expect("the goal can be reached");
//! assert!(motion.end() < 1.0); // s; the paper's planner takes 7.5 s
//!
//! let plant = PlantParameters { rig, initial_pose: start, ..PlantParameters::default() };
//! let mut closed_loop = ClosedLoop::new(parameters, plant, goal)?;
//! let mut least = f64::INFINITY;
//! for _ in 0..1500 {
//!     let now = closed_loop.step(1e-3)?; // s
//!     least = now.plant.measured_tension.iter().copied().fold(least, f64::min);
//! }
//! assert!(closed_loop.moment().controller.at_goal);
//! assert!(least > limits.min, "{least} N");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Where to begin: [`robot::RigFile`] for a rig of one's own, [`control::static_margin`] for what is left at rest at a pose, [`reach::static_workspace`] and
//! [`reach::certify`] for where it may go, [`plan::Planner`] for plans alone, [`plan::Controller`] for a control loop of one's own, [`sim::Scenario`] for whole
//! runs. Poses are six coordinates in m and rad, tensions N, one a cable. An outcome such as "not reachable" is a value; an error is input that makes no
//! sense, and names the field, the value and what would be right. A control step allocates nothing and gives the same bits on every platform.
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
