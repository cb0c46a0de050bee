//! The simulated node of one or more load cells.

use super::node::{SimulatedNode, Task};
use crate::Nanoseconds;
use crate::canopen::{Node, Value};
use crate::config::{Action, Config};
use crate::frame::Frame;
use crate::load_cell::LoadCell;

/// What may be wrong with a load cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CellFault {
    /// Nothing.
    #[default]
    None,
    /// Its reading stays what it is.
    Stuck,
    /// It says this, N; also NaN or what cannot be.
    Says(f64),
}

/// An amplifier with its cells.
#[derive(Clone, Debug)]
pub struct SimulatedCells {
    /// Its communication.
    pub node: SimulatedNode,
    /// Whether it sends no process data.
    pub is_silent: bool,
    /// Cable (from 0), cell, and what is wrong with it.
    pub cells: Vec<(usize, LoadCell, CellFault)>,
}

impl SimulatedCells {
    /// The node at this address, as the fieldbus file describes it.
    pub(super) fn new(config: &Config, node: Node) -> Self {
        let ours = config.load_cells.iter().enumerate().filter(|(_, cell)| cell.node == node);
        let cells: Vec<_> = ours.map(|(cable, cell)| (cable, cell.cell, CellFault::None)).collect();
        let readings = cells
            .iter()
            .map(|(_, cell, _)| (cell.object, Value { bits: 0, width: cell.encoding.width() }, false));
        let settings = config.load_cell_objects.iter().filter(|setting| setting.is_of(node)).map(|setting| {
            let is_writable = setting.action == Action::Write;
            let bits = if is_writable { 0 } else { setting.value.bits };
            (setting.object, Value { bits, ..setting.value }, is_writable)
        });
        let objects: Vec<_> = readings.chain(settings).collect();
        Self { node: SimulatedNode::new(node, &objects), is_silent: false, cells }
    }

    /// What its cells feel, N.
    pub(super) fn feel(&mut self, tension: &[f64]) {
        for (cable, cell, fault) in &self.cells {
            let felt = match fault {
                CellFault::None => tension[*cable],
                CellFault::Stuck => continue,
                CellFault::Says(tension) => *tension,
            };
            self.node.set(cell.object, cell.write(felt));
        }
    }

    pub(super) fn on_frame(&mut self, frame: &Frame, now: Nanoseconds, out: &mut Vec<Frame>) {
        if self.node.on_frame(frame, now, out) == Some(Task::Sync) && !self.is_silent {
            out.extend(self.node.transmit());
        }
    }

    pub(super) fn tick(&mut self, now: Nanoseconds, out: &mut Vec<Frame>) {
        self.node.tick(now, out);
    }
}
