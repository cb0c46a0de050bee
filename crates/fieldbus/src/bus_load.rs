//! How much of each bus a cycle takes, at worst.

use thiserror::Error;

use super::config::Config;

/// Bits of a classic frame with an 11-bit identifier and `bytes` of data, with as many stuffed bits as there can be and the
/// space to the next frame: 44 + 8n, of which 34 + 8n may be stuffed after every fourth, and 3 bits of space.
pub fn worst_case_bits(bytes: usize) -> u32 {
    let data = 8 * bytes as u32;
    44 + data + (34 + data - 1) / 4 + 3
}

/// What a cycle puts on a bus.
#[derive(Clone, Debug, PartialEq)]
pub struct BusLoad {
    /// Its name.
    pub bus: String,
    /// Frames a cycle.
    pub frames: usize,
    /// Bits a cycle, at worst.
    pub bits: u32,
    /// Share of the bus.
    pub load: f64,
    /// The highest whole rate at which the share stays within the one allowed, Hz.
    pub highest_rate: u32,
}

/// A rate that does not fit.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "rate = {rate:.0} Hz does not fit on {}: a cycle is {} frames, {} bits with worst-case stuffing, and would take {:.1} % of \
     {bit_rate} bit/s; {:.0} % is allowed (largest_load). The highest rate that fits is {} Hz",
    .load.bus, .load.frames, .load.bits, 100.0 * .load.load, 100.0 * .largest_load, .load.highest_rate
)]
pub struct DoesNotFit {
    /// Hz.
    pub rate: f64,
    /// bit/s.
    pub bit_rate: f64,
    /// Share that is allowed.
    pub largest_load: f64,
    /// The bus.
    pub load: BusLoad,
}

/// Lengths of the frames of a cycle on each bus: SYNC, torques, drives, load cells. Heartbeats, emergencies and service data are not
/// of the cycle ([`beside_the_cycle`]); the share that `largest_load` leaves free is theirs.
pub fn cycle_frames(config: &Config) -> Vec<Vec<usize>> {
    let mut frames = vec![vec![0]; config.buses.len()];
    for (bus, _, slots) in config.torque_frames() {
        frames[bus].push(torque_frame_bytes(&slots));
    }
    for drive in &config.drives {
        frames[drive.bus].push(8);
    }
    for (i, cell) in config.load_cells.iter().enumerate() {
        let end = cell.byte + cell.cell.encoding.width().bytes();
        if !config.load_cells[i + 1..].iter().any(|other| other.node == cell.node) {
            frames[cell.bus].push(end);
        }
    }
    frames
}

/// Control word and torques up to the last slot in use.
pub(super) fn torque_frame_bytes(slots: &[Option<usize>; 3]) -> usize {
    2 + 2 * slots.iter().rposition(Option::is_some).map_or(0, |last| last + 1)
}

/// The load of each bus.
pub fn bus_loads(config: &Config) -> Vec<BusLoad> {
    let of_bus = |(bus, frames): (&super::config::Bus, Vec<usize>)| {
        let bits = frames.iter().map(|bytes| worst_case_bits(*bytes)).sum::<u32>();
        let load = f64::from(bits) * 1e9 / config.period as f64 / bus.bit_rate;
        let highest_rate = (config.largest_load * bus.bit_rate / f64::from(bits)).floor() as u32;
        BusLoad { bus: bus.name.clone(), frames: frames.len(), bits, load, highest_rate }
    };
    config.buses.iter().zip(cycle_frames(config)).map(of_bus).collect()
}

/// What comes beside the frames of a cycle, as a share of each bus: heartbeats of bridge and nodes, and with each of the bridge's one question to
/// a drive for its mode, with its answer.
pub fn beside_the_cycle(config: &Config) -> Vec<f64> {
    let of_bus = |(k, bus): (usize, &super::config::Bus)| {
        let drives = config.drives.iter().filter(|drive| drive.bus == k).count();
        let mut nodes: Vec<_> =
            config.load_cells.iter().filter(|cell| cell.bus == k).map(|cell| cell.node).collect();
        nodes.dedup();
        let heartbeats = (1 + drives + nodes.len()) as f64 * f64::from(worst_case_bits(1));
        let questions = 2.0 * f64::from(worst_case_bits(8)) * drives as f64 / config.drives.len() as f64;
        (heartbeats + questions) * 1e9 / config.heartbeat.period as f64 / bus.bit_rate
    };
    config.buses.iter().enumerate().map(of_bus).collect()
}

/// The load of each bus, if all stay within the share allowed.
///
/// # Errors
/// [`DoesNotFit`], for the first bus that does not.
pub fn check(config: &Config) -> Result<Vec<BusLoad>, DoesNotFit> {
    let loads = bus_loads(config);
    match loads.iter().position(|bus| bus.load > config.largest_load) {
        None => Ok(loads),
        Some(k) => Err(DoesNotFit {
            rate: 1e9 / config.period as f64,
            bit_rate: config.buses[k].bit_rate,
            largest_load: config.largest_load,
            load: loads[k].clone(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::{AKD, parse};

    fn packed() -> Config {
        let mut text = AKD.to_owned();
        for (node, (id, slot)) in
            (1..).zip([("0x201", 1), ("0x201", 2), ("0x201", 3), ("0x204", 1), ("0x204", 2), ("0x204", 3)])
        {
            let line = format!("node = {node}\ngear");
            text = text.replace(
                &line,
                &format!("node = {node}\ntorque_frame = {{ id = {id}, slot = {slot} }}\ngear"),
            );
        }
        for (cell, (node, channel)) in (11..).zip([(11, 1), (11, 2), (11, 3), (14, 1), (14, 2), (14, 3)]) {
            let reading = |node, channel| format!("node = {node}\nindex = 0x6130\nsubindex = {channel}\n");
            text = text.replace(&reading(cell, 1), &reading(node, channel));
        }
        parse(&text.replace("\"f32\"", "\"i16\"")).unwrap()
    }

    #[test]
    fn one_frame() {
        assert_eq!([0, 4, 6, 8].map(worst_case_bits), [55, 95, 115, 135]);
    }

    #[test]
    fn a_frame_for_every_drive_and_cell_allows_349_hz() {
        let load = &check(&parse(AKD).unwrap()).unwrap()[0];
        assert_eq!((load.frames, load.bits, load.highest_rate), (19, 2005, 349));
        assert!((load.load - 0.50125).abs() < 1e-12);
    }

    #[test]
    fn heartbeats_and_questions_for_the_mode_come_on_top() {
        let beside = beside_the_cycle(&parse(AKD).unwrap());
        // 13 heartbeats of 65 bits, a question and its answer of 135 each, in 20 ms.
        assert!((beside[0] - (13.0 * 65.0 + 2.0 * 135.0) / 0.02 / 1e6).abs() < 1e-12, "{beside:?}");
    }

    #[test]
    fn shared_frames_allow_more() {
        // The readings of three cells are 6 bytes: two frames of 115 bits; two torque frames of 135.
        let load = &bus_loads(&packed())[0];
        assert_eq!((load.frames, load.bits, load.highest_rate), (11, 1365, 512));
    }

    #[test]
    fn a_kilohertz_is_refused_with_the_reckoning() {
        let text = AKD.replacen("rate = 250.0", "rate = 1000.0", 1);
        let error = check(&parse(&text).unwrap()).unwrap_err().to_string();
        assert_eq!(
            error,
            "rate = 1000 Hz does not fit on can0: a cycle is 19 frames, 2005 bits with worst-case stuffing, and would take 200.5 % of \
             1000000 bit/s; 70 % is allowed (largest_load). The highest rate that fits is 349 Hz"
        );
    }
}
