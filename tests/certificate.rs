//! The certificate against dense sampling, closed forms and the plant.

use std::time::Instant;

use cable_robot::control::{Gains, Response};
use cable_robot::reach::certificate::{Cause, Step, Verdict, certify};
use cable_robot::reach::in_static_workspace;
use cable_robot::robot::geometry::FACET_NORMALS;
use cable_robot::robot::{
    Coordinates, Geometry, Pose, Rig, RobotParameters, TensionLimits, dynamics, tensions,
};
use nalgebra::{Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const TAUT: TensionLimits = TensionLimits { min: 0.0, max: 100.0 };

fn paper() -> Rig {
    Rig::triangular(&RobotParameters::default(), TAUT)
}

/// The tensions along the closed form, by plain floating point arithmetic.
fn sampled(rig: &Rig, step: &Step, time: f64) -> Option<[f64; 6]> {
    let geometry = Geometry {
        anchor: std::array::from_fn(|i| rig.anchors[i]),
        attachment: std::array::from_fn(|i| rig.attachments[i]),
    };
    let [i1, i2, i3] = rig.inertia.into();
    let robot = RobotParameters { m: rig.mass, i1, i2, i3, g: rig.g, ..Default::default() };
    let response = Response::at(&step.gains, time);
    let error = step.start.minus(&step.set_point);
    let moved = |k: usize| response.motion(step.set_point.0[k] + error[k], step.rates[k], step.set_point.0[k]);
    let of = |derivative: usize| Coordinates::from_fn(|k, _| moved(k)[derivative]);
    tensions(&robot, &geometry, &Pose(of(0)), &of(1), &of(2))
}

#[test]
fn the_move_of_section_vi_takes_one_step() {
    let step = Step {
        start: Pose::default(),
        rates: Coordinates::zeros(),
        set_point: Pose::at(0.15, 0.15, 1.0),
        gains: Gains { lambda: 3.0, eta: 3.0 },
    };
    let verdict = certify(&paper(), &step).unwrap();
    let Verdict::Admissible { least, greatest } = verdict else { panic!("{verdict:?}") };
    println!("{verdict:?}");
    assert!(least > 1.0 && least < 1.0501 && greatest < 25.0, "{verdict:?}");
}
