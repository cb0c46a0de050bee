//! The adapter's end of an slcan link, which sends back every frame; `fmpy-tests/test_slcan.py` plays the program with
//! python-can.
#![cfg(target_os = "linux")]

use cable_robot_fieldbus::transport::{LinkError, Transport, now, pseudo_terminal};

#[test]
#[ignore = "fmpy-tests/test_slcan.py runs it"]
fn echo_until_hang_up() {
    let (mut adapter, device) = pseudo_terminal().unwrap();
    println!("device {}", device.display());
    loop {
        match adapter.receive(now() + 60_000_000_000) {
            Ok(Some(received)) => adapter.send(&received.frame).unwrap(),
            Ok(None) => panic!("nothing came for a minute"),
            Err(error) => return assert_eq!(error, LinkError::Removed),
        }
    }
}
