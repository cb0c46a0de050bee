//! What every simulated node does: boot, tell its state, answer service requests, watch the master.

use crate::Nanoseconds;
use crate::canopen::object::PDO_OFF;
use crate::canopen::sdo::UNSUPPORTED;
use crate::canopen::{
    Direction, Emergency, NmtCommand, NmtState, Node, Object, SYNC_ID, SdoRequest, SdoResponse, SdoResult,
    Value, Width,
};
use crate::frame::Frame;

/// Time from a reset to the boot-up message.
const BOOT_TIME: Nanoseconds = 20_000_000;

const NO_SUCH_OBJECT: u32 = 0x0602_0000;
const READ_ONLY: u32 = 0x0601_0002;
const WRONG_LENGTH: u32 = 0x0607_0010;
const WRONG_STATE: u32 = 0x0800_0022;

/// An object of the dictionary.
#[derive(Clone, Copy, Debug)]
struct Entry {
    object: Object,
    value: Value,
    is_writable: bool,
}

/// What may be wrong with a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeFaults {
    /// It says nothing and hears nothing.
    pub is_dead: bool,
    /// It sends no heartbeat.
    pub no_heartbeat: bool,
    /// It boots as much slower, in ns.
    pub slow: Nanoseconds,
    /// It says so twice, as after a reset of its own application.
    pub boots_twice: bool,
    /// Where its error behaviour (0x1029) takes it from Operational when its master is missing.
    pub without_master: Option<NmtState>,
    /// It refuses to have this object written, with this abort code.
    pub refuses: Option<(Object, u32)>,
}

/// What the node's application has to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Task {
    /// SYNC came.
    Sync,
    /// The first receive PDO came.
    Receive(Frame),
    /// An object was written.
    Written(Object, Value),
    /// Forget what was commanded: the communication starts anew.
    Reset,
}

/// A node with its dictionary and its state.
#[derive(Clone, Debug)]
pub struct SimulatedNode {
    node: Node,
    state: NmtState,
    entries: Vec<Entry>,
    power_on: Vec<Entry>,
    boots_at: Option<Nanoseconds>,
    boots_again: bool,
    next_heartbeat: Nanoseconds,
    master_heard: Option<Nanoseconds>,
    /// When its receive PDO came.
    received: Option<Nanoseconds>,
    /// What is wrong with it.
    pub faults: NodeFaults,
}

impl SimulatedNode {
    /// Boots at time 0. `objects` come on top of those of CiA 301 for one PDO each way.
    pub(super) fn new(node: Node, objects: &[(Object, Value, bool)]) -> Self {
        let mut all = vec![
            (Object::new(0x1001, 0), Value::u8(0), false),
            (Object::new(0x1016, 1), Value::u32(0), true),
            (Object::new(0x1017, 0), Value::u16(0), true),
        ];
        for (communication, id) in [(0x1400, 0x200), (0x1800, 0x180)] {
            let cob_id = PDO_OFF | (id + u32::from(node));
            all.push((Object::new(communication, 1), Value::u32(cob_id), true));
            all.push((Object::new(communication, 2), Value::u8(255), true));
            all.push((Object::new(communication, 5), Value::u16(0), true));
            all.push((Object::new(communication + 0x200, 0), Value::u8(0), true));
            all.extend((1..=8).map(|k| (Object::new(communication + 0x200, k), Value::u32(0), true)));
        }
        all.extend_from_slice(objects);
        let entry = |&(object, value, is_writable): &_| Entry { object, value, is_writable };
        let entries: Vec<_> = all.iter().map(entry).collect();
        Self {
            node,
            state: NmtState::BootUp,
            power_on: entries.clone(),
            entries,
            boots_at: Some(0),
            boots_again: false,
            next_heartbeat: 0,
            master_heard: None,
            received: None,
            faults: NodeFaults::default(),
        }
    }

    /// Its address.
    pub fn address(&self) -> Node {
        self.node
    }

    /// Its state.
    pub fn state(&self) -> NmtState {
        self.state
    }

    /// An object's bits; 0 if there is none.
    pub(super) fn get(&self, object: Object) -> u32 {
        self.entries.iter().find(|entry| entry.object == object).map_or(0, |entry| entry.value.bits)
    }

    /// Sets an object from inside.
    pub(super) fn set(&mut self, object: Object, bits: u32) {
        if let Some(entry) = self.entries.iter_mut().find(|entry| entry.object == object) {
            entry.value.bits = bits;
        }
    }

    /// Starts again: its dictionary is that of power-on.
    pub(super) fn reboot(&mut self, now: Nanoseconds) {
        self.entries.clone_from(&self.power_on);
        self.state = NmtState::BootUp;
        self.boots_at = Some(now + BOOT_TIME + self.faults.slow);
        self.boots_again = self.faults.boots_twice;
        (self.master_heard, self.received) = (None, None);
    }

    /// Takes in a frame; answers go to `out`.
    pub(super) fn on_frame(&mut self, frame: &Frame, now: Nanoseconds, out: &mut Vec<Frame>) -> Option<Task> {
        if self.faults.is_dead {
            return None;
        }
        if let Some((command, whom)) = NmtCommand::parse(frame) {
            return if whom.is_none_or(|node| node == self.node) {
                self.on_command(command, now)
            } else {
                None
            };
        }
        if self.state == NmtState::BootUp {
            return None;
        }
        if let Some((node, _)) = NmtState::parse(frame) {
            if u32::from(node) == self.get(Object::new(0x1016, 1)) >> 16 {
                self.master_heard = Some(now);
            }
            return None;
        }
        if let Some((node, request)) = SdoRequest::parse(frame) {
            let is_heard = node == self.node && self.state != NmtState::Stopped;
            return if is_heard { self.on_request(request, out) } else { None };
        }
        let is_operational = self.state == NmtState::Operational;
        let receive = self.pdo(Direction::Receive);
        match frame.id() {
            SYNC_ID if is_operational => Some(Task::Sync),
            id if is_operational && Some(id) == receive => {
                self.received = Some(now);
                Some(Task::Receive(*frame))
            }
            _ => None,
        }
    }

    fn on_command(&mut self, command: NmtCommand, now: Nanoseconds) -> Option<Task> {
        match command {
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => {
                self.reboot(now);
                return Some(Task::Reset);
            }
            _ if self.state == NmtState::BootUp => {}
            NmtCommand::Start => self.state = NmtState::Operational,
            NmtCommand::Stop => self.state = NmtState::Stopped,
            NmtCommand::EnterPreOperational => self.state = NmtState::PreOperational,
        }
        None
    }

    fn on_request(&mut self, request: Result<SdoRequest, Object>, out: &mut Vec<Frame>) -> Option<Task> {
        let (object, result) = match request {
            Err(object) => (object, SdoResult::Aborted(UNSUPPORTED)),
            Ok(SdoRequest::Read(object)) => {
                let entry = self.entries.iter().find(|entry| entry.object == object);
                (
                    object,
                    entry.map_or(SdoResult::Aborted(NO_SUCH_OBJECT), |entry| SdoResult::Value(entry.value)),
                )
            }
            Ok(SdoRequest::Write(object, value)) => {
                (object, self.write(object, value).map_or_else(SdoResult::Aborted, |()| SdoResult::Written))
            }
        };
        out.push(SdoResponse { object, result }.frame(self.node));
        match (request, result) {
            (Ok(SdoRequest::Write(object, value)), SdoResult::Written) => Some(Task::Written(object, value)),
            _ => None,
        }
    }

    fn write(&mut self, object: Object, value: Value) -> Result<(), u32> {
        if let Some((refused, code)) = self.faults.refuses
            && refused == object
        {
            return Err(code);
        }
        let is_mapping = matches!(object.index, 0x1600 | 0x1A00);
        let is_on = self.get(Object::new(object.index.wrapping_sub(0x200), 1)) & PDO_OFF == 0;
        let has_entries = self.get(Object::new(object.index, 0)) != 0;
        if is_mapping && (is_on || object.subindex > 0 && has_entries) {
            return Err(WRONG_STATE);
        }
        let entry = self.entries.iter_mut().find(|entry| entry.object == object).ok_or(NO_SUCH_OBJECT)?;
        if !entry.is_writable {
            return Err(READ_ONLY);
        }
        if entry.value.width != value.width {
            return Err(WRONG_LENGTH);
        }
        entry.value = value;
        Ok(())
    }

    fn communication(direction: Direction) -> u16 {
        if direction == Direction::Receive { 0x1400 } else { 0x1800 }
    }

    /// Identifier of its PDO, if that is on.
    fn pdo(&self, direction: Direction) -> Option<u16> {
        let cob_id = self.get(Object::new(Self::communication(direction), 1));
        (cob_id & PDO_OFF == 0 && cob_id != 0).then_some((cob_id & 0x7FF) as u16)
    }

    /// What its PDO carries, as its dictionary says.
    fn mapping(&self, direction: Direction) -> impl Iterator<Item = (Object, Width)> {
        let index = Self::communication(direction) + 0x200;
        (1..=self.get(Object::new(index, 0)) as u8).filter_map(move |k| {
            let entry = self.get(Object::new(index, k));
            let object = Object::new((entry >> 16) as u16, (entry >> 8) as u8);
            Some((object, Width::of_bytes((entry & 0xFF) as u8 / 8)?))
        })
    }

    /// The objects in a receive PDO; `None` if it is too short for its mapping.
    pub(super) fn received(&self, frame: &Frame) -> Option<Vec<(Object, u32)>> {
        let mut at = 0;
        self.mapping(Direction::Receive)
            .map(|(object, width)| {
                let mut bytes = [0; 4];
                bytes[..width.bytes()].copy_from_slice(frame.bytes().get(at..at + width.bytes())?);
                at += width.bytes();
                Some((object, u32::from_le_bytes(bytes)))
            })
            .collect()
    }

    /// Its transmit PDO, from the dictionary as it stands.
    pub(super) fn transmit(&self) -> Option<Frame> {
        let mut bytes = vec![];
        for (object, width) in self.mapping(Direction::Transmit) {
            bytes.extend_from_slice(&self.get(object).to_le_bytes()[..width.bytes()]);
        }
        Frame::new(crate::frame::FrameKind::Data, self.pdo(Direction::Transmit)?, &bytes)
    }

    /// Lets time pass: boot-up and heartbeats go to `out`.
    pub(super) fn tick(&mut self, now: Nanoseconds, out: &mut Vec<Frame>) {
        if self.faults.is_dead {
            return;
        }
        if self.boots_at.is_some_and(|at| now >= at) {
            self.boots_at = self.boots_again.then_some(now + BOOT_TIME);
            self.boots_again = false;
            self.entries.clone_from(&self.power_on);
            out.push(NmtState::BootUp.heartbeat(self.node));
            self.state = NmtState::PreOperational;
            self.next_heartbeat = now;
        }
        let period = Nanoseconds::from(self.get(Object::new(0x1017, 0))) * 1_000_000;
        if self.state != NmtState::BootUp
            && period > 0
            && now >= self.next_heartbeat
            && !self.faults.no_heartbeat
        {
            out.push(self.state.heartbeat(self.node));
            self.next_heartbeat = now + period;
        }
    }

    /// Whether the master it watches (0x1016) has fallen silent.
    pub(super) fn has_lost_master(&self, now: Nanoseconds) -> bool {
        let patience = Nanoseconds::from(self.get(Object::new(0x1016, 1)) & 0xFFFF) * 1_000_000;
        let silence = self.master_heard.map_or(0, |heard| now.saturating_sub(heard));
        patience > 0 && silence > patience
    }

    /// Leaves Operational, if it is to when its master is missing.
    pub(super) fn miss_master(&mut self) {
        if let (NmtState::Operational, Some(state)) = (self.state, self.faults.without_master) {
            self.state = state;
        }
    }

    /// Whether its receive PDO, which came before, has not come within its deadline (0x1400:5). Said once.
    pub(super) fn misses_frames(&mut self, now: Nanoseconds) -> bool {
        let deadline = Nanoseconds::from(self.get(Object::new(0x1400, 5))) * 1_000_000;
        let is_late = self.received.is_some_and(|received| now.saturating_sub(received) > deadline);
        let misses = deadline > 0 && is_late && self.state == NmtState::Operational;
        if misses {
            self.received = None;
        }
        misses
    }

    /// An emergency message.
    pub(super) fn emergency(&self, code: u16, out: &mut Vec<Frame>) {
        let register = if code == 0 { 0 } else { 1 };
        if self.state != NmtState::BootUp && !self.faults.is_dead {
            out.push(Emergency { node: self.node, code, register, maker: [0; 5] }.frame());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(node: &mut SimulatedNode, request: SdoRequest) -> SdoResult {
        let mut out = vec![];
        node.on_frame(&request.frame(5), 0, &mut out);
        SdoResponse::parse(&out[0]).unwrap().1.result
    }

    #[test]
    fn refusals_are_those_of_the_standard() {
        let own = (Object::new(0x6077, 0), Value::u16(7), false);
        let mut node = SimulatedNode::new(5, &[own]);
        let mut out = vec![];
        node.tick(0, &mut out);
        assert_eq!(out, [NmtState::BootUp.heartbeat(5)]);
        assert_eq!(answer(&mut node, SdoRequest::Read(own.0)), SdoResult::Value(Value::u16(7)));
        assert_eq!(answer(&mut node, SdoRequest::Write(own.0, Value::u16(1))), SdoResult::Aborted(READ_ONLY));
        let nothing = Object::new(0x2000, 0);
        assert_eq!(answer(&mut node, SdoRequest::Read(nothing)), SdoResult::Aborted(NO_SUCH_OBJECT));
        let heartbeat = Object::new(0x1017, 0);
        assert_eq!(
            answer(&mut node, SdoRequest::Write(heartbeat, Value::u8(1))),
            SdoResult::Aborted(WRONG_LENGTH)
        );
    }

    #[test]
    fn a_mapping_is_changed_only_while_its_pdo_is_off_and_empty() {
        let mut node = SimulatedNode::new(5, &[]);
        node.tick(0, &mut vec![]);
        let (id, count, first) = (Object::new(0x1800, 1), Object::new(0x1A00, 0), Object::new(0x1A00, 1));
        let mut write = |object, value| answer(&mut node, SdoRequest::Write(object, value));
        assert_eq!(write(first, Value::u32(0x1017_0010)), SdoResult::Written);
        assert_eq!(write(count, Value::u8(1)), SdoResult::Written);
        assert_eq!(write(first, Value::u32(0)), SdoResult::Aborted(WRONG_STATE));
        assert_eq!(write(id, Value::u32(0x185)), SdoResult::Written);
        assert_eq!(write(count, Value::u8(0)), SdoResult::Aborted(WRONG_STATE));
        assert_eq!(node.transmit(), Some(Frame::data(0x185, [0, 0])));
    }
}
