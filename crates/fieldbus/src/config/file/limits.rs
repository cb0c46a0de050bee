//! What counts as a fault, and what of that follows from the rig where the file leaves it out.

use serde::Deserialize;
use toml::Spanned;

use super::super::values::time;
use super::super::{Limits, MOST_LOST_CYCLES};
use super::LARGE;
use cable_robot::checked_toml::{Checked, Refused};
use cable_robot::robot::{Pose, Rig};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitEntry {
    lost_cycles: Spanned<u32>,
    cable_speed: Spanned<f64>,
    freeze_speed: Spanned<f64>,
    freeze_travel: Spanned<f64>,
    tilt: Spanned<f64>,
    pub disagreement: Spanned<f64>,
    disagreement_time: Spanned<f64>,
    stuck: Spanned<f64>,
    torque_error: Option<Spanned<f64>>,
    latency: Option<Spanned<f64>>,
    following: Option<Spanned<f64>>,
    space: Option<Spanned<[[f64; 2]; 3]>>,
}

/// No friction lies between a motor and what its drive says of it: this share of what a load cell may be off by, unless the file says more.
const TORQUE_ERROR: f64 = 0.2;

/// Periods that a torque takes where nothing is slow: to the next SYNC, to the one at which it is sampled, and as much for the motor.
const LATENCY: f64 = 3.0;

/// How far a platform may be from where it is led: this share of its shortest cable at home.
const FOLLOWING: f64 = 0.02;

pub(super) fn limits(check: &Checked, entry: &LimitEntry, rig: &Rig, home: Pose) -> Result<Limits, Refused> {
    let number = |value, name: &str, range, unit| check.within(value, &format!("limits.{name}"), range, unit);
    let lost_cycles =
        check.within(&entry.lost_cycles, "limits.lost_cycles", 0..=MOST_LOST_CYCLES, "cycles")?;
    let disagreement = number(&entry.disagreement, "disagreement", 0.01..=LARGE, "N")?;
    Ok(Limits {
        lost_cycles,
        cable_speed: number(&entry.cable_speed, "cable_speed", 0.01..=100.0, "m/s")?,
        freeze_speed: number(&entry.freeze_speed, "freeze_speed", 1e-4..=100.0, "m/s")?,
        freeze_travel: number(&entry.freeze_travel, "freeze_travel", 1e-4..=1.0, "m")?,
        tilt: number(&entry.tilt, "tilt", 0.01..=1.4, "rad")?,
        disagreement,
        torque_error: match &entry.torque_error {
            Some(given) => number(given, "torque_error", 1e-3..=LARGE, "N")?,
            None => TORQUE_ERROR * disagreement,
        },
        latency: match &entry.latency {
            Some(given) => number(given, "latency", 1.0..=100.0, "periods")?,
            None => LATENCY.max(f64::from(lost_cycles) + 1.0),
        },
        following: match &entry.following {
            Some(given) => number(given, "following", 1e-4..=10.0, "m")?,
            None => FOLLOWING * rig.cables_at(&home).length.iter().copied().fold(f64::INFINITY, f64::min),
        },
        space: match &entry.space {
            Some(given) => space(check, given, home)?,
            None => space_of(rig, home),
        },
        disagreement_time: time(check, &entry.disagreement_time, "limits.disagreement_time", 0.0..=10.0)?,
        stuck: number(&entry.stuck, "stuck", 0.01..=LARGE, "N")?,
    })
}

/// The box that holds the anchors and the platform at home.
fn space_of(rig: &Rig, home: Pose) -> [[f64; 2]; 3] {
    let (at, radius) = (home.position(), rig.platform_radius());
    [0, 1, 2].map(|axis| {
        let anchors = rig.cables.iter().map(|cable| cable.anchor[axis]);
        anchors.fold([at[axis] - radius, at[axis] + radius], |[least, greatest], anchor| {
            [least.min(anchor), greatest.max(anchor)]
        })
    })
}

fn space(check: &Checked, given: &Spanned<[[f64; 2]; 3]>, home: Pose) -> Result<[[f64; 2]; 3], Refused> {
    let at = home.position();
    for (axis, [least, greatest]) in given.get_ref().iter().enumerate() {
        if !(*least <= at[axis] && at[axis] <= *greatest) {
            let field = format!("limits.space[{}] ({})", axis + 1, ["x", "y", "z"][axis]);
            let allowed =
                format!("must be two numbers, the least first, with home ({}) between them (m)", at[axis]);
            return Err(check.refuse(given.span().start, &field, format!("[{least}, {greatest}]"), allowed));
        }
    }
    Ok(*given.get_ref())
}
