//! Objects of a node's dictionary, their values, and the sequences of writes that set up its communication.

use std::fmt;

use super::Node;

/// Where a value stands in the dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub subindex: u8,
}

impl Object {
    /// `index` and `subindex`.
    pub const fn new(index: u16, subindex: u8) -> Self {
        Self { index, subindex }
    }
}

impl fmt::Display for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:04X}:{}", self.index, self.subindex)
    }
}

/// How wide a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 1 byte.
    Bits8 = 1,
    /// 2 bytes.
    Bits16 = 2,
    /// 3 bytes.
    Bits24 = 3,
    /// 4 bytes.
    Bits32 = 4,
}

impl Width {
    /// Number of bytes.
    pub const fn bytes(self) -> usize {
        self as usize
    }

    /// The bits of a value of this width that stands first.
    pub fn read(self, bytes: [u8; 4]) -> u32 {
        let known = if self == Self::Bits32 { u32::MAX } else { (1 << (8 * self.bytes())) - 1 };
        u32::from_le_bytes(bytes) & known
    }

    /// `None` unless 1 to 4 bytes.
    pub fn of_bytes(bytes: u8) -> Option<Self> {
        [Self::Bits8, Self::Bits16, Self::Bits24, Self::Bits32]
            .into_iter()
            .find(|width| *width as u8 == bytes)
    }
}

/// A value as it stands on the bus: its lower bytes count, signed ones in two's complement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value {
    /// The bits.
    pub bits: u32,
    /// How many of them.
    pub width: Width,
}

impl Value {
    /// 8 bits.
    pub const fn u8(bits: u8) -> Self {
        Self { bits: bits as u32, width: Width::Bits8 }
    }

    /// 16 bits.
    pub const fn u16(bits: u16) -> Self {
        Self { bits: bits as u32, width: Width::Bits16 }
    }

    /// 32 bits.
    pub const fn u32(bits: u32) -> Self {
        Self { bits, width: Width::Bits32 }
    }
}

/// Whose process data: the node's own (transmit) or what it is sent (receive).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// A TPDO.
    Transmit,
    /// An RPDO.
    Receive,
}

impl Direction {
    /// Communication parameter of the first PDO; the mapping parameter is 0x200 farther.
    const fn communication(self) -> u16 {
        match self {
            Self::Receive => 0x1400,
            Self::Transmit => 0x1800,
        }
    }

    /// Of the PDO that an object maps a value to.
    pub fn of_mapping(object: Object) -> Option<Self> {
        match object {
            Object { subindex: 0, .. } => None,
            Object { index: 0x1600..=0x17FF, .. } => Some(Self::Receive),
            Object { index: 0x1A00..=0x1BFF, .. } => Some(Self::Transmit),
            _ => None,
        }
    }
}

/// Set in a PDO's COB-ID: the PDO is off.
pub const PDO_OFF: u32 = 1 << 31;
/// Set in a TPDO's COB-ID: it may not be asked for by a remote frame.
pub const NO_REMOTE: u32 = 1 << 30;
/// Transmission type: at every SYNC.
pub const EVERY_SYNC: u8 = 1;

/// A dummy of 16 bits in an RPDO's mapping: passes over what is another node's (INTEGER16 of the data types).
pub const DUMMY_16: (Object, Width) = (Object::new(0x0003, 0), Width::Bits16);

/// Maps the first PDO as CiA 301 has it done: off, entries cleared, set, counted, transmission type, on.
pub fn map_pdo(direction: Direction, cob_id: u16, entries: &[(Object, Width)]) -> Vec<(Object, Value)> {
    let (communication, mapping) = (direction.communication(), direction.communication() + 0x200);
    let flags = if direction == Direction::Transmit { NO_REMOTE } else { 0 };
    let id = u32::from(cob_id) | flags;
    let mut writes = vec![
        (Object::new(communication, 1), Value::u32(id | PDO_OFF)),
        (Object::new(mapping, 0), Value::u8(0)),
    ];
    for (k, (object, width)) in (1..).zip(entries) {
        let bits = 8 * *width as u32;
        let entry = u32::from(object.index) << 16 | u32::from(object.subindex) << 8 | bits;
        writes.push((Object::new(mapping, k), Value::u32(entry)));
    }
    writes.push((Object::new(mapping, 0), Value::u8(entries.len() as u8)));
    writes.push((Object::new(communication, 2), Value::u8(EVERY_SYNC)));
    writes.push((Object::new(communication, 1), Value::u32(id)));
    writes
}

/// Makes a node say when its first receive PDO has not come for so many ms (event timer, 0x1400:5); not every node can.
pub fn receive_deadline(milliseconds: u16) -> (Object, Value) {
    (Object::new(0x1400, 5), Value::u16(milliseconds))
}

/// Makes a node tell its state every so many ms (0x1017).
pub fn produce_heartbeat(milliseconds: u16) -> (Object, Value) {
    (Object::new(0x1017, 0), Value::u16(milliseconds))
}

/// Makes a node watch another one's heartbeat (0x1016): silence of so many ms is an error to it.
pub fn consume_heartbeat(of: Node, milliseconds: u16) -> (Object, Value) {
    (Object::new(0x1016, 1), Value::u32(u32::from(of) << 16 | u32::from(milliseconds)))
}

/// Which bits must come back when an object that was written is read: of a PDO's COB-ID not those that a node may set itself.
pub fn read_back_mask(object: Object) -> u32 {
    match (object.index, object.subindex) {
        (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => PDO_OFF | 0x7FF,
        _ => u32::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pdo_is_mapped_in_the_order_of_the_standard() {
        let entries = [(Object::new(0x6041, 0), Width::Bits16), (Object::new(0x6064, 0), Width::Bits32)];
        let expected = [
            (0x1800, 1, 0xC000_0181, 4),
            (0x1A00, 0, 0, 1),
            (0x1A00, 1, 0x6041_0010, 4),
            (0x1A00, 2, 0x6064_0020, 4),
            (0x1A00, 0, 2, 1),
            (0x1800, 2, 1, 1),
            (0x1800, 1, 0x4000_0181, 4),
        ];
        let writes = map_pdo(Direction::Transmit, 0x181, &entries);
        let flat: Vec<_> =
            writes.iter().map(|(o, v)| (o.index, o.subindex, v.bits, v.width.bytes())).collect();
        assert_eq!(flat, expected);
        let receive = map_pdo(Direction::Receive, 0x201, &[DUMMY_16]);
        assert_eq!(receive[0], (Object::new(0x1400, 1), Value::u32(0x8000_0201)));
        assert_eq!(receive[2], (Object::new(0x1600, 1), Value::u32(0x0003_0010)));
    }

    #[test]
    fn heartbeats_are_set_up() {
        assert_eq!(produce_heartbeat(100), (Object::new(0x1017, 0), Value::u16(100)));
        assert_eq!(consume_heartbeat(127, 250), (Object::new(0x1016, 1), Value::u32(0x007F_00FA)));
    }
}
