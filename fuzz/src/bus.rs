//! A bridge that works with a simulated rig, while somebody else speaks on the bus.

use std::cell::OnceCell;

use cable_robot::plan::ControllerParameters;
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::bridge::TransportError;
use cable_robot_fieldbus::frame::FrameKind;
use cable_robot_fieldbus::simulated::{Bench, SimulatedRig};
use cable_robot_fieldbus::{
    Bridge, Config, Frame, FrameQueue, LibraryController, Nanoseconds, OperatorCommand, State,
};

/// The fieldbus files of the examples, and the rig files that they name.
const EXAMPLES: [[&str; 2]; 2] = [
    [include_str!("../../rigs/can/akd.toml"), include_str!("../../rigs/can/lab.toml")],
    [include_str!("../../rigs/can/eight.toml"), include_str!("../../rigs/eight.toml")],
];

/// The bytes are what happens, in its order: the first says where it begins.
///
/// # Panics
/// If the bridge does, pulls what is not allowed, or pulls when it must not.
pub fn bridge(data: &[u8]) {
    thread_local!(static BEGINNINGS: OnceCell<Vec<World>> = const { OnceCell::new() });
    let mut bytes = data.iter().copied();
    let first = usize::from(bytes.next().unwrap_or(0));
    let mut world = BEGINNINGS.with(|beginnings| {
        let beginnings = beginnings.get_or_init(World::beginnings);
        beginnings[first % beginnings.len()].clone()
    });
    while world.happen(&mut bytes).is_some() {}
}

#[derive(Clone)]
struct World {
    bridge: Bridge,
    rig: SimulatedRig,
    controller: LibraryController,
    now: Nanoseconds,
    /// On the way to the bridge.
    coming: Vec<(usize, Frame)>,
    is_pressed: bool,
}

/// The rig of the first example.
pub fn lab() -> RigFile {
    RigFile::parse(EXAMPLES[0][1]).expect("the example is right")
}

impl World {
    /// Of each example: just started; set up; taut; under the controller; one that only listens.
    fn beginnings() -> Vec<Self> {
        EXAMPLES.into_iter().flat_map(Self::beginnings_of).collect()
    }

    fn beginnings_of([fieldbus, rig]: [&str; 2]) -> Vec<Self> {
        let rig = RigFile::parse(rig).expect("the example is right");
        let config = Config::parse(fieldbus, &rig).expect("the example is right");
        // One after the other: a bridge with all that belongs to it is large for a stack.
        let mut worlds = Vec::new();
        for lead in [|_: &mut Bench| (), to_homing, to_ready, to_enabled] {
            let bench = Bench::new(config.clone(), PlantParameters::default());
            let mut bench = Box::new(bench.expect("an ideal plant is allowed"));
            lead(&mut bench);
            worlds.push(Self::of(*bench));
        }
        worlds.push(Self { bridge: Bridge::shadow(config), ..worlds[0].clone() });
        worlds
    }

    fn of(bench: Bench) -> Self {
        let parameters: ControllerParameters = bench.parameters();
        let controller = LibraryController::new(parameters);
        let (now, is_pressed) = (bench.now, bench.is_pressed);
        Self { bridge: bench.bridge, rig: bench.rig, controller, now, coming: vec![], is_pressed }
    }

    /// The next thing; `None` at the end of the bytes.
    fn happen(&mut self, bytes: &mut impl Iterator<Item = u8>) -> Option<()> {
        let what = bytes.next()?;
        match what % 8 {
            0..3 => {
                let frame = frame(bytes)?;
                self.coming.push((usize::from(what >= 0xF0), frame));
            }
            3 => self.command(bytes.next()?),
            4 => self.bridge.on_transport_error(
                0,
                [TransportError::NoRoom, TransportError::Down, TransportError::Gone]
                    [usize::from(what >> 3) % 3],
            ),
            // The clock, now and then by much, or backwards.
            5 => self.cycle(self.now.saturating_add_signed((i64::from(bytes.next()?) - 40) * 250_000)),
            _ => (0..=what >> 5).for_each(|_| self.cycle(self.now + 4_000_000)),
        }
        Some(())
    }

    fn command(&mut self, byte: u8) {
        let goal = [0.3, -0.2, f64::NAN, 5.0][usize::from(byte >> 3) % 4];
        let command = match byte % 8 {
            0 => OperatorCommand::Home,
            1 | 2 => OperatorCommand::Enable,
            3 => OperatorCommand::Release,
            4 => OperatorCommand::Goal(Pose::at(goal, 0.1, 1.0)),
            5 => OperatorCommand::Reset,
            6 => OperatorCommand::Lower,
            _ => OperatorCommand::Shutdown,
        };
        self.is_pressed = command == OperatorCommand::Enable || (self.is_pressed && byte % 8 == 4);
        // What it refuses is its own affair.
        let _ = self.bridge.operator(command, self.now);
    }

    fn cycle(&mut self, now: Nanoseconds) {
        self.now = now;
        self.rig.tick(now, &mut self.coming);
        for (bus, frame) in self.coming.drain(..) {
            self.bridge.on_frame(bus, &frame, now);
        }
        if self.is_pressed {
            let _ = self.bridge.operator(OperatorCommand::Enable, now);
        }
        let mut out = FrameQueue::new();
        let report = self.bridge.cycle(now, &mut self.controller, &mut out);
        for (bus, frame) in out.frames() {
            self.rig.on_frame(*bus, frame, now, &mut self.coming);
        }
        while self.bridge.take_event().is_some() {}
        let config = self.bridge.config();
        for (i, tension) in report.tension.iter().enumerate() {
            // A torque is rounded.
            let (winch, limits) = (&config.drives[i].winch, &config.rig.cables[i].limits);
            let most = 1000.0 * winch.torque_limit / winch.rated_torque;
            let torque = f64::from(report.target_torque[i]);
            assert!((0.0..=limits.max + 0.1).contains(tension) && torque.abs() <= most, "{report:?}");
        }
        let is_off = matches!(report.state, State::Configuring | State::Homing | State::Off | State::Shadow);
        assert!(
            !is_off
                || report.target_torque.iter().all(|torque| *torque == 0)
                || report.state == State::Shadow,
            "{report:?}"
        );
        assert!(report.state != State::Shadow || out.frames().is_empty(), "a shadow sent {:?}", out.frames());
    }
}

fn to_homing(bench: &mut Bench) {
    assert!(bench.run_until(State::Homing, 20.0));
    bench.run(0.1);
}

fn to_ready(bench: &mut Bench) {
    assert!(bench.start());
    bench.is_pressed = false;
    bench.bridge.operator(OperatorCommand::Release, bench.now).expect("it can always be released");
}

fn to_enabled(bench: &mut Bench) {
    assert!(bench.start());
    bench.run(0.5);
}

/// Function code, node, length and kind, data.
fn frame(bytes: &mut impl Iterator<Item = u8>) -> Option<Frame> {
    let [function, node, shape] = [bytes.next()?, bytes.next()?, bytes.next()?];
    let id = u16::from(function & 0xF) << 7 | u16::from(node & 0x7F);
    let kind = match shape >> 4 {
        14 => FrameKind::Remote,
        15 => FrameKind::Error,
        _ => FrameKind::Data,
    };
    let mut data = [0; 8];
    let length = usize::from(shape & 0xF).min(8);
    for byte in data.iter_mut().take(length) {
        *byte = bytes.next()?;
    }
    Frame::new(kind, id, &data[..length])
}
