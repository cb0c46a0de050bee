//! What an instance on buses is beside its variables of numbers: FMI-LS-BUS knows what a node sends and receives as binary variables
//! that are clocked (docs/ls-bus.md).

use std::ffi::{CStr, CString};

use super::log::Log;
use super::models::node::{FIRST_OF_BUSES, ROOM};
use super::values::Values;

/// A bridge or a rig behind its buses. Times count from the start of the simulation, ns.
pub trait Node {
    /// Back to power-on.
    fn reset(&mut self);

    /// The longest step, ns.
    fn longest_step(&self) -> u64;

    /// Steps until `until` with the inputs in `values`, and writes the outputs there.
    fn step(&mut self, until: u64, values: &mut Values, log: &Log);

    /// The outputs as they are.
    fn write(&self, values: &mut Values);

    /// The fault; `None` if there is none.
    fn fault(&self) -> Option<String>;

    /// Takes in the operations that a bus brings at `now`.
    fn receive(&mut self, bus: usize, bytes: &[u8], now: u64, log: &Log);

    /// A bus communication point has come: whether there is anything to send.
    fn show(&mut self, bus: usize) -> bool;

    /// What is sent to the bus now.
    fn shown(&mut self, bus: usize) -> &[u8];

    /// What was shown is sent.
    fn forget_shown(&mut self, bus: usize);
}

/// What a variable of a bus is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// Operations from the bus.
    RxData,
    /// Operations for the bus.
    TxData,
    /// Ticks when there are some from the bus.
    RxClock,
    /// Ticks when there are some for the bus.
    TxClock,
}

/// The bus, and what it is of it, that a value reference belongs to.
pub fn member(reference: u32, buses: usize) -> Option<(usize, Member)> {
    let k = reference.checked_sub(FIRST_OF_BUSES)? as usize;
    let member = [Member::RxData, Member::TxData, Member::RxClock, Member::TxClock][k % 4];
    (k / 4 < buses).then_some((k / 4, member))
}

/// A node with the clocks and binary variables of its buses.
pub struct OnBuses {
    /// What it is.
    pub node: Box<dyn Node>,
    /// One a bus.
    pub ports: Vec<Clocked>,
    /// What was last shown as the fault.
    pub fault: CString,
}

/// The clocks and what they clock. A clock ticks until it was asked, or until the events are done.
#[derive(Debug, Default)]
pub struct Clocked {
    /// Rx_Clock ticks.
    pub receives: bool,
    /// Rx_Data.
    pub received: Vec<u8>,
    /// Tx_Clock ticks, and nobody has asked yet.
    pub is_due: bool,
    /// Tx_Clock ticks in these events: Tx_Data may be read.
    pub sends: bool,
}

impl OnBuses {
    /// Switched on.
    pub fn new(node: Box<dyn Node>, buses: usize) -> Self {
        let port = |_| Clocked { received: Vec::with_capacity(ROOM), ..Clocked::default() };
        Self { ports: (0..buses).map(port).collect(), node, fault: CString::default() }
    }

    /// Back to power-on.
    pub fn reset(&mut self) {
        self.node.reset();
        self.ports.iter_mut().for_each(Clocked::forget);
        self.fault = CString::default();
    }

    /// A communication point has come. Whether there is anything to send on any bus.
    pub fn show(&mut self) -> bool {
        for (bus, port) in self.ports.iter_mut().enumerate() {
            port.sends = self.node.show(bus);
            port.is_due = port.sends;
        }
        self.sends()
    }

    /// Whether there is anything to send on any bus.
    pub fn sends(&self) -> bool {
        self.ports.iter().any(|port| port.sends)
    }

    /// Takes in what was received, and forgets it with what was sent.
    pub fn update(&mut self, now: u64, log: &Log) {
        for (bus, port) in self.ports.iter_mut().enumerate() {
            if port.receives {
                self.node.receive(bus, &port.received, now, log);
            }
            if port.sends {
                self.node.forget_shown(bus);
            }
            port.forget();
        }
    }

    /// The text of the fault now.
    pub fn fault(&mut self) -> &CStr {
        let text = self.node.fault().unwrap_or_default();
        if self.fault.as_bytes() != text.as_bytes() {
            self.fault = CString::new(text).unwrap_or_default();
        }
        &self.fault
    }
}

impl Clocked {
    fn forget(&mut self) {
        (self.receives, self.is_due, self.sends) = (false, false, false);
        self.received.clear();
    }
}
