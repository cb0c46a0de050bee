//! The simulated rig in real time: frames in, frames out, and what a person beside it would see.

use std::io::BufRead;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};

use anyhow::{Context, Result, bail, ensure};
use cable_robot::robot::PerCable;
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::cia402::DriveState;
use cable_robot_fieldbus::simulated::mishap::GRAMMAR;
use cable_robot_fieldbus::simulated::{Link, Mishap, Script, SimulatedDrive, SimulatedRig, Support};
use cable_robot_fieldbus::transport::now;
use cable_robot_fieldbus::{Config, Files, Frame, Nanoseconds};
use cable_robot_files::read_text;
use cable_robot_programs::plain::plain;
use cable_robot_programs::shell;
use clap::Parser;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

use crate::port::Port;

/// The platform and the nodes' clocks move on in steps of this, at least.
const STEP: Nanoseconds = 1_000_000;

/// Of 99; can-bridge has 80.
const PRIORITY: u8 = 70;

/// Drives, load cells and the platform of a fieldbus file on its CAN buses, in real time
///
/// Prints what the bridge has to be told of each bus, then what happens: drives that change their state, the platform that is lifted or falls.
/// What shall go wrong is told in a script or, line by line, on standard input. Ctrl-C ends it.
#[derive(Parser)]
#[command(name = "rig-sim", version, after_help = format!("What may go wrong:\n{GRAMMAR}"))]
struct Arguments {
    /// The fieldbus file, the same as the bridge's
    #[arg(value_name = "FIELDBUS.toml")]
    fieldbus: PathBuf,
    /// A bus and where it is: `can0=pty` (a new pseudo-terminal; all buses that are not named), `can0=listen:3333` (a TCP port of
    /// this machine; `listen:HOST:PORT` of others too, with a warning), `can0=vcan0`,
    /// `can0=slcan:/dev/ttyACM0`
    #[arg(long = "bus", value_name = "NAME=ADDRESS")]
    buses: Vec<String>,
    /// What shall go wrong, and when
    #[arg(long)]
    script: Option<PathBuf>,
    /// Of everything that is left to chance
    #[arg(long, default_value_t = 1)]
    seed: u16,
    /// Coulomb friction between motor and platform, N a cable
    #[arg(long, default_value_t = 0.2)]
    friction: f64,
    /// Time constant of the motors' torque, s
    #[arg(long, default_value_t = 0.002)]
    motor_lag: f64,
    /// Standard deviation of the load cells' noise, N
    #[arg(long, default_value_t = 0.05)]
    load_cell_noise: f64,
}

/// Reads the command line, opens the buses, and runs until it is told to stop.
pub fn main() -> Result<()> {
    let arguments: Arguments = shell::parse();
    let config = Files::read(&arguments.fieldbus)?.config;
    let mut script = Script::new(config.rig.cables.len());
    if let Some(path) = &arguments.script {
        let text = read_text(path).with_context(|| format!("cannot read {}", path.display()))?;
        for (number, line) in (1..).zip(text.lines()) {
            script.add(line).with_context(|| format!("{}, line {number}", path.display()))?;
        }
    }
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = stop.clone();
    ctrlc::set_handler(move || stopped.store(true, Ordering::Relaxed))?;
    let mut lab = Lab::new(&arguments, config, script)?;
    let spoken = lines_of_stdin();
    // Drives wait for nobody. Without the right to it this is a process like others, and late on a busy machine.
    let _ = ThreadPriorityValue::try_from(PRIORITY).map(|priority| {
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(priority), fifo)
    });
    while !stop.load(Ordering::Relaxed) {
        lab.listen(&spoken);
        lab.proceed();
    }
    lab.print_summary();
    Ok(())
}

/// Which address each bus has.
fn addresses(config: &Config, given: &[String]) -> Result<Vec<String>> {
    let mut addresses = vec!["pty".to_owned(); config.buses.len()];
    for entry in given {
        let (name, address) =
            entry.split_once('=').with_context(|| format!("--bus {entry}: expected NAME=ADDRESS"))?;
        let Some(at) = config.buses.iter().position(|bus| bus.name == name) else {
            let known: Vec<_> = config.buses.iter().map(|bus| bus.name.as_str()).collect();
            bail!("--bus {entry}: the fieldbus file has no bus {name:?}, but {}", known.join(", "));
        };
        addresses[at] = address.to_owned();
    }
    Ok(addresses)
}

/// Lines as they are typed; another thread waits for them.
fn lines_of_stdin() -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        std::io::stdin().lock().lines().map_while(Result::ok).all(|line| sender.send(line).is_ok())
    });
    receiver
}

/// The rig with its buses, and what was seen of it so far.
struct Lab {
    rig: SimulatedRig,
    ports: Vec<Port>,
    link: Link,
    script: Script,
    start: Nanoseconds,
    time: Nanoseconds,
    lifted: Option<Nanoseconds>,
    /// What was last said of each drive, and of the platform.
    said: Vec<DriveState>,
    support: Support,
    received: u64,
    sent: u64,
    /// Smallest tension of each cable since the platform was lifted, N.
    least: PerCable<f64>,
    out: Vec<(usize, Frame)>,
}

impl Lab {
    fn new(arguments: &Arguments, config: Config, script: Script) -> Result<Self> {
        ensure!(arguments.seed > 0, "--seed 0 is not allowed: must be from 1 to {}", u16::MAX);
        let imperfections = PlantParameters {
            friction: arguments.friction,
            motor_lag: arguments.motor_lag,
            load_cell_noise: arguments.load_cell_noise,
            noise_seed: arguments.seed.into(),
            ..PlantParameters::default()
        };
        let mut ports = vec![];
        for (bus, address) in config.buses.iter().zip(addresses(&config, &arguments.buses)?) {
            let (port, told) = Port::open(bus, &address)?;
            println!("{}={told}", plain(&bus.name));
            ports.push(port);
        }
        let rig = SimulatedRig::new(config, imperfections)?;
        Ok(Self {
            said: rig.drives.iter().map(SimulatedDrive::state).collect(),
            least: PerCable::filled(rig.drives.len(), f64::INFINITY),
            support: rig.support(),
            rig,
            ports,
            link: Link::new(arguments.seed.into()),
            script,
            start: now(),
            time: 0,
            lifted: None,
            received: 0,
            sent: 0,
            out: vec![],
        })
    }

    /// Takes in what was typed.
    fn listen(&mut self, spoken: &Receiver<String>) {
        for line in spoken.try_iter() {
            if let Err(error) = self.script.add(&line) {
                eprintln!("{}", plain(&error.to_string()));
            }
        }
    }

    /// All frames that come within a step, then the rig as it is after it.
    fn proceed(&mut self) {
        let deadline = self.start + self.time + STEP;
        let share = STEP / self.ports.len() as Nanoseconds;
        for bus in 0..self.ports.len() {
            let mut until = deadline.min(now() + share);
            while let Some(frame) = self.ports[bus].receive(until) {
                // Encoders are read at SYNC. If this process was asleep for long, the frames of that time come first.
                let now = now() - self.start;
                if now < self.time + 20 * STEP {
                    self.tick(now);
                }
                self.received += 1;
                self.link.send_to_rig(bus, &frame, self.time);
                self.let_arrive();
                self.send();
                until = until.min(deadline);
            }
        }
        let now = now() - self.start;
        while self.time < now {
            self.tick(now.min(self.time + STEP));
        }
        for (mishap, words) in self.script.due(self.time, self.lifted) {
            self.say(&words);
            if mishap == Mishap::HangUp {
                self.ports.iter_mut().for_each(Port::hang_up);
            }
            self.rig.suffer(mishap, &mut self.link, self.time, &mut self.out);
        }
        self.send();
    }

    fn tick(&mut self, time: Nanoseconds) {
        self.time = time;
        self.rig.tick(time, &mut self.out);
        self.let_arrive();
        self.observe();
    }

    /// What was received, as far as it has come through the link.
    fn let_arrive(&mut self) {
        while let Some((_, bus, frame)) = self.link.at_rig(self.time) {
            self.rig.on_frame(bus, &frame, self.time, &mut self.out);
        }
    }

    fn send(&mut self) {
        for (bus, frame) in self.out.drain(..) {
            self.link.send_to_bridge(bus, &frame, self.time);
        }
        while let Some((_, bus, frame)) = self.link.at_bridge(self.time) {
            self.ports[bus].send(&frame);
            self.sent += 1;
        }
    }

    fn say(&self, what: &str) {
        println!("{:9.3} s  {what}", self.time as f64 * 1e-9);
    }

    /// Says what changed.
    fn observe(&mut self) {
        for i in 0..self.said.len() {
            let state = self.rig.drives[i].state();
            if state != self.said[i] {
                self.say(&format!("drive {}: {state}", i + 1));
                self.said[i] = state;
            }
        }
        let support = self.rig.support();
        if support != self.support {
            self.support = support;
            self.lifted = self.lifted.or((support == Support::Cables).then_some(self.time));
            self.say(support_in_words(support));
        }
        if support == Support::Cables {
            let tension = self.rig.plant().measured_tension;
            self.least = PerCable::from_fn(tension.len(), |i| self.least[i].min(tension[i]));
        }
    }

    fn print_summary(&self) {
        let dropped: u64 = self.ports.iter().map(|port| port.dropped).sum();
        println!("frames: {} received, {} sent, {dropped} of them dropped", self.received, self.sent);
        println!("oldest command that a motor followed: {:.1} ms", self.rig.oldest_command() as f64 * 1e-6);
        if self.lifted.is_some() {
            println!("smallest tensions while the cables carried the platform: {:.2?} N", self.least);
            let pose = self.rig.plant().encoder_pose;
            let support = support_in_words(self.support);
            println!("{support} at ({:.3}, {:.3}, {:.3}) m", pose.0[0], pose.0[1], pose.0[2]);
        } else {
            println!("platform: never left its stand");
        }
    }
}

fn support_in_words(support: Support) -> &'static str {
    match support {
        Support::Stand => "the platform is on its stand",
        Support::Cables => "the cables carry the platform",
        Support::Floor => "the platform fell",
    }
}
