#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| cable_robot_fuzz::fieldbus_file(data));
