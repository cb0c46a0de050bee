//! The frames of a start, from power-on to a goal, of bridge and simulated rig themselves: what the FMUs on a bus (docs/ls-bus.md) exchange as
//! well, at the same times and to the last bit.
//!
//!     cargo run --release -p cable-robot-fieldbus --example start_on_a_bus
//!
//! A line a frame: the step of a quarter of a period that it was sent in, who sent it, the frame.

use std::io::{BufWriter, Write};
use std::path::Path;

use cable_robot::plan::{ControllerParameters, PoseSource};
use cable_robot::robot::Pose;
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::simulated::SimulatedRig;
use cable_robot_fieldbus::{Bridge, Files, FrameQueue, LibraryController, OperatorCommand, State};

/// So many steps make a period.
const STEPS: u64 = 4;
/// What the script does, in steps.
const LENGTH: u64 = 24_000;
const GOAL_AT: u64 = 20_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../rigs/can/akd.toml"));
    let config = Files::read(path)?.config;
    let parameters = config.of_drives(ControllerParameters {
        lambda: config.controller.lambda,
        eta: config.controller.eta,
        pose_source: PoseSource::CableLengths,
        force_loop: true,
        ..ControllerParameters::of(&config.rig)
    });
    let period = config.period;
    let mut rig = SimulatedRig::new(config.clone(), PlantParameters::default())?;
    let mut bridge = Bridge::new(config);
    let mut controller = LibraryController::new(parameters);
    let (mut out, mut coming) = (FrameQueue::new(), vec![]);
    let mut text = BufWriter::new(std::io::stdout().lock());
    for k in 1..=LENGTH {
        let now = k * period / STEPS;
        let is_cycle = k % STEPS == 0;
        if is_cycle {
            let pressed = matches!(bridge.state(), State::Ready | State::Enabled);
            // What the bridge refuses now it takes later.
            let _ = bridge.operator(OperatorCommand::Home, now);
            let _ = pressed.then(|| bridge.operator(OperatorCommand::Enable, now));
            if k == GOAL_AT {
                bridge.operator(OperatorCommand::Goal(Pose::at(0.1, 0.1, 1.0)), now)?;
            }
            bridge.cycle(now, &mut controller, &mut out);
        } else {
            out.clear();
        }
        rig.tick(now, &mut coming);
        for (bus, frame) in std::mem::take(&mut coming) {
            writeln!(text, "{k} rig {frame}")?;
            bridge.on_frame(bus, &frame, now);
        }
        for (bus, frame) in out.frames() {
            writeln!(text, "{k} controller {frame}")?;
            rig.on_frame(*bus, frame, now, &mut coming);
        }
    }
    Ok(text.flush()?)
}
