//! slcan over pseudo-terminals and TCP, in both directions.

use std::io::{Read, Write};
use std::net::TcpListener;

use super::*;
use crate::transport::open;

const SECOND: Nanoseconds = 1_000_000_000;

fn receive(link: &mut (impl Transport + ?Sized)) -> Frame {
    link.receive(now() + 10 * SECOND).unwrap().expect("a frame").frame
}

/// A link through a pseudo-terminal: the adapter's end and the program's.
fn pair(filters: &[Filter]) -> (impl Transport, Box<dyn Transport>) {
    let (adapter, path) = pseudo_terminal().unwrap();
    let program = open(&format!("slcan:{}", path.display()), 1_000_000, filters).unwrap();
    (adapter, program)
}

/// A numbered frame, of every length in turn.
fn numbered(k: u16) -> Frame {
    let bytes = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (k >> (i % 2 * 8)) as u8 ^ i as u8);
    Frame::new(crate::frame::FrameKind::Data, k % 0x800, &bytes[..usize::from(k % 9)]).unwrap()
}

/// Sends 2,000 frames each way, a cycle's worth at a time; each must come once, in order.
fn exchange(a: &mut (impl Transport + ?Sized), b: &mut (impl Transport + ?Sized)) {
    let mut latest = 0;
    for k in (0..2000).step_by(8) {
        (k..k + 8).for_each(|k| a.send(&numbered(k)).unwrap());
        for k in k..k + 8 {
            let received = b.receive(now() + 10 * SECOND).unwrap().expect("a frame");
            assert_eq!(received.frame, numbered(k));
            assert!(latest <= received.time && received.time <= now());
            latest = received.time;
            b.send(&received.frame).unwrap();
        }
        (k..k + 8).for_each(|k| assert_eq!(receive(a), numbered(k)));
    }
    assert_eq!((a.receive(0), b.receive(0)), (Ok(None), Ok(None)));
}

#[test]
fn two_thousand_frames_pass_a_pseudo_terminal_both_ways() {
    let (mut adapter, mut program) = pair(&[]);
    exchange(&mut adapter, program.as_mut());
    exchange(program.as_mut(), &mut adapter);
}

#[test]
fn two_thousand_frames_pass_tcp_both_ways() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("slcan:tcp://{}", listener.local_addr().unwrap());
    let mut program = open(&address, 1_000_000, &[]).unwrap();
    let (stream, _) = listener.accept().unwrap();
    stream.set_nodelay(true).unwrap();
    stream.set_nonblocking(true).unwrap();
    let mut adapter = SerialLine::new(stream.into(), MOST_WAITING_TCP, &[]);
    exchange(&mut adapter, program.as_mut());
    exchange(program.as_mut(), &mut adapter);
}

#[test]
fn an_adapter_is_given_its_bit_rate_opened_and_closed() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("slcan:tcp://{}", listener.local_addr().unwrap());
    drop(open(&address, 500_000, &[]).unwrap());
    let mut said = String::new();
    listener.accept().unwrap().0.read_to_string(&mut said).unwrap();
    assert_eq!(said, "\rC\rS6\rO\rC\r");
}

#[test]
fn unwanted_frames_are_passed_over() {
    let (mut adapter, mut program) = pair(&[Filter { id: 0x180, mask: 0x780 }]);
    adapter.send(&Frame::data(0x701, [5])).unwrap();
    adapter.send(&Frame::data(0x181, [1])).unwrap();
    assert_eq!(receive(program.as_mut()), Frame::data(0x181, [1]));
    assert_eq!(program.receive(0), Ok(None));
}

#[test]
fn a_babbling_adapter_holds_nobody_up() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("slcan:tcp://{}", listener.local_addr().unwrap());
    let mut program = open(&address, 1_000_000, &[]).unwrap();
    let (mut stream, _) = listener.accept().unwrap();
    let babble = std::thread::spawn(move || while stream.write_all(&[b'x'; 4096]).is_ok() {});
    for _ in 0..100 {
        assert_eq!(program.receive(now() + 1_000_000), Ok(None));
    }
    drop(program);
    babble.join().unwrap();
}

#[test]
fn a_hang_up_is_a_link_removed() {
    let (adapter, mut program) = pair(&[]);
    drop(adapter);
    assert_eq!(program.receive(now() + SECOND), Err(LinkError::Removed));
    assert_eq!(program.send(&Frame::data(0x80, [])), Err(LinkError::Removed));

    let (mut adapter, program) = pair(&[]);
    drop(program);
    assert_eq!(adapter.receive(now() + SECOND), Err(LinkError::Removed));

    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("slcan:tcp://{}", listener.local_addr().unwrap());
    let mut program = open(&address, 1_000_000, &[]).unwrap();
    drop(listener.accept().unwrap());
    assert_eq!(program.receive(now() + SECOND), Err(LinkError::Removed));
}

#[test]
fn two_programs_cannot_open_one_adapter() {
    let (_adapter, path) = pseudo_terminal().unwrap();
    let address = format!("slcan:{}", path.display());
    let _first = open(&address, 1_000_000, &[]).unwrap();
    let error = open(&address, 1_000_000, &[]).err().unwrap().to_string();
    assert!(error.contains("another program uses it"), "{error}");
}

/// Nobody reads; then somebody does. What was refused never comes, what was sent before comes whole and in order.
fn fill_and_empty(program: &mut SerialLine, adapter: &mut impl Transport) {
    let mut sent = vec![];
    let refused = loop {
        let frame = Frame::data(0x201, (sent.len() as u32).to_le_bytes());
        match program.send(&frame) {
            Ok(()) => sent.push(frame),
            Err(error) => break error,
        }
        assert!(sent.len() < 2_000_000, "no end to what the link takes");
    };
    assert_eq!(refused, LinkError::BufferFull);
    assert!(waiting(&program.link).unwrap() <= program.most_waiting);
    for frame in &sent {
        assert_eq!(receive(adapter), *frame);
    }
    assert_eq!(adapter.receive(0), Ok(None), "the frame after {} was refused and must not come", sent.len());
    let newest = Frame::data(0x201, [0xFF; 4]);
    program.send(&newest).unwrap();
    assert_eq!(receive(adapter), newest);
}

#[test]
fn a_full_connection_refuses_the_frame_and_forgets_it() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let mut program = SerialLine::open("", &Address::Tcp(&address), *b"S8\r", &[]).unwrap();
    let stream = listener.accept().unwrap().0;
    stream.set_nonblocking(true).unwrap();
    fill_and_empty(&mut program, &mut SerialLine::new(stream.into(), MOST_WAITING_TCP, &[]));
}

#[test]
fn a_full_pseudo_terminal_refuses_the_frame_and_forgets_it() {
    let (mut adapter, path) = pseudo_terminal().unwrap();
    let device = Address::Device(path.to_str().unwrap(), 115_200);
    fill_and_empty(&mut SerialLine::open("", &device, *b"S8\r", &[]).unwrap(), &mut adapter);
}
