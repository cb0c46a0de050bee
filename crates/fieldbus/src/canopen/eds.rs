//! A node's electronic data sheet (EDS or DCF, CiA 306): which objects it has, and what may be done with them.

mod section;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt;

use configparser::ini::{Ini, IniDefault};
use section::{Section, place};
use thiserror::Error;

use super::object::{Direction, Object, Value, Width};

/// What is asked of an object of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Use {
    /// It is read, so many bytes.
    Read(Width),
    /// This is written to it, and read back.
    Write(Value),
    /// It is mapped to a PDO, with so many bytes.
    Map(Direction, Width),
}

impl Use {
    fn width(self) -> Width {
        match self {
            Self::Read(width) | Self::Map(_, width) => width,
            Self::Write(value) => value.width,
        }
    }
}

/// What a data sheet says of the objects of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSheet {
    /// Who makes it, and what it is called there.
    pub product: String,
    entries: BTreeMap<(u16, u8), Entry>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    name: String,
    data_type: u16,
    access: Access,
    is_mappable: bool,
    least: Option<i64>,
    greatest: Option<i64>,
}

/// `AccessType`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Access {
    ReadOnly,
    WriteOnly,
    /// Both, and mapped to PDOs of any direction,
    Both,
    /// to those that the node sends,
    BothSent,
    /// to those that it receives.
    BothReceived,
}

/// Why a text is no data sheet.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EdsError {
    /// No sections and keys.
    #[error("it is no data sheet: {0}")]
    Text(String),
    /// Another kind of file.
    #[error("it is no data sheet: a section [{0}] is expected")]
    Section(&'static str),
    /// A value that does not belong there.
    #[error("[{section}] {key} = {value}: expected {expected}")]
    Value {
        /// Where,
        section: String,
        /// which,
        key: &'static str,
        /// what stands there,
        value: String,
        /// and what may.
        expected: &'static str,
    },
}

/// Why an object cannot be used as it is to be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Lack {
    /// It is not there.
    #[error("{0} is not in it")]
    Missing(Object),
    /// It has another width.
    #[error("{place} has the type {found}, {} bytes are expected", expected.bytes())]
    Width {
        /// Which.
        place: Place,
        /// Its type.
        found: DataType,
        /// What the bridge uses.
        expected: Width,
    },
    /// It cannot be read.
    #[error("{0} cannot be read (AccessType = wo)")]
    NotRead(Place),
    /// It cannot be written.
    #[error("{0} cannot be written (AccessType = ro)")]
    NotWritten(Place),
    /// It cannot be mapped.
    #[error("{0} cannot be mapped to a PDO that the node {1} (PDOMapping, AccessType)")]
    NotMapped(Place, &'static str),
    /// What is written is not allowed.
    #[error("{place} = {value} is written, LowLimit to HighLimit is {} to {}", or_any(*least), or_any(*greatest))]
    Limits {
        /// Which.
        place: Place,
        /// What.
        value: i64,
        /// From,
        least: Option<i64>,
        /// to.
        greatest: Option<i64>,
    },
}

fn or_any(limit: Option<i64>) -> String {
    limit.map_or("any".to_owned(), |limit| limit.to_string())
}

/// An object and its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Place(Object, String);

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.0, self.1)
    }
}

/// A data type of CiA 301, by its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataType(u16);

impl DataType {
    /// In bytes; `None` for others than numbers.
    fn bytes(self) -> Option<usize> {
        match self.0 {
            0x01 | 0x02 | 0x05 => Some(1),
            0x03 | 0x06 => Some(2),
            0x10 | 0x16 => Some(3),
            0x04 | 0x07 | 0x08 => Some(4),
            0x12 | 0x18 => Some(5),
            0x13 | 0x19 => Some(6),
            0x14 | 0x1A => Some(7),
            0x11 | 0x15 | 0x1B => Some(8),
            _ => None,
        }
    }

    fn is_signed(self) -> bool {
        matches!(self.0, 0x02..=0x04 | 0x10 | 0x12..=0x15)
    }
}

impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:04X}", self.0)?;
        self.bytes().map_or(Ok(()), |bytes| write!(f, " ({bytes} bytes)"))
    }
}

impl DataSheet {
    /// From the text of a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, EdsError> {
        let mut form = IniDefault::default();
        (form.delimiters, form.comment_symbols) = (vec!['='], vec![';']);
        let mut ini = Ini::new_from_defaults(form);
        ini.read(text.to_owned()).map_err(EdsError::Text)?;
        let sections: Vec<_> = ini.sections();
        if !sections.iter().any(|section| section == "deviceinfo") {
            return Err(EdsError::Section("DeviceInfo"));
        }
        let of_device = |key| ini.get("deviceinfo", key).unwrap_or_default();
        let product = format!("{} {}", of_device("vendorname"), of_device("productname")).trim().to_owned();
        let mut entries = BTreeMap::new();
        for section in &sections {
            let Some(place) = place(section) else { continue };
            let section = Section { ini: &ini, name: section };
            if let Some(entry) = section.entry()? {
                for sub in section.compact()? {
                    entries.insert((place.0, sub), entry.clone());
                }
                entries.insert(place, entry);
            }
        }
        Ok(Self { product, entries })
    }

    /// What the sheet lacks of what is asked of its node.
    pub fn lacks(&self, needs: &[(Object, Use)]) -> Vec<Lack> {
        let mut lacks: Vec<Lack> = vec![];
        for lack in needs.iter().filter_map(|(object, what)| self.lack(*object, *what)) {
            if !lacks.contains(&lack) {
                lacks.push(lack);
            }
        }
        lacks
    }

    fn lack(&self, object: Object, what: Use) -> Option<Lack> {
        // Dummies of a mapping are data types, which sheets list elsewhere.
        if matches!(what, Use::Map(..)) && object.index < 0x20 {
            return None;
        }
        let Some(entry) = self.entries.get(&(object.index, object.subindex)) else {
            return Some(Lack::Missing(object));
        };
        let place = Place(object, entry.name.clone());
        let (found, expected) = (DataType(entry.data_type), what.width());
        if found.bytes() != Some(expected.bytes()) {
            return Some(Lack::Width { place, found, expected });
        }
        let is_read = entry.access != Access::WriteOnly;
        let is_written = entry.access != Access::ReadOnly;
        match what {
            Use::Read(_) | Use::Write(_) if !is_read => Some(Lack::NotRead(place)),
            Use::Read(_) => None,
            Use::Write(_) if !is_written => Some(Lack::NotWritten(place)),
            Use::Write(value) => {
                let value = number(value, found);
                let is_below = entry.least.is_some_and(|least| value < least);
                let is_above = entry.greatest.is_some_and(|greatest| value > greatest);
                let Entry { least, greatest, .. } = *entry;
                (is_below || is_above).then_some(Lack::Limits { place, value, least, greatest })
            }
            Use::Map(direction, _) => {
                let (is_so, does) = match direction {
                    Direction::Transmit => (is_read && entry.access != Access::BothReceived, "sends"),
                    Direction::Receive => (is_written && entry.access != Access::BothSent, "receives"),
                };
                (!is_so || !entry.is_mappable).then_some(Lack::NotMapped(place, does))
            }
        }
    }
}

fn number(value: Value, data_type: DataType) -> i64 {
    let unused = 64 - 8 * value.width.bytes() as u32;
    let bits = u64::from(value.bits) << unused;
    if data_type.is_signed() { (bits as i64) >> unused } else { (bits >> unused) as i64 }
}
