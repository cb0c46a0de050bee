//! Orbits outside the static workspace: proofs against dense samples, and the closed form against proofs.

use cable_robot::control::{static_margin, tensions};
use cable_robot::plan::ControllerParameters;
use cable_robot::plan::orbit::{Figure, Orbit, OrbitError, Part, Refusal, Trajectory, reach_of_p};
use cable_robot::reach::Verdict;
use cable_robot::robot::{Coordinates, Pose, Rig};

/// The circle: 0.4 m about the middle, of a hexagon of apothem 0.225 m.
fn circle() -> Orbit {
    let figure = Figure::Circle { radius: 0.4 };
    Orbit { centre: Pose::at(0.0, 0.0, 1.0), figure, rate: 2.75, turns: 3.0, start: 2.5 }
}

/// Least tension of a motion in dense samples of the full inverse dynamics, N.
fn sampled(rig: &Rig, trajectory: &Trajectory, [from, to]: [f64; 2]) -> f64 {
    let at = |k: u32| {
        let led = trajectory.at(from + (to - from) * f64::from(k) / 3000.0);
        let tension = tensions(rig, &led.pose, &led.rates, &led.accelerations, 0.0).unwrap();
        tension.into_iter().fold(f64::INFINITY, f64::min)
    };
    (0..=3000).map(at).fold(f64::INFINITY, f64::min)
}

#[test]
fn try_it() {
    let parameters = ControllerParameters::default();
    for rate in [2.5, 2.75, 3.0, Orbit::natural_rate(&parameters.rig, &Pose::at(0.0, 0.0, 1.0))] {
        let orbit = Orbit { rate, ..circle() };
        let begin = std::time::Instant::now();
        let proof = orbit.prove(&parameters, &Coordinates::zeros(), 1e-3);
        println!("{:?}", begin.elapsed());
        match proof {
            Ok(proof) => println!(
                "{rate} kept {} least {} greatest {} rest {} sampled {}",
                proof.kept,
                proof.least,
                proof.greatest,
                proof.longest_to_rest,
                sampled(&parameters.rig, &proof.trajectory, [0.0, proof.trajectory.end()])
            ),
            Err(error) => println!("{rate} {error}"),
        }
    }
}
