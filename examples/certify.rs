//! Asks for a proof that a step keeps every cable taut, from rest and from a state in motion: `cargo run --example certify`.

use std::error::Error;

use cable_robot::control::Gains;
use cable_robot::reach::certificate::{Margins, Step, Verdict, certify, certify_with_margins};
use cable_robot::robot::{Coordinates, Pose, RigFile};

fn main() -> Result<(), Box<dyn Error>> {
    let RigFile { rig, home, lambda, eta, .. } = RigFile::default();
    let gains = Gains { lambda, eta };
    let moving = Coordinates::new(0.1, -0.05, 0.0, 0.0, 0.0, 0.2);
    for (name, rates) in [("from rest", Coordinates::zeros()), ("in motion", moving)] {
        for set_point in [Pose::at(0.06, 0.03, 1.0), Pose::at(0.3, 0.3, 1.0)] {
            let step = Step { start: home, rates, set_point, gains };
            let said = match certify(&rig, &step)? {
                Verdict::Admissible { least, greatest, .. } => {
                    format!("proved: tensions from {least:.2} to {greatest:.2} N")
                }
                other => format!("{other:?}"),
            };
            println!("{name} to {:?}: {said}", set_point.position().as_slice());
        }
    }
    let step = Step { start: home, rates: Coordinates::zeros(), set_point: Pose::at(0.06, 0.03, 1.0), gains };
    let margins = Margins { mass: 0.01, sample_period: 1e-3, ..Margins::default() };
    println!(
        "with 1 % of the mass unknown and commands held for 1 ms: {:?}",
        certify_with_margins(&rig, &step, &margins)?
    );
    Ok(())
}
