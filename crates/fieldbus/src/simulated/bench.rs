//! Bridge and simulated rig joined without a bus, cycle by cycle: for tests of what the two do together.

use super::mishap::{Mishap, NotUnderstood};
use super::{Link, SimulatedRig};
use crate::bridge::{CycleReport, Event};
use crate::config::Config;
use crate::{Bridge, Frame, FrameQueue, LibraryController, Nanoseconds, OperatorCommand, State};
use cable_robot::plan::{ControllerParameters, PoseSource};
use cable_robot::robot::{ParameterError, Pose};
use cable_robot::sim::{ControllerModel, PlantParameters};

/// Bridge and rig, and an operator who keeps `enable` pressed or not.
pub struct Bench {
    /// The bridge.
    pub bridge: Bridge,
    /// The rig.
    pub rig: SimulatedRig,
    /// Who computes the tensions.
    pub controller: Box<dyn ControllerModel>,
    /// The wires between them.
    pub link: Link,
    /// Whether the operator keeps enable pressed.
    pub is_pressed: bool,
    /// Everything that the bridge wanted logged.
    pub events: Vec<(Nanoseconds, Event)>,
    /// Time of the last cycle.
    pub now: Nanoseconds,
    /// What the rig, or somebody else, said since the last cycle, and when.
    said: Vec<(Nanoseconds, usize, Frame)>,
    /// What reached it in the last cycle.
    heard: Vec<(usize, Frame)>,
    out: FrameQueue,
}

impl Bench {
    /// The library's controller with the rig file's gains, the load cells' force loop and lengths for poses; a plant with `imperfections`.
    ///
    /// # Errors
    /// [`ParameterError`] for an imperfection that makes no sense.
    pub fn new(config: Config, imperfections: PlantParameters) -> Result<Self, ParameterError> {
        Self::believing(config.clone(), config, imperfections)
    }

    /// The same with a rig that is as `truth` says and a bridge that goes by `belief`.
    ///
    /// # Errors
    /// As [`Bench::new`].
    pub fn believing(
        truth: Config,
        belief: Config,
        imperfections: PlantParameters,
    ) -> Result<Self, ParameterError> {
        let parameters = parameters(&belief);
        Ok(Self {
            rig: SimulatedRig::new(truth, imperfections)?,
            bridge: Bridge::new(belief),
            controller: Box::new(LibraryController::new(parameters)),
            link: Link::new(1),
            is_pressed: false,
            events: vec![],
            now: 0,
            said: vec![],
            heard: vec![],
            out: FrameQueue::new(),
        })
    }

    /// Measures poses instead of moving ([`Bridge::survey`]).
    #[must_use]
    pub fn surveying(mut self) -> Self {
        self.bridge = Bridge::survey(self.bridge.config().clone());
        self
    }

    /// Of the controller that it starts with.
    pub fn parameters(&self) -> ControllerParameters {
        parameters(self.bridge.config())
    }

    /// The next cycle, a period later.
    pub fn cycle(&mut self) -> CycleReport {
        self.cycle_at(self.now + self.bridge.config().period)
    }

    /// The next cycle at this time.
    pub fn cycle_at(&mut self, now: Nanoseconds) -> CycleReport {
        self.now = now;
        self.reach_rig();
        self.let_rig(now, |rig, out| rig.tick(now, out));
        self.heard.clear();
        for (at, bus, frame) in std::mem::take(&mut self.said) {
            self.link.send_to_bridge(bus, &frame, at);
        }
        while let Some((_, bus, frame)) = self.link.at_bridge(now) {
            self.bridge.on_frame(bus, &frame, now);
            self.heard.push((bus, frame));
        }
        if self.is_pressed {
            // Refused while the bridge is on its way to the safe output.
            let _ = self.bridge.operator(OperatorCommand::Enable, now);
        }
        let report = self.bridge.cycle(now, &mut *self.controller, &mut self.out);
        for k in 0..self.out.frames().len() {
            let (bus, frame) = self.out.frames()[k];
            self.link.send_to_rig(bus, &frame, now);
        }
        self.reach_rig();
        while let Some(event) = self.bridge.take_event() {
            self.events.push(event);
        }
        report
    }

    /// What the bridge sent, as far as it has arrived.
    fn reach_rig(&mut self) {
        let now = self.now;
        while let Some((at, bus, frame)) = self.link.at_rig(now) {
            self.let_rig(at, |rig, out| {
                if at < now {
                    rig.tick(at, out);
                }
                rig.on_frame(bus, &frame, at, out);
            });
        }
    }

    fn let_rig(&mut self, at: Nanoseconds, happen: impl FnOnce(&mut SimulatedRig, &mut Vec<(usize, Frame)>)) {
        let mut out = vec![];
        happen(&mut self.rig, &mut out);
        self.said.extend(out.into_iter().map(|(bus, frame)| (at, bus, frame)));
    }

    /// Something goes wrong, in the words of [`super::mishap::GRAMMAR`].
    ///
    /// # Errors
    /// [`NotUnderstood`].
    pub fn suffer(&mut self, text: &str) -> Result<(), NotUnderstood> {
        let mishap = Mishap::parse(text, self.rig.drives.len())?;
        let mut out = vec![];
        self.rig.suffer(mishap, &mut self.link, self.now, &mut out);
        out.into_iter().for_each(|(bus, frame)| self.inject(bus, frame));
        Ok(())
    }

    /// What reached the bridge in the last cycle.
    pub fn heard(&self) -> &[(usize, Frame)] {
        &self.heard
    }

    /// What the bridge sent in the last cycle.
    pub fn sent(&self) -> &[(usize, Frame)] {
        self.out.frames()
    }

    /// A frame from somebody else, with the next cycle.
    pub fn inject(&mut self, bus: usize, frame: Frame) {
        self.said.push((self.now, bus, frame));
    }

    /// Cycles until the bridge is in this state, or for `seconds`. Whether it is.
    pub fn run_until(&mut self, state: State, seconds: f64) -> bool {
        let end = self.now + (seconds * 1e9) as Nanoseconds;
        while self.now < end && self.bridge.state() != state {
            self.cycle();
        }
        self.bridge.state() == state
    }

    /// Cycles for `seconds`, and what each reported.
    pub fn run(&mut self, seconds: f64) -> Vec<CycleReport> {
        let end = self.now + (seconds * 1e9) as Nanoseconds;
        let mut reports = vec![];
        while self.now < end {
            reports.push(self.cycle());
        }
        reports
    }

    /// From power-on to the controller's tensions, at the home pose. Whether it got there.
    pub fn start(&mut self) -> bool {
        let is_set_up = self.run_until(State::Homing, 20.0);
        // Homing needs a reading of everything.
        self.run(0.1);
        let is_ready = is_set_up && self.take_up_slack();
        self.is_pressed = true;
        is_ready && self.run_until(State::Enabled, 1.0)
    }

    /// The operator holds home until the cables are taut. Whether they are.
    pub fn take_up_slack(&mut self) -> bool {
        while self.bridge.operator(OperatorCommand::Home, self.now).is_ok()
            && self.bridge.state() == State::TakingUpSlack
        {
            self.cycle();
        }
        self.bridge.state() == State::Ready
    }

    /// Sends the platform somewhere.
    pub fn go_to(&mut self, x: f64, y: f64, z: f64) {
        // Finite goals are never refused.
        let _ = self.bridge.operator(OperatorCommand::Goal(Pose::at(x, y, z)), self.now);
    }
}

fn parameters(config: &Config) -> ControllerParameters {
    config.of_drives(ControllerParameters {
        lambda: config.controller.lambda,
        eta: config.controller.eta,
        pose_source: PoseSource::CableLengths,
        force_loop: true,
        ..ControllerParameters::of(&config.rig)
    })
}
