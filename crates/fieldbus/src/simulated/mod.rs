//! A lab without hardware: drives, load cells and the plant, behind the buses of a fieldbus file.

mod bench;
mod cell;
mod drive;
mod link;
pub mod mishap;
mod node;
mod winding;

pub use bench::Bench;
pub use cell::{CellFault, SimulatedCells};
pub use drive::{DriveFaults, SimulatedDrive};
pub use link::{Link, LinkFaults};
pub use mishap::{Mishap, Script};
pub use node::{NodeFaults, SimulatedNode};

use super::Nanoseconds;
use super::config::Config;
use super::frame::Frame;
use cable_robot::robot::{ParameterError, PerCable, Pose};
use nalgebra::Vector3;
use winding::Winding;

use cable_robot::sim::{Plant, PlantInputs, PlantOutputs, PlantParameters};

/// Share of its weight that the cables must carry to lift the platform off its stand.
const LIFTS_AT: f64 = 0.98;
/// It is on its stand again where it comes down within this share of the shortest cable at home of where it stood (at home, or last): to the side,
/// and so far below, since the stand gives way. What hovers there is not touched by it.
const STAND: f64 = 0.02;
const STAND_GIVES_WAY: f64 = 0.002;
/// The floor is so far below the home pose, m.
const FLOOR: f64 = 0.3;
/// A person moves the platform at this share of the speed that counts as a mistake of an encoder.
const HAND: f64 = 0.1;
/// Counts of a motor at the home pose, times its cable's number: they mean nothing, so they are not zero.
const COUNTS_AT_HOME: i32 = 10_000;

/// What carries the platform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Its stand, at the home pose, or blocks where a person put it.
    Stand,
    /// The cables.
    Cables,
    /// The floor: it fell.
    Floor,
}

/// From where to where a person puts the platform.
#[derive(Clone, Copy, Debug)]
struct Placing {
    from: Pose,
    to: Pose,
    /// Of the way that is done, from 0 to 1, and how much of it each second.
    share: f64,
    speed: f64,
}

impl Placing {
    fn at(pose: Pose) -> Self {
        Self { from: pose, to: pose, share: 1.0, speed: 0.0 }
    }

    fn pose(&self) -> Pose {
        if self.share < 1.0 { Pose(self.from.0 + self.to.minus(&self.from) * self.share) } else { self.to }
    }
}

/// Everything on the buses but the bridge.
#[derive(Clone, Debug)]
pub struct SimulatedRig {
    /// One a cable.
    pub drives: Vec<SimulatedDrive>,
    /// One a node with load cells.
    pub cells: Vec<SimulatedCells>,
    config: Config,
    /// At the home pose, m.
    home_length: PerCable<f64>,
    plant: Plant,
    windings: Vec<Winding>,
    support: Support,
    placing: Placing,
    time: Nanoseconds,
    oldest_command: Nanoseconds,
}

impl SimulatedRig {
    /// Switched on at time 0, the platform on its stand. Rig and home pose are those of `config`; of `imperfections` the rest counts.
    ///
    /// # Errors
    /// [`ParameterError`] for an imperfection that makes no sense.
    pub fn new(config: Config, imperfections: PlantParameters) -> Result<Self, ParameterError> {
        let (rig, cables) = (config.rig, config.rig.cables.len());
        let parameters = PlantParameters { rig, initial_pose: config.home, ..imperfections };
        let plant = Plant::new(parameters, &PlantInputs::none(cables))?;
        let mut nodes: Vec<_> = config.load_cells.iter().map(|cell| cell.node).collect();
        nodes.dedup();
        Ok(Self {
            drives: (0..cables).map(|i| SimulatedDrive::new(&config, i)).collect(),
            cells: nodes.into_iter().map(|node| SimulatedCells::new(&config, node)).collect(),
            windings: rig
                .cables_at(&config.home)
                .length
                .iter()
                .map(|length| Winding::taut(*length))
                .collect(),
            home_length: rig.cables_at(&config.home).length,
            placing: Placing::at(config.home),
            config,
            plant,
            support: Support::Stand,
            time: 0,
            oldest_command: 0,
        })
    }

    /// The platform, as it is and as encoders and load cells see it.
    pub fn plant(&self) -> &PlantOutputs {
        self.plant.outputs()
    }

    /// What carries the platform.
    pub fn support(&self) -> Support {
        self.support
    }

    /// How much cable each winch has let go of, m: as long as the straight line is, or longer.
    pub fn paid_out(&self) -> PerCable<f64> {
        PerCable::from_fn(self.drives.len(), |i| self.windings[i].paid_out)
    }

    /// What the motors pull, N; nothing in a slack cable.
    pub fn motor_tension(&self) -> PerCable<f64> {
        PerCable::from_fn(self.drives.len(), |i| self.windings[i].tension(self.drives[i].tension()))
    }

    /// Gives a cable (from 0) so much slack, m.
    pub(super) fn slacken(&mut self, cable: usize, slack: f64) {
        self.windings[cable] = Winding::slack(self.plant.outputs().cable_length[cable] + slack);
    }

    /// A person takes the platform off its stand or its blocks, and puts it on others; nothing if it hangs.
    pub(super) fn place(&mut self, to: Pose) {
        if self.support != Support::Stand {
            return;
        }
        let from = self.placing.pose();
        let way = to.minus(&from);
        let radius = self.config.rig.platform_radius();
        let distance =
            (way.fixed_rows::<3>(0).norm() + radius * way.fixed_rows::<3>(3).norm()).max(f64::MIN_POSITIVE);
        self.placing =
            Placing { from, to, share: 0.0, speed: HAND * self.config.limits.cable_speed / distance };
    }

    /// The longest that a motor ever pulled without a newer command, until the last [`SimulatedRig::tick`].
    pub fn oldest_command(&self) -> Nanoseconds {
        self.oldest_command
    }

    /// Takes in a frame from a bus at `now`; answers go to `out`.
    pub fn on_frame(&mut self, bus: usize, frame: &Frame, now: Nanoseconds, out: &mut Vec<(usize, Frame)>) {
        let mut answers = vec![];
        for i in 0..self.drives.len() {
            if self.config.drives[i].bus == bus {
                self.drives[i].on_frame(frame, now, &mut answers);
            }
        }
        for cells in &mut self.cells {
            if self.config.load_cells[cells.cells[0].0].bus == bus {
                cells.on_frame(frame, now, &mut answers);
            }
        }
        out.extend(answers.into_iter().map(|frame| (bus, frame)));
    }

    /// Lets time pass until `now`: the platform moves, nodes send what is due to `out`.
    pub fn tick(&mut self, now: Nanoseconds, out: &mut Vec<(usize, Frame)>) {
        let h = now.saturating_sub(self.time) as f64 * 1e-9;
        self.time = now;
        self.move_platform(h);
        self.turn_winches(h);
        let seen = *self.plant.outputs();
        for i in 0..self.drives.len() {
            let (mut sent, at_home) = (vec![], COUNTS_AT_HOME * (i as i32 + 1));
            let winch = self.config.drives[i].winch;
            self.drives[i].turn_to(winch.counts(self.windings[i].paid_out - self.home_length[i], at_home));
            self.drives[i].tick(now, &mut sent);
            self.oldest_command = self.oldest_command.max(self.drives[i].command_age(now));
            out.extend(sent.into_iter().map(|frame| (self.config.drives[i].bus, frame)));
        }
        for cells in &mut self.cells {
            let (mut sent, bus) = (vec![], self.config.load_cells[cells.cells[0].0].bus);
            cells.feel(&seen.measured_tension);
            cells.tick(now, &mut sent);
            out.extend(sent.into_iter().map(|frame| (bus, frame)));
        }
    }

    fn turn_winches(&mut self, h: f64) {
        let PlantParameters { friction, motor_lag, .. } = *self.plant.parameters();
        let (straight, mass) = (self.plant.outputs().cable_length, winding::MASS * self.config.rig.mass);
        for i in 0..self.drives.len() {
            self.drives[i].turn(h, motor_lag);
            self.windings[i].turn(self.drives[i].tension(), straight[i], friction, mass, h);
        }
    }

    fn move_platform(&mut self, h: f64) {
        let inputs =
            PlantInputs { motor_tension: self.motor_tension(), ..PlantInputs::none(self.drives.len()) };
        if self.support == Support::Cables && h > 0.0 {
            if self.plant.step(&inputs, h).is_err() || self.fallen() > FLOOR {
                self.support = Support::Floor;
            } else if self.touches_stand() {
                (self.support, self.placing) =
                    (Support::Stand, Placing::at(self.plant.outputs().encoder_pose));
                self.stand(&inputs);
            }
        } else if self.support == Support::Stand {
            self.placing.share = (self.placing.share + h * self.placing.speed).min(1.0);
            self.stand(&inputs);
        }
    }

    fn shortest_at_home(&self) -> f64 {
        self.home_length.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The stand at home, or what it stood on last.
    fn touches_stand(&self) -> bool {
        let (plant, down) = (self.plant.outputs(), self.config.rig.gravity.normalize());
        let is_there = |stand: Vector3<f64>| {
            let way = plant.encoder_pose.position() - stand;
            let aside = (way - down * way.dot(&down)).norm();
            aside < STAND * self.shortest_at_home()
                && way.dot(&down) > STAND_GIVES_WAY * self.shortest_at_home()
        };
        plant.velocity.dot(&down) > 0.0
            && (is_there(self.config.home.position()) || is_there(self.placing.to.position()))
    }

    /// How far the platform is below the home pose, m.
    fn fallen(&self) -> f64 {
        let way = self.plant.outputs().encoder_pose.position() - self.config.home.position();
        way.dot(&self.config.rig.gravity.normalize())
    }

    /// At rest where it was put, whatever the motors pull, until they carry the weight.
    fn stand(&mut self, inputs: &PlantInputs) {
        let (rig, at) = (&self.config.rig, self.placing.pose());
        self.plant.stand(&at, inputs);
        let (force, _) = rig.cables_at(&at).wrench(&inputs.motor_tension);
        if -force.dot(&rig.gravity.normalize()) >= LIFTS_AT * rig.weight() {
            self.support = Support::Cables;
        }
    }
}
