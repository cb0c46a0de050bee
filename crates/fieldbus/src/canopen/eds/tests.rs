//! A small sheet: what it has, what it lacks, what is none.

use super::*;

const SHEET: &str = "\
[DeviceInfo]
VendorName=Works
ProductName=Drive 7
[1016]
ParameterName=Consumer heartbeat time
ObjectType=0x8
CompactSubObj=2
DataType=0x0007
AccessType=rw
[6040] ; control word
ParameterName=Controlword
ObjectType=0x7
DataType=0x0006
AccessType=rww
PDOMapping=1
[6060]
ParameterName=Modes of operation
DataType=0x0002
AccessType=rw
LowLimit=-128
HighLimit=8
PDOMapping=0
[6064]
ParameterName=Position
DataType=0x0004
AccessType=ro
PDOMapping=1
[1018]
ParameterName=Identity
ObjectType=0x9
SubNumber=2
[1018sub1]
ParameterName=Vendor
DataType=0x0007
AccessType=ro
";

fn lack(object: u16, sub: u8, what: Use) -> String {
    let lack = DataSheet::parse(SHEET).unwrap().lack(Object::new(object, sub), what);
    lack.map(|lack| lack.to_string()).unwrap_or_default()
}

#[test]
fn what_a_sheet_has_is_not_lacked() {
    use Direction::{Receive, Transmit};
    assert_eq!(DataSheet::parse(SHEET).unwrap().product, "Works Drive 7");
    for (object, sub, what) in [
        (0x1016, 2, Use::Write(Value::u32(0x007F_0064))),
        (0x1018, 1, Use::Read(Width::Bits32)),
        (0x6040, 0, Use::Map(Receive, Width::Bits16)),
        (0x6064, 0, Use::Map(Transmit, Width::Bits32)),
        (0x6060, 0, Use::Write(Value::u8(0xFF))),
        (0x0003, 0, Use::Map(Receive, Width::Bits16)),
    ] {
        assert_eq!(lack(object, sub, what), "", "{object:04X}:{sub}");
    }
}

#[test]
fn what_a_sheet_lacks_is_named_with_why() {
    use Direction::{Receive, Transmit};
    let not_sent =
        "0x6040:0 (Controlword) cannot be mapped to a PDO that the node sends (PDOMapping, AccessType)";
    for (object, sub, what, expected) in [
        (0x6071, 0, Use::Read(Width::Bits16), "0x6071:0 is not in it"),
        (0x1016, 3, Use::Read(Width::Bits32), "0x1016:3 is not in it"),
        (
            0x6064,
            0,
            Use::Read(Width::Bits16),
            "0x6064:0 (Position) has the type 0x0004 (4 bytes), 2 bytes are expected",
        ),
        (0x6064, 0, Use::Write(Value::u32(1)), "0x6064:0 (Position) cannot be written (AccessType = ro)"),
        (0x6040, 0, Use::Map(Transmit, Width::Bits16), not_sent),
        (
            0x6060,
            0,
            Use::Map(Receive, Width::Bits8),
            "0x6060:0 (Modes of operation) cannot be mapped to a PDO that the node receives (PDOMapping, AccessType)",
        ),
        (
            0x6060,
            0,
            Use::Write(Value::u8(10)),
            "0x6060:0 (Modes of operation) = 10 is written, LowLimit to HighLimit is -128 to 8",
        ),
    ] {
        assert_eq!(lack(object, sub, what), expected);
    }
}

#[test]
fn what_is_no_sheet_is_refused_with_what_is_wrong() {
    for (text, expected) in [
        ("rate = 250", "it is no data sheet: a section [DeviceInfo] is expected"),
        (
            "[DeviceInfo\nx=1",
            "it is no data sheet: line 1: Found opening bracket for section name but no closing bracket",
        ),
        (
            "[DeviceInfo]\n[6040]\nDataType=six",
            "[6040] DataType = six: expected a number, decimal or 0x and hexadecimal",
        ),
        (
            "[DeviceInfo]\n[6040]\nDataType=6\nAccessType=maybe",
            "[6040] AccessType = maybe: expected ro, wo, rw, rwr, rww or const",
        ),
    ] {
        assert_eq!(DataSheet::parse(text).unwrap_err().to_string(), expected);
    }
}
