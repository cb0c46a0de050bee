//! What an importer asks of an instance on buses: Configuration Mode, clocks, binary variables, text.

use std::ffi::CStr;

use super::{Instance, argument};
use crate::error::FmiError;
use crate::lifecycle::{Function, State};
use crate::log::{Category, Log};
use crate::models::node::{ROOM, of_bus};
use crate::models::{Interface, Use};
use crate::node::{Clocked, Member, Node, OnBuses, member};
use crate::variables::Kind;

impl Instance {
    /// A node on buses, switched on.
    pub fn on_buses(interface: Interface, node: Box<dyn Node>, log: Log) -> Self {
        let buses = OnBuses::new(node, interface.buses().len());
        let mut instance = Self { node: Some(buses), ..Self::new(interface, Use::OnBuses, false, log) };
        instance.write_node();
        instance
    }

    /// Instantiated -> Configuration Mode.
    pub fn enter_configuration(&mut self) {
        self.now.state = State::Configuration;
    }

    /// Configuration Mode -> Instantiated.
    pub fn exit_configuration(&mut self) {
        self.now.state = State::Instantiated;
    }

    /// Initialization Mode -> Event Mode, in which the bus simulation is told of the bit rates.
    pub(super) fn start_node(&mut self) {
        self.now.state = State::EventMode;
        self.node.as_mut().map(OnBuses::show);
        self.event(|now| format!("initialised at t = {} s", now.time()));
    }

    /// A step that was found to make sense. It is never undone.
    pub(super) fn step_node(&mut self, point: f64, h: f64) -> Result<(), FmiError> {
        let until = self.nanoseconds(point + h);
        let Some(buses) = &mut self.node else { return Ok(()) };
        let longest = buses.node.longest_step() as f64 * 1e-9;
        if h > longest * (1.0 + 1e-9) {
            let allowed = format!("at most {longest}, for whose frames there is room on the buses");
            return Err(argument("communicationStepSize", h, &allowed));
        }
        let before = self.log.is_enabled(Category::Events).then(|| self.now.values.clone());
        buses.node.step(until, &mut self.now.values, &self.log);
        buses.show();
        self.now.set_time(point + h);
        if let Some(before) = before {
            self.report_changes(&before);
        }
        Ok(())
    }

    /// Events are done: what was received is taken in.
    pub(super) fn update_node(&mut self) {
        let now = self.nanoseconds(self.time());
        if let Some(buses) = &mut self.node {
            buses.update(now, &self.log);
        }
    }

    /// Outputs of a node that was just switched on.
    pub(super) fn write_node(&mut self) {
        if let Some(buses) = &mut self.node {
            buses.node.write(&mut self.now.values);
        }
    }

    /// Since the start.
    fn nanoseconds(&self, time: f64) -> u64 {
        ((time - self.start) * 1e9).round() as u64
    }

    /// Hands the clocks behind `references` to `give`. One of the node's ticks once only.
    ///
    /// # Errors
    /// Names the first reference that is no clock's.
    pub fn get_clocks(
        &mut self,
        function: &'static Function,
        references: &[u32],
        mut give: impl FnMut(usize, bool),
    ) -> Result<(), FmiError> {
        for (i, &reference) in references.iter().enumerate() {
            let ticks = match self.member(function, reference, is_clock)? {
                (_, Member::TxClock, port) => std::mem::take(&mut port.is_due),
                (_, _, port) => port.receives,
            };
            give(i, ticks);
        }
        Ok(())
    }

    /// Lets clocks tick: those of what is received.
    ///
    /// # Errors
    /// Names the first reference that is no such clock's.
    pub fn set_clocks(
        &mut self,
        function: &'static Function,
        references: &[u32],
        ticks: impl Fn(usize) -> bool,
    ) -> Result<(), FmiError> {
        for (i, &reference) in references.iter().enumerate() {
            match self.member(function, reference, is_clock)? {
                (_, Member::RxClock, port) => port.receives = ticks(i),
                _ => return Err(self.clock_error(reference, "it is an output")),
            }
        }
        Ok(())
    }

    /// The bytes of a binary variable, which stay there until the next call.
    ///
    /// # Errors
    /// Names a reference that is no binary variable's, and a variable whose clock does not tick.
    pub fn binary(&mut self, function: &'static Function, reference: u32) -> Result<&[u8], FmiError> {
        let is_initial = !self.now.state.is_initialised();
        let (bus, what, port) = self.member(function, reference, is_binary)?;
        let ticks = if what == Member::TxData { port.sends } else { port.receives };
        if !ticks && !is_initial {
            return Err(self.clock_error(reference, "its clock does not tick"));
        }
        let Some(buses) = &mut self.node else { return Ok(&[]) };
        match what {
            Member::RxData => Ok(&buses.ports[bus].received),
            _ if ticks => Ok(buses.node.shown(bus)),
            _ => Ok(&[]),
        }
    }

    /// Sets a binary variable.
    ///
    /// # Errors
    /// Names a reference that is none's or an output's, one whose clock does not tick, and bytes that are more than `maxSize`.
    pub fn set_binary(
        &mut self,
        function: &'static Function,
        reference: u32,
        bytes: &[u8],
    ) -> Result<(), FmiError> {
        let is_initial = self.now.state == State::Initialization;
        let (_, what, port) = self.member(function, reference, is_binary)?;
        if what == Member::TxData {
            return Err(self.clock_error(reference, "it is an output"));
        }
        if !port.receives && !is_initial {
            return Err(self.clock_error(reference, "its clock does not tick"));
        }
        if bytes.len() > ROOM {
            let wanted = format!("at most {ROOM}, its maxSize");
            return Err(FmiError::Length { argument: "Rx_Data", given: bytes.len(), wanted });
        }
        port.received.clear();
        port.received.extend_from_slice(bytes);
        Ok(())
    }

    /// The text of a variable, which stays there until the next call.
    ///
    /// # Errors
    /// Names a reference that is no text's.
    pub fn text(&mut self, function: &'static Function, reference: u32) -> Result<&CStr, FmiError> {
        self.scalar(function, |kind| matches!(kind, Kind::String), reference)?;
        Ok(self.node.as_mut().map_or(c"", OnBuses::fault))
    }

    /// What a reference is of a bus.
    fn member(
        &mut self,
        function: &'static Function,
        reference: u32,
        handles: fn(Member) -> bool,
    ) -> Result<(usize, Member, &mut Clocked), FmiError> {
        let buses = self.interface.buses();
        let Some((bus, what)) = member(reference, buses.len()) else {
            let scalar = self.any_scalar(function, reference)?;
            let (name, kind) = (scalar.name(), self.interface.kind(scalar.row).name());
            return Err(FmiError::WrongType { function: function.name, name, reference, kind });
        };
        if !handles(what) {
            let kind = if is_clock(what) { Kind::Clock.name() } else { "Binary" };
            let name = name(buses, reference);
            return Err(FmiError::WrongType { function: function.name, name, reference, kind });
        }
        match &mut self.node {
            Some(node) => Ok((bus, what, &mut node.ports[bus])),
            None => Err(FmiError::State("it has no buses".to_owned())),
        }
    }

    fn clock_error(&self, reference: u32, why: &'static str) -> FmiError {
        FmiError::Clock { name: name(self.interface.buses(), reference), why }
    }
}

fn is_clock(member: Member) -> bool {
    matches!(member, Member::RxClock | Member::TxClock)
}

fn is_binary(member: Member) -> bool {
    !is_clock(member)
}

/// As in the XML.
fn name(buses: &[String], reference: u32) -> String {
    let names = |(k, bus)| of_bus(k).map(|(of, what): (u32, &str)| (of, format!("{bus}.{what}")));
    let mut all = buses.iter().enumerate().flat_map(names);
    all.find(|(of, _)| *of == reference).map(|(_, name)| name).unwrap_or_default()
}
