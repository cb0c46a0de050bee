//! Frames as the ASCII protocol of serial CAN adapters (slcan, LAWICEL): `t1812` + data + carriage return.

use super::frame::{Frame, FrameKind, hex, hex_bytes};

/// Longest command that is understood: a 29-bit frame with a time stamp.
const LONGEST: usize = 32;

/// An encoded frame: at most 22 bytes, on the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoded {
    bytes: [u8; 22],
    length: usize,
}

impl Encoded {
    /// What to send.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    fn push(&mut self, byte: u8) {
        self.bytes[self.length] = byte;
        self.length += 1;
    }

    fn push_hex(&mut self, value: u16, digits: u32) {
        for k in (0..digits).rev() {
            self.push(b"0123456789ABCDEF"[usize::from(value >> (4 * k) & 0xF)]);
        }
    }
}

/// Writes a frame; `None` for an error report, which the protocol cannot carry.
pub fn encode(frame: &Frame) -> Option<Encoded> {
    let mut encoded = Encoded { bytes: [0; 22], length: 0 };
    encoded.push(match frame.kind() {
        FrameKind::Data => b't',
        FrameKind::Remote => b'r',
        FrameKind::Error => return None,
    });
    encoded.push_hex(frame.id(), 3);
    encoded.push_hex(frame.length() as u16, 1);
    frame.bytes().iter().for_each(|byte| encoded.push_hex((*byte).into(), 2));
    encoded.push(b'\r');
    Some(encoded)
}

/// What a command without its carriage return is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A frame from the bus.
    Frame(Frame),
    /// Something else that is no mistake: an answer, another command, a frame with a 29-bit identifier.
    Other,
    /// No such command, or longer than any.
    Garbled,
}

/// Reads a command without its carriage return. A time stamp of four digits after a frame is passed over.
pub fn decode(command: &[u8]) -> Received {
    let frame = match command {
        [b't', rest @ ..] => decode_frame(FrameKind::Data, rest),
        [b'r', rest @ ..] => decode_frame(FrameKind::Remote, rest),
        []
        | [b'T' | b'R' | b'z' | b'Z' | b'O' | b'L' | b'C' | b'S' | b'F' | b'V' | b'N' | b'M' | b'm', ..] => {
            return Received::Other;
        }
        _ => None,
    };
    frame.map_or(Received::Garbled, Received::Frame)
}

fn decode_frame(kind: FrameKind, rest: &[u8]) -> Option<Frame> {
    let id = hex::<3>(rest.get(..3)?)? as u16;
    let length = hex::<1>(rest.get(3..4)?)? as usize;
    let digits = if kind == FrameKind::Remote { 0 } else { 2 * length };
    let (data, stamp) = rest[4..].split_at_checked(digits)?;
    if !(stamp.is_empty() || hex::<4>(stamp).is_some()) {
        return None;
    }
    match kind {
        FrameKind::Remote => Frame::remote(id, length as u8),
        _ => Frame::new(kind, id, hex_bytes(data, &mut [0; 8])?),
    }
}

/// Puts commands together from a stream of bytes, however it is cut.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    command: [u8; LONGEST],
    length: usize,
    overflowed: bool,
}

impl Decoder {
    /// Takes in the next byte; tells of a command when it ends.
    pub fn push(&mut self, byte: u8) -> Option<Received> {
        match byte {
            b'\r' => {
                let received =
                    if self.overflowed { Received::Garbled } else { decode(&self.command[..self.length]) };
                (self.length, self.overflowed) = (0, false);
                Some(received)
            }
            // The adapter's answer "no".
            0x07 => {
                (self.length, self.overflowed) = (0, false);
                Some(Received::Other)
            }
            _ if self.length == LONGEST => {
                self.overflowed = true;
                None
            }
            _ => {
                self.command[self.length] = byte;
                self.length += 1;
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(stream: &[u8]) -> Vec<Received> {
        let mut decoder = Decoder::default();
        stream.iter().filter_map(|byte| decoder.push(*byte)).collect()
    }

    #[test]
    fn frames_come_back_as_they_were_written() {
        let frames_in = [
            Frame::data(0x181, [0x00, 0x11]),
            Frame::data(0x80, []),
            Frame::data(0x7FF, [0xFF; 8]),
            Frame::remote(0x701, 1).unwrap(),
        ];
        assert_eq!(encode(&frames_in[0]).unwrap().as_bytes(), b"t18120011\r");
        assert_eq!(encode(&frames_in[3]).unwrap().as_bytes(), b"r7011\r");
        let stream: Vec<u8> = frames_in.iter().flat_map(|f| encode(f).unwrap().as_bytes().to_vec()).collect();
        assert_eq!(frames(&stream), frames_in.map(Received::Frame));
    }

    #[test]
    fn answers_time_stamps_and_extended_frames_do_no_harm() {
        let frame = Received::Frame(Frame::data(0x181, [0xAB]));
        let stream = b"\rz\r\x07t1811ab\rt1811AB12f0\rT0000018112233\rt1811AB12\r";
        let expected = [
            Received::Other,
            Received::Other,
            Received::Other,
            frame,
            frame,
            Received::Other,
            Received::Garbled,
        ];
        assert_eq!(frames(stream), expected);
    }

    #[test]
    fn garbage_of_any_length_is_followed_by_the_next_frame() {
        let mut stream = vec![b't'; 1000];
        stream.extend(b"\rt18\rt1819\rt8001AA\rt18110\xFF\rt1810\r");
        let mut expected = vec![Received::Garbled; 5];
        expected.push(Received::Frame(Frame::data(0x181, [])));
        assert_eq!(frames(&stream), expected);
    }

    #[test]
    fn no_bytes_make_the_parsers_panic() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        let mut decoder = Decoder::default();
        for _ in 0..200_000 {
            let alphabet = b"tr0123456789abcdefABCDEFG\r\x07#R(.) \xFF";
            let byte = alphabet[random.random_range(0..alphabet.len())];
            decoder.push(byte);
        }
        for _ in 0..50_000 {
            let alphabet = b"(1.0) can0 181#R89AF";
            let text: String = (0..random.random_range(0..40))
                .map(|_| char::from(alphabet[random.random_range(0..alphabet.len())]))
                .collect();
            let _ = crate::candump::Line::parse(&text);
        }
    }
}
