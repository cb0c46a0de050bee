//! Inside the virtual machine: bridge and simulated rig with a real bus between them. Time is counted in cycles, so that
//! a slow machine makes no difference.

use cable_robot::plan::{ControllerParameters, PoseSource};
use cable_robot::robot::{Pose, RigFile};
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::bridge::{CycleReport, Fault, TransportError};
use cable_robot_fieldbus::frame::Frame;
use cable_robot_fieldbus::simulated::SimulatedRig;
use cable_robot_fieldbus::transport::Transport;
use cable_robot_fieldbus::{
    Bridge, Config, FrameQueue, LibraryController, Nanoseconds, OperatorCommand, State,
};

use crate::guest::{bus, link, shell};

struct Joined {
    bridge: Bridge,
    controller: LibraryController,
    rig: SimulatedRig,
    /// The bridge's end of the bus and the rig's.
    ends: [Box<dyn Transport>; 2],
    enable: bool,
    now: Nanoseconds,
    out: FrameQueue,
    answers: Vec<(usize, Frame)>,
}

impl Joined {
    fn new(name: &str) -> Self {
        let lab = RigFile::parse(include_str!("../../../rigs/can/lab.toml")).unwrap();
        let config = Config::parse(include_str!("../../../rigs/can/akd.toml"), &lab).unwrap();
        let parameters = ControllerParameters {
            rig: config.rig,
            pose_source: PoseSource::CableLengths,
            force_loop: true,
            ..ControllerParameters::default()
        };
        Self {
            rig: SimulatedRig::new(config.clone(), PlantParameters::default()).unwrap(),
            bridge: Bridge::new(config),
            controller: LibraryController::new(parameters),
            ends: [bus(name), link(name)],
            enable: false,
            now: 0,
            out: FrameQueue::new(),
            answers: vec![],
        }
    }

    fn cycle(&mut self) -> CycleReport {
        let Self { bridge, rig, answers, now, .. } = self;
        let [near, far] = &mut self.ends;
        *now += bridge.config().period;
        rig.tick(*now, answers);
        for (_, frame) in answers.drain(..) {
            // What the rig cannot send is lost.
            let _ = far.send(&frame);
        }
        loop {
            match near.receive(0) {
                Ok(Some(received)) => bridge.on_frame(0, &received.frame, *now),
                Ok(None) => break,
                Err(error) => break bridge.on_transport_error(0, error.into()),
            }
        }
        if self.enable {
            // Refused until the bridge is ready.
            let _ = bridge.operator(OperatorCommand::Enable, *now);
        }
        let report = bridge.cycle(*now, &mut self.controller, &mut self.out);
        for (_, frame) in self.out.frames() {
            if let Err(error) = near.send(frame) {
                bridge.on_transport_error(0, error.into());
            }
        }
        while let Ok(Some(received)) = far.receive(0) {
            rig.on_frame(0, &received.frame, *now, answers);
        }
        report
    }

    fn run(&mut self, seconds: f64) -> Vec<CycleReport> {
        let cycles = seconds / (self.bridge.config().period as f64 * 1e-9);
        (0..cycles as usize).map(|_| self.cycle()).collect()
    }

    fn run_until(&mut self, state: State) {
        let reached = (0..20_000).any(|_| self.cycle().state == state);
        assert!(
            reached,
            "{state} was not reached from {}: {:?}",
            self.bridge.state(),
            self.bridge.take_event()
        );
    }

    /// From power-on to the controller's tensions.
    fn start(&mut self) {
        self.run_until(State::Homing);
        self.run(0.1);
        while self.bridge.state() != State::Ready {
            self.bridge.operator(OperatorCommand::Home, self.now).unwrap();
            self.cycle();
        }
        self.enable = true;
        self.run_until(State::Enabled);
    }
}

#[test]
#[ignore = "runs in the virtual machine"]
fn the_papers_move_is_made_over_a_real_bus_until_the_link_goes_down() {
    let mut joined = Joined::new("rig0");
    joined.start();
    joined.run(1.0);
    let _ = joined.bridge.operator(OperatorCommand::Goal(Pose::at(0.15, 0.15, 1.0)), joined.now);
    let reports = joined.run(12.0);
    let last = reports.last().unwrap();
    assert_eq!((last.state, last.fault), (State::Enabled, None));
    let there = joined.rig.plant().encoder_pose.position();
    assert!((there - nalgebra::Vector3::new(0.15, 0.15, 1.0)).norm() < 5e-3, "{there}");
    let least = reports.iter().flat_map(|report| report.measured).fold(f64::INFINITY, f64::min);
    println!("{} cycles, smallest tension {least:.3} N", reports.len());
    assert!(least > 0.3, "{least}");

    shell("ip link set down rig0");
    let fault = Some(Fault::Transport { bus: 0, error: TransportError::Down });
    assert_eq!(joined.cycle().fault, fault);
    shell("ip link set up rig0");
    // The link is back, the controller is not, whatever the operator presses.
    assert!(joined.run(1.0).iter().all(|report| report.state != State::Enabled));
}
