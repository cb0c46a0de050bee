//! The loop against links in memory: nothing is allocated (what the FMU does inside is not counted), and failures of the program itself lead to the safe output.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::PathBuf;
use std::sync::atomic::AtomicU32;
use std::sync::{Arc, Mutex};

use cable_robot::plan::{ControllerInputs, ControllerOutputs, ControllerParameters, PoseSource};
use cable_robot::sim::{ControllerModel, ModelError, PlantParameters};
use cable_robot_fieldbus::cia402::DriveState;
use cable_robot_fieldbus::simulated::SimulatedRig;
use cable_robot_fieldbus::transport::{LinkError, Received, Transport, now};
use cable_robot_fieldbus::{
    Bridge, Config, Files, Frame, LibraryController, Nanoseconds, OperatorCommand, State,
};
use rtrb::{Consumer, Producer, RingBuffer};

use super::controller::BridgeController;
use super::entry::{Entry, Teller};
use super::session::{End, Session};

struct Counting;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is handed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.set(CALLS.get() + 1);
        // SAFETY: as for this function.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as for this function.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The example.
pub fn files() -> Files {
    Files::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/can/akd.toml").as_ref()).unwrap()
}

/// The same, with times that a busy machine can keep.
pub fn config() -> Config {
    let mut config = files().config;
    config.limits.lost_cycles = 100;
    config.heartbeat.timeout = 2_000_000_000;
    config.heartbeat.drive_watchdog = 2_000_000_000;
    config
}

/// The FMU of the project.
pub fn packed() -> PathBuf {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../target/fmu/fmi3/CableRobotController.fmu").into()
}

/// A simulated rig on which time passes when the bridge reads. It allocates; that is not counted.
struct Wire {
    rig: Arc<Mutex<SimulatedRig>>,
    coming: Vec<(usize, Frame)>,
    start: Nanoseconds,
}

impl Transport for Wire {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        uncounted(|| self.rig.lock().unwrap().on_frame(0, frame, now() - self.start, &mut self.coming));
        Ok(())
    }

    fn receive(&mut self, _deadline: Nanoseconds) -> Result<Option<Received>, LinkError> {
        uncounted(|| {
            if self.coming.is_empty() {
                self.rig.lock().unwrap().tick(now() - self.start, &mut self.coming);
            }
            let first = (!self.coming.is_empty()).then(|| self.coming.remove(0).1);
            Ok(first.map(|frame| Received { frame, time: now() }))
        })
    }
}

fn uncounted<T>(work: impl FnOnce() -> T) -> T {
    let before = CALLS.get();
    let result = work();
    CALLS.set(before);
    result
}

/// Bridge, loop and simulated rig, up to the controller's tensions.
struct Bench<'a> {
    session: Session<'a>,
    rig: Arc<Mutex<SimulatedRig>>,
    commands: Producer<OperatorCommand>,
    journal: Consumer<Entry>,
    state: State,
    stop: Arc<AtomicU32>,
}

impl<'a> Bench<'a> {
    fn new(controller: &'a mut dyn ControllerModel) -> Self {
        let config = config();
        let rig = SimulatedRig::new(config.clone(), PlantParameters::default()).unwrap();
        let rig = Arc::new(Mutex::new(rig));
        let wire = Wire { rig: Arc::clone(&rig), coming: vec![], start: now() };
        let (producer, journal) = RingBuffer::new(1 << 14);
        let (commands, consumer) = RingBuffer::new(16);
        let stop = Arc::new(AtomicU32::new(0));
        let session = Session::new(
            Bridge::new(config),
            controller,
            vec![Box::new(wire)],
            Teller::new(producer),
            consumer,
            Arc::clone(&stop),
            vec![],
        );
        Self { session, rig, commands, journal, state: State::Configuring, stop }
    }

    /// One cycle, as often as time allows.
    fn cycle(&mut self) -> Option<End> {
        let end = self.session.once();
        while let Ok(entry) = self.journal.pop() {
            if let Entry::Cycle(cycle) = entry {
                self.state = cycle.report.state;
            }
        }
        end
    }

    fn until(&mut self, state: State) {
        let deadline = now() + 60_000_000_000;
        while self.state != state {
            assert!(now() < deadline && self.cycle().is_none(), "{} before {state}", self.state);
        }
    }

    /// Taut on its stand.
    fn make_ready(&mut self) {
        self.until(State::Homing);
        (0..20).for_each(|_| assert_eq!(self.cycle(), None));
        while self.state != State::Ready {
            self.commands.push(OperatorCommand::Home).unwrap();
            assert_eq!(self.cycle(), None);
        }
    }

    fn start(&mut self) {
        self.make_ready();
        self.commands.push(OperatorCommand::Enable).unwrap();
        self.until(State::Enabled);
    }
}

fn library() -> LibraryController {
    let parameters = ControllerParameters { pose_source: PoseSource::CableLengths, ..Default::default() };
    LibraryController::new(parameters)
}

#[test]
fn a_cycle_allocates_nothing() {
    let mut controller = BridgeController::open(&config(), Some(&packed())).unwrap();
    let mut bench = Bench::new(&mut controller);
    bench.start();
    let before = CALLS.get();
    for k in 0..500 {
        if k % 20 == 0 {
            bench.commands.push(OperatorCommand::Enable).unwrap();
        }
        bench.cycle();
    }
    assert_eq!((CALLS.get() - before, bench.state), (0, State::Enabled), "allocations in 500 cycles");
    bench.commands.push(OperatorCommand::Lower).unwrap();
    while bench.state != State::Homing {
        bench.cycle();
    }
    assert_eq!(CALLS.get() - before, 0, "allocations while the platform is let down");
}

/// A controller that fails as no controller should.
struct Panicking(LibraryController, Arc<AtomicU32>);

impl ControllerModel for Panicking {
    fn start(&mut self, inputs: &ControllerInputs) -> Result<ControllerOutputs, ModelError> {
        self.0.start(inputs)
    }

    fn step(
        &mut self,
        time: f64,
        h: f64,
        inputs: &ControllerInputs,
    ) -> Result<ControllerOutputs, ModelError> {
        if self.1.load(std::sync::atomic::Ordering::Relaxed) > 0 {
            panic!("on purpose, by a test");
        }
        self.0.step(time, h, inputs)
    }
}

#[test]
fn a_panic_leads_to_the_safe_output_and_drives_that_are_off() {
    super::real_time::say_panics_briefly();
    let panics = Arc::new(AtomicU32::new(0));
    let mut controller = Panicking(library(), Arc::clone(&panics));
    let mut bench = Bench::new(&mut controller);
    bench.start();
    panics.store(1, std::sync::atomic::Ordering::Relaxed);
    bench.until(State::Stopping);
    let pulls = bench.rig.lock().unwrap().motor_tension();
    assert!(pulls.iter().all(|tension| *tension > 0.0), "{pulls:?}");
    let end = std::iter::from_fn(|| Some(bench.cycle())).flatten().next();
    assert_eq!(end, Some(End::CutOff));
    assert_off(&bench);
}

#[test]
fn one_signal_ramps_down_and_a_second_cuts_off() {
    let mut controller = library();
    let mut bench = Bench::new(&mut controller);
    bench.start();
    bench.stop.store(1, std::sync::atomic::Ordering::Relaxed);
    bench.until(State::Stopping);
    bench.stop.store(2, std::sync::atomic::Ordering::Relaxed);
    assert_eq!(bench.cycle(), Some(End::CutOff));
    assert_off(&bench);
}

/// Whoever ends it has to know that a drive may still pull.
#[test]
fn drives_that_do_not_confirm_that_they_are_off_are_no_good_end() {
    let mut controller = library();
    let mut bench = Bench::new(&mut controller);
    bench.make_ready();
    // For less than the cycles that are bridged.
    bench.rig.lock().unwrap().drives[2].faults.is_silent = true;
    bench.stop.store(1, std::sync::atomic::Ordering::Relaxed);
    let end = std::iter::from_fn(|| Some(bench.cycle())).flatten().next();
    assert_eq!(end, Some(End::Faulted));
}

fn assert_off(bench: &Bench) {
    let rig = bench.rig.lock().unwrap();
    assert!(rig.drives.iter().all(|drive| drive.state() == DriveState::SwitchOnDisabled));
}
