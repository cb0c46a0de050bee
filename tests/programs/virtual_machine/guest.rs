//! What runs inside the virtual machine, where `vcan0` is a CAN bus.

use std::process::Command;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use cable_robot_fieldbus::Nanoseconds;
use cable_robot_fieldbus::frame::{Frame, FrameKind, error_class};
use cable_robot_fieldbus::transport::{Filter, LinkError, Transport, now, open, pseudo_terminal};

use crate::counting_allocator::CALLS;

const SECOND: Nanoseconds = 1_000_000_000;

pub fn shell(command: &str) {
    let status = Command::new("sh").args(["-c", command]).status().unwrap();
    assert!(status.success(), "{command}: {status}");
}

/// A bus of its own for a test, and a link to it.
pub fn bus(name: &str) -> Box<dyn Transport> {
    shell(&format!("ip link add dev {name} type vcan && ip link set up {name}"));
    link(name)
}

pub fn link(name: &str) -> Box<dyn Transport> {
    open(name, 1_000_000, &[]).unwrap()
}

fn receive(link: &mut Box<dyn Transport>) -> Frame {
    link.receive(now() + 10 * SECOND).unwrap().expect("a frame").frame
}

/// Everything that has arrived.
fn drain(link: &mut Box<dyn Transport>) -> Vec<Frame> {
    std::iter::from_fn(|| link.receive(0).unwrap()).map(|received| received.frame).collect()
}

fn numbered(k: u32) -> Frame {
    Frame::data(0x201, k.to_le_bytes())
}

#[test]
#[ignore = "runs in the virtual machine"]
fn a_thousand_of_a_thousand_frames_are_echoed() {
    let (mut a, mut b) = (bus("echo0"), link("echo0"));
    let mut latest = now();
    let allocations = CALLS.get();
    for k in (0..1000).step_by(8) {
        (k..k + 8).for_each(|k| a.send(&numbered(k)).unwrap());
        for k in k..k + 8 {
            let received = b.receive(now() + 10 * SECOND).unwrap().expect("a frame");
            assert_eq!(received.frame, numbered(k));
            assert!(latest <= received.time && received.time <= now(), "{latest} {}", received.time);
            latest = received.time;
            b.send(&received.frame).unwrap();
            assert_eq!(receive(&mut a), numbered(k));
        }
    }
    assert_eq!((a.receive(0), b.receive(0)), (Ok(None), Ok(None)));
    assert_eq!(CALLS.get(), allocations);
}

#[test]
#[ignore = "runs in the virtual machine"]
fn arrival_is_when_the_kernel_saw_the_frame_and_the_wall_clock_may_be_set() {
    let (mut a, mut read_at_once, mut read_late) = (bus("time0"), link("time0"), link("time0"));
    // The kernel begins to stamp frames a little after it was asked to.
    shell("sleep 0.3");
    let mut latest = 0;
    let restore = format!("date -s @{}", SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs());
    for set_clock in ["sleep 0.2", "date -s 2040-01-01", "date -s 2020-01-01", &restore] {
        // Two clocks are never read at one instant; hence some room on either side.
        let before = now();
        shell("sleep 0.02");
        a.send(&numbered(1)).unwrap();
        receive(&mut read_at_once);
        shell("sleep 0.02");
        let after = now();
        shell(&format!("{set_clock} > /dev/null"));
        let time = read_late.receive(0).unwrap().expect("a frame").time;
        if set_clock.starts_with("sleep") {
            assert!((before..=after).contains(&time), "{before} {time} {after}");
        }
        // After a step the age is unknown: the frame is taken to be as old as it can be, or as new.
        assert!(latest <= time && time <= now(), "{latest} {time}");
        latest = time;
    }
}

#[test]
#[ignore = "runs in the virtual machine"]
fn a_report_of_bus_off_is_a_frame() {
    let mut a = bus("off0");
    shell("cansend off0 20000040#0004000000000000");
    let frame = receive(&mut a);
    assert_eq!((frame.kind(), frame.id()), (FrameKind::Error, error_class::BUS_OFF));
    assert_eq!(a.send(&frame), Err(LinkError::ErrorFrame));
}

#[test]
#[ignore = "runs in the virtual machine"]
fn only_wanted_frames_are_received() {
    let mut all = bus("filter0");
    let mut some = open("filter0", 1_000_000, &[Filter { id: 0x180, mask: 0x780 }]).unwrap();
    for frame in ["00000181#01", "201#02", "181#03", "1FF#R4"] {
        shell(&format!("cansend filter0 {frame}"));
    }
    let wanted = [Frame::data(0x181, [3]), Frame::remote(0x1FF, 4).unwrap()];
    assert_eq!(drain(&mut some), wanted);
    assert_eq!(drain(&mut all), [&[Frame::data(0x201, [2])][..], &wanted].concat());
}

#[test]
#[ignore = "runs in the virtual machine"]
fn some_frames_are_lost_on_a_bus_that_loses_some() {
    let (mut a, mut b) = (bus("loss0"), link("loss0"));
    shell("tc qdisc add dev loss0 root netem loss 50%");
    let mut received = vec![];
    for k in 0..400 {
        a.send(&numbered(k)).unwrap();
        received.extend(drain(&mut b));
    }
    assert!((1..400).contains(&received.len()), "{} of 400", received.len());
    assert!(received.is_sorted_by_key(|frame| frame.array::<4>(0).map(u32::from_le_bytes)));
}

/// A bus of 500 frames a second, offered more, with room for `room` bytes (16 a frame) in its queue; the most frames that
/// were ever under way.
fn most_under_way(name: &str, room: u32) -> usize {
    let (mut a, mut b) = (bus(name), link(name));
    shell(&format!("tc qdisc add dev {name} root tbf rate 64kbit burst 32 limit {room}"));
    let (mut accepted, mut received, mut most) = (vec![], vec![], 0);
    let mut refused = 0;
    while accepted.len() < 60 {
        let frame = numbered(accepted.len() as u32 + refused);
        match a.send(&frame) {
            Ok(()) => accepted.push(frame),
            Err(error) => {
                assert_eq!(error, LinkError::BufferFull);
                refused += 1;
                std::thread::sleep(Duration::from_micros(500));
            }
        }
        received.extend(drain(&mut b));
        most = most.max(accepted.len() - received.len());
    }
    while received.len() < accepted.len() {
        received.push(receive(&mut b));
    }
    assert!(refused > 0);
    assert_eq!(received, accepted, "what was refused must never come");
    assert_eq!(b.receive(now() + SECOND / 10), Ok(None));
    let newest = numbered(u32::MAX);
    a.send(&newest).unwrap();
    assert_eq!(receive(&mut b), newest);
    println!("{name}: {} accepted, {refused} refused, at most {most} under way", accepted.len());
    most
}

#[test]
#[ignore = "runs in the virtual machine"]
fn a_full_queue_of_the_interface_refuses_the_frame_and_forgets_it() {
    let most = most_under_way("queue0", 64);
    assert!((4..=8).contains(&most), "{most}");
}

#[test]
#[ignore = "runs in the virtual machine"]
fn however_long_the_queue_of_the_interface_few_frames_wait() {
    let most = most_under_way("long0", 1_000_000);
    assert!((8..=20).contains(&most), "{most}");
}

#[test]
#[ignore = "runs in the virtual machine"]
fn a_link_that_is_down_says_so_and_resumes_when_it_is_up() {
    let (mut a, mut b) = (bus("down0"), link("down0"));
    shell("ip link set down down0");
    assert_eq!(a.receive(now() + 10 * SECOND), Err(LinkError::Down));
    assert_eq!(a.send(&numbered(1)), Err(LinkError::Down));
    let error = open("down0", 1_000_000, &[]).err().unwrap().to_string();
    assert!(error.contains("ip link set down0 up type can"), "{error}");
    assert_eq!(b.receive(0), Err(LinkError::Down));

    shell("ip link set up down0");
    assert_eq!((a.receive(0), b.receive(0)), (Ok(None), Ok(None)), "nothing from before");
    a.send(&numbered(2)).unwrap();
    assert_eq!(receive(&mut b), numbered(2));
}

#[test]
#[ignore = "runs in the virtual machine"]
fn a_link_that_was_removed_says_so() {
    let (mut a, mut b) = (bus("gone0"), link("gone0"));
    shell("ip link delete gone0");
    assert_eq!(b.send(&numbered(1)), Err(LinkError::Removed));
    let mut said = vec![];
    while let Err(error) = a.receive(now() + SECOND / 10) {
        said.push(error);
    }
    assert!(said.contains(&LinkError::Removed), "{said:?}");
    assert_eq!(a.send(&numbered(1)), Err(LinkError::Removed));
    let error = open("gone0", 1_000_000, &[]).err().unwrap().to_string();
    assert!(error.contains("No such device") && error.contains("the CAN interfaces here are "), "{error}");
    assert!(error.contains("vcan0"), "{error}");
}

/// The kernel's own slcan is the other end: an adapter on a pseudo-terminal becomes an interface.
#[test]
#[ignore = "runs in the virtual machine"]
fn slcan_agrees_with_the_kernel() {
    let (mut adapter, device) = pseudo_terminal().unwrap();
    shell(&format!("slcand -o -s8 {} slcan0 && sleep 0.5 && ip link set up slcan0", device.display()));
    let mut interface = link("slcan0");
    for k in 0..200 {
        adapter.send(&numbered(k)).unwrap();
        assert_eq!(receive(&mut interface), numbered(k));
        interface.send(&numbered(k + 1)).unwrap();
        assert_eq!(adapter.receive(now() + 10 * SECOND).unwrap().unwrap().frame, numbered(k + 1));
    }
}
