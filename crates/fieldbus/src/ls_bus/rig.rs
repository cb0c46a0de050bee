//! Drives, load cells and platform as one node a bus.

use super::{Notice, Port, Received, ports};
use crate::config::Config;
use crate::simulated::{SimulatedRig, Support};
use crate::{Frame, Nanoseconds};
use cable_robot::robot::{ParameterError, PerCable};
use cable_robot::sim::{PlantOutputs, PlantParameters};

/// The platform and the nodes' clocks move on so often in a period at least.
const TICKS: Nanoseconds = 4;

/// The simulated rig and its buses.
#[derive(Debug)]
pub struct RigNode {
    rig: SimulatedRig,
    ports: Vec<Port>,
    period: Nanoseconds,
    time: Nanoseconds,
    out: Vec<(usize, Frame)>,
}

impl RigNode {
    /// Switched on at time 0, the platform on its stand. Of `imperfections` all but rig and pose counts.
    ///
    /// # Errors
    /// [`ParameterError`] for an imperfection that makes no sense.
    pub fn new(config: Config, imperfections: PlantParameters) -> Result<Self, ParameterError> {
        Ok(Self {
            ports: ports(&config),
            period: config.period,
            rig: SimulatedRig::new(config, imperfections)?,
            time: 0,
            out: vec![],
        })
    }

    /// The platform as it is.
    pub fn plant(&self) -> &PlantOutputs {
        self.rig.plant()
    }

    /// What carries it.
    pub fn support(&self) -> Support {
        self.rig.support()
    }

    /// What the motors pull, N.
    pub fn motor_tension(&self) -> PerCable<f64> {
        self.rig.motor_tension()
    }

    /// Its buses, in the order of the fieldbus file.
    pub fn ports(&mut self) -> &mut [Port] {
        &mut self.ports
    }

    /// Takes in the operations that a bus brings at `now`, and tells of what is odd. What the nodes answer leaves with the next step.
    pub fn receive(&mut self, bus: usize, bytes: &[u8], now: Nanoseconds, tell: &mut dyn FnMut(Notice)) {
        let (rig, out) = (&mut self.rig, &mut self.out);
        self.ports[bus].receive(bytes, &mut |received| match received {
            Received::Frame(frame) => rig.on_frame(bus, &frame, now, out),
            // The nodes notice that they hear the bridge no more.
            Received::BusOff => {}
            Received::Notice(notice) => tell(notice),
        });
        self.send();
    }

    /// Lets time pass until `until`, in equal parts of at most a quarter of a period.
    pub fn step(&mut self, until: Nanoseconds) {
        let (start, length) = (self.time, until.saturating_sub(self.time));
        let parts = (length * TICKS).div_ceil(self.period).max(1);
        for k in 1..=parts {
            self.rig.tick(start + length * k / parts, &mut self.out);
            self.send();
        }
        self.time = until;
    }

    /// What finds no room is lost, as on a bus.
    fn send(&mut self) {
        for (bus, frame) in self.out.drain(..) {
            let _ = self.ports[bus].send(frame);
        }
    }
}
