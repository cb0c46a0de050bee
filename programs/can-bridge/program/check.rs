//! What `--check` prints: the frames of a cycle, and how much of each bus they take.

use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::bus_load::{beside_the_cycle, bus_loads, worst_case_bits};
use cable_robot_fieldbus::canopen::TPDO1;
use cable_robot_report::run_folder::Model;

use super::controller::BridgeController;

/// A frame of every cycle.
struct CycleFrame {
    bus: usize,
    id: u16,
    bytes: usize,
    what: String,
}

/// Controller, frames and load.
pub fn text(config: &Config, controller: &BridgeController) -> String {
    let mut text = format!("{}\n", config.name);
    text += &match controller.info() {
        Model::Fmu { path, name, fmi_version } => {
            format!("controller: {name}, FMI {fmi_version}, {} ({})\n", path.display(), controller.identity())
        }
        Model::Library | Model::Rig => "controller: the program's own\n".to_owned(),
    };
    let rate = 1e9 / config.period as f64;
    let (frames, beside) = (frames(config), beside_the_cycle(config));
    for (k, load) in bus_loads(config).iter().enumerate() {
        text += &format!("\n{}, {} bit/s\n", load.bus, config.buses[k].bit_rate);
        for CycleFrame { id, bytes, what, .. } in frames.iter().filter(|frame| frame.bus == k) {
            text += &format!("  0x{id:03X}  {bytes} bytes  {:3} bits  {what}\n", worst_case_bits(*bytes));
        }
        text += &format!(
            "  {} frames, {} bits a cycle with worst-case stuffing: {:.1} % of the bus at {rate:.0} Hz\n  {:.0} % is allowed \
             (largest_load): the highest rate that fits is {} Hz\n  heartbeats, and questions for the drives' modes: {:.1} % on top\n",
            load.frames,
            load.bits,
            100.0 * load.load,
            100.0 * config.largest_load,
            load.highest_rate,
            100.0 * beside[k]
        );
    }
    text
}

fn frames(config: &Config) -> Vec<CycleFrame> {
    let cables = |cables: &[usize]| {
        let numbers: Vec<_> = cables.iter().map(|i| (i + 1).to_string()).collect();
        format!("{} {}", if cables.len() == 1 { "cable" } else { "cables" }, numbers.join(", "))
    };
    let frame = |bus, id, bytes, what: String| CycleFrame { bus, id, bytes, what };
    let mut frames: Vec<_> =
        (0..config.buses.len()).map(|bus| frame(bus, 0x080, 0, "SYNC".to_owned())).collect();
    for (bus, id, slots) in config.torque_frames() {
        let last = slots.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        let of: Vec<_> = slots.iter().flatten().copied().collect();
        frames.push(frame(bus, id, 2 + 2 * last, format!("control word and torque, {}", cables(&of))));
    }
    for (i, drive) in config.drives.iter().enumerate() {
        let id = TPDO1 + u16::from(drive.node);
        frames.push(frame(drive.bus, id, 8, format!("status word, encoder and torque, {}", cables(&[i]))));
    }
    let mut nodes: Vec<_> = config.load_cells.iter().map(|cell| (cell.bus, cell.node)).collect();
    nodes.dedup();
    for (bus, node) in nodes {
        let of: Vec<_> = (0..config.load_cells.len())
            .filter(|i| (config.load_cells[*i].bus, config.load_cells[*i].node) == (bus, node))
            .collect();
        let end =
            |i: &usize| config.load_cells[*i].byte + config.load_cells[*i].cell.encoding.width().bytes();
        let bytes = of.iter().map(end).max().unwrap_or(0);
        frames.push(frame(bus, TPDO1 + u16::from(node), bytes, format!("load cell, {}", cables(&of))));
    }
    frames
}

#[cfg(test)]
mod tests {
    use cable_robot_fieldbus::bus_load::cycle_frames;

    use super::*;
    use crate::program::tests::config;

    #[test]
    fn the_frames_listed_are_those_reckoned_with() {
        let config = config();
        let mut listed: Vec<_> = frames(&config).iter().map(|frame| frame.bytes).collect();
        let mut reckoned = cycle_frames(&config)[0].clone();
        listed.sort_unstable();
        reckoned.sort_unstable();
        assert_eq!((listed.len(), listed), (19, reckoned));
    }
}
