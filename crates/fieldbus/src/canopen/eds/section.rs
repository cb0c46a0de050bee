//! The section of an object in a data sheet.

use configparser::ini::Ini;

use super::{Access, EdsError, Entry};

/// Index and sub-index of an object's section, such as `6071` or `1018sub4`, in small letters.
pub fn place(section: &str) -> Option<(u16, u8)> {
    let (index, sub) = section.split_once("sub").unwrap_or((section, "0"));
    let is_index = index.len() == 4 && index.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_index.then(|| Some((u16::from_str_radix(index, 16).ok()?, u8::from_str_radix(sub, 16).ok()?)))?
}

/// Of an object.
pub struct Section<'a> {
    pub ini: &'a Ini,
    /// In small letters.
    pub name: &'a str,
}

impl Section<'_> {
    fn get(&self, key: &str) -> Option<String> {
        self.ini.get(self.name, key).map(|value| value.trim().to_owned()).filter(|value| !value.is_empty())
    }

    /// `None` of an array or a record, whose values have sections of their own.
    pub fn entry(&self) -> Result<Option<Entry>, EdsError> {
        let Some(data_type) = self.number("DataType")? else { return Ok(None) };
        Ok(Some(Entry {
            name: self.get("parametername").unwrap_or_default(),
            data_type: u16::try_from(data_type).unwrap_or(u16::MAX),
            access: self.access()?,
            is_mappable: self.number("PDOMapping")?.unwrap_or(0) != 0,
            // A limit may be said relative to the node's address.
            least: self.number("LowLimit").unwrap_or(None),
            greatest: self.number("HighLimit").unwrap_or(None),
        }))
    }

    /// Sub-indices of the values of an array that is written in one section.
    pub fn compact(&self) -> Result<std::ops::RangeInclusive<u8>, EdsError> {
        let count = self.number("CompactSubObj")?.unwrap_or(0);
        Ok(1..=count.clamp(0, 254) as u8)
    }

    fn access(&self) -> Result<Access, EdsError> {
        let Some(text) = self.get("accesstype") else { return Ok(Access::Both) };
        Ok(match text.to_lowercase().as_str() {
            "ro" | "const" => Access::ReadOnly,
            "wo" => Access::WriteOnly,
            "rw" => Access::Both,
            "rwr" => Access::BothSent,
            "rww" => Access::BothReceived,
            _ => return Err(self.wrong("AccessType", text, "ro, wo, rw, rwr, rww or const")),
        })
    }

    /// Decimal, 0x hexadecimal or 0 octal.
    fn number(&self, key: &'static str) -> Result<Option<i64>, EdsError> {
        let Some(text) = self.get(&key.to_lowercase()) else { return Ok(None) };
        let small = text.to_lowercase();
        let (is_negative, digits) = small.strip_prefix('-').map_or((false, &*small), |rest| (true, rest));
        let found = match (digits.strip_prefix("0x"), digits.strip_prefix('0')) {
            (Some(hexadecimal), _) => i64::from_str_radix(hexadecimal, 16),
            (None, Some(octal)) if !octal.is_empty() => i64::from_str_radix(octal, 8),
            _ => digits.parse(),
        };
        match found {
            Ok(number) => Ok(Some(if is_negative { -number } else { number })),
            Err(_) => Err(self.wrong(key, text, "a number, decimal or 0x and hexadecimal")),
        }
    }

    fn wrong(&self, key: &'static str, value: String, expected: &'static str) -> EdsError {
        EdsError::Value { section: self.name.to_owned(), key, value, expected }
    }
}
