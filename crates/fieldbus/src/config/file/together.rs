//! What makes sense only together with something else in the file.

use toml::Spanned;

use super::{DriveEntry, File};
use crate::canopen::{Node, Object};
use crate::cia402::{CONTROL_WORD, MAX_TORQUE, MODE, TARGET_TORQUE};
use crate::config::Config;
use cable_robot::checked_toml::{Checked, Refused};
use cable_robot::control::static_tensions;
use cable_robot::robot::PerCable;

/// Objects that the bridge sets itself; of the first ones every subindex.
const OWN_INDICES: [u16; 6] = [0x1016, 0x1017, 0x1400, 0x1600, 0x1800, 0x1A00];
const OWN_OBJECTS: [Object; 4] = [CONTROL_WORD, MODE, TARGET_TORQUE, MAX_TORQUE];

/// Looks at all of it.
pub(super) fn check(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    tensions_are_limited(check, file, config)?;
    nodes_are_different(check, file, config)?;
    buses_are_different(check, file)?;
    readings_are_different(check, file, config)?;
    objects_are_not_our_own(check, file, config)?;
    objects_are_of_known_nodes(check, file, config)?;
    motors_are_strong_enough(check, file, config)?;
    home_is_held(check, file, config)?;
    pretension_is_seen(check, file, config)?;
    drives_are_patient(check, file, config)?;
    drives_are_not_too_patient(check, file, config)?;
    counts_are_slower_than_mistakes(check, file, config)
}

/// A bridge that is gone must not be waited for longer than an operator who is.
fn drives_are_not_too_patient(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let (watchdog, enable) = (config.heartbeat.drive_watchdog, config.timeouts.enable);
    let has_reason = file.heartbeat.long_watchdog.as_ref().is_some_and(|reason| !reason.trim().is_empty());
    if watchdog <= enable || has_reason {
        return Ok(());
    }
    let allowed = format!(
        "must be at most timeouts.enable ({} s): so long the motors go on pulling when the bridge is killed. Say in heartbeat.long_watchdog why it may be longer",
        enable as f64 * 1e-9
    );
    let offset = file.heartbeat.drive_watchdog.span().start;
    Err(check.refuse(offset, "heartbeat.drive_watchdog", file.heartbeat.drive_watchdog.get_ref(), allowed))
}

/// One count in a cycle is a speed: if that is half of what counts as a mistake, motion cannot be told from it.
fn counts_are_slower_than_mistakes(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    for (i, entry) in file.drives.get_ref().iter().enumerate() {
        let winch = &config.drives[i].winch;
        let speed = winch.metres_per_count() * 1e9 / config.period as f64;
        if speed > 0.5 * config.limits.cable_speed {
            let needed = winch.counts_per_turn * speed / (0.5 * config.limits.cable_speed);
            let allowed = format!(
                "must be at least {needed:.0}: a count in a cycle would be {speed:.2} m/s, more than half of limits.cable_speed"
            );
            let field = format!("drives[{}].counts_per_turn", i + 1);
            return Err(check.refuse(
                entry.counts_per_turn.span().start,
                &field,
                winch.counts_per_turn,
                allowed,
            ));
        }
    }
    Ok(())
}

/// No address twice, on whatever bus: faults name nodes.
fn nodes_are_different(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let (drives, cells) = (file.drives.get_ref(), file.load_cells.get_ref());
    let mut taken: Vec<(Node, String)> = vec![(config.node, "the bridge".to_owned())];
    let mut claim =
        |node: Node, span: &Spanned<u32>, field: String| match taken.iter().find(|(n, _)| *n == node) {
            Some((_, other)) => {
                let allowed = format!("{other} has this address already");
                Err(check.refuse(span.span().start, &format!("{field}.node"), node, allowed))
            }
            None => {
                taken.push((node, field));
                Ok(())
            }
        };
    for i in 0..drives.len() {
        claim(config.drives[i].node, &drives[i].node, format!("drives[{}]", i + 1))?;
    }
    for i in 0..cells.len() {
        let (node, bus) = (config.load_cells[i].node, config.load_cells[i].bus);
        match config.load_cells[..i].iter().find(|other| other.node == node) {
            Some(same) if same.bus == bus => {}
            _ => claim(node, &cells[i].node, format!("load_cells[{}]", i + 1))?,
        }
    }
    Ok(())
}

fn buses_are_different(check: &Checked, file: &File) -> Result<(), Refused> {
    let buses = file.buses.get_ref();
    for (k, bus) in buses.iter().enumerate() {
        if let Some(j) = buses[..k].iter().position(|other| other.name.get_ref() == bus.name.get_ref()) {
            let field = format!("buses[{}].name", k + 1);
            let allowed = format!("buses[{}] has this name already", j + 1);
            return Err(check.refuse(bus.name.span().start, &field, bus.name.get_ref(), allowed));
        }
    }
    Ok(())
}

fn readings_are_different(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let reading = |i: usize| (config.load_cells[i].node, config.load_cells[i].cell.object);
    for i in 0..config.load_cells.len() {
        if let Some(j) = (0..i).find(|j| reading(*j) == reading(i)) {
            let entry = &file.load_cells.get_ref()[i].index;
            let allowed = format!("load_cells[{}] reads this object of node {} already", j + 1, reading(i).0);
            let field = format!("load_cells[{}].index, subindex", i + 1);
            return Err(check.refuse(entry.span().start, &field, reading(i).1, allowed));
        }
    }
    Ok(())
}

fn objects_are_not_our_own(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let entries = file.drive_objects.iter().chain(&file.load_cell_objects);
    let settings = config.drive_objects.iter().chain(&config.load_cell_objects);
    for (entry, object) in entries.zip(settings.map(|setting| setting.object)) {
        if OWN_INDICES.contains(&object.index) || OWN_OBJECTS.contains(&object) {
            let allowed = "the bridge sets this object itself";
            return Err(check.refuse(entry.index.span().start, "object", object, allowed));
        }
    }
    Ok(())
}

fn objects_are_of_known_nodes(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let drives: Vec<_> = config.drives.iter().map(|drive| drive.node).collect();
    let cells: Vec<_> = config.load_cells.iter().map(|cell| cell.node).collect();
    let all: Vec<Node> = [&drives, &cells].into_iter().flatten().copied().collect();
    for (k, entry) in file.ignored_emergencies.iter().enumerate() {
        if let Some(named) =
            entry.node.as_ref().filter(|named| !all.iter().any(|node| u32::from(*node) == *named.get_ref()))
        {
            let field = format!("ignored_emergencies[{}].node", k + 1);
            let allowed = "must be of one of the nodes, or be left out for all of them";
            return Err(check.refuse(named.span().start, &field, named.get_ref(), allowed));
        }
    }
    let tables: [(_, Vec<Node>, _); 2] =
        [(&file.drive_objects, drives, "drive"), (&file.load_cell_objects, cells, "load cell")];
    for (entries, nodes, kind) in tables {
        for (k, entry) in entries.iter().enumerate() {
            if let Some(named) = entry
                .node
                .as_ref()
                .filter(|named| !nodes.iter().any(|node| u32::from(*node) == *named.get_ref()))
            {
                let field = format!("{}_objects[{}].node", kind.replace(' ', "_"), k + 1);
                let allowed = format!("must be the node of a {kind}, or be left out for all of them");
                return Err(check.refuse(named.span().start, &field, named.get_ref(), allowed));
            }
        }
    }
    Ok(())
}

/// A motor always has a greatest tension.
fn tensions_are_limited(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let Some(i) = config.rig.cables.iter().position(|cable| cable.limits.max.is_infinite()) else {
        return Ok(());
    };
    let allowed = format!("its rig file must say the greatest tension of cable {}: tension.max (N)", i + 1);
    Err(check.refuse(file.rig.span().start, "rig", file.rig.get_ref(), allowed))
}

/// A torque that is cut without a word is not what the controller reckons with.
fn motors_are_strong_enough(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    for (i, entry) in file.drives.get_ref().iter().enumerate() {
        let DriveEntry { torque_limit, .. } = entry;
        let (winch, most) = (&config.drives[i].winch, config.rig.cables[i].limits.max);
        let needed = most * winch.pulley_radius / winch.gear;
        if winch.torque_limit < needed {
            let allowed =
                format!("must be at least {needed} N m for the greatest tension of the rig file ({most} N)");
            let field = format!("drives[{}].torque_limit", i + 1);
            return Err(check.refuse(torque_limit.span().start, &field, winch.torque_limit, allowed));
        }
    }
    Ok(())
}

fn home_is_held(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let tensions = static_tensions(&config.rig, &config.home, 0.0);
    let limits = config.rig.limits();
    let within = |tensions: &PerCable<f64>| {
        tensions.iter().zip(&limits).all(|(tension, limits)| limits.margin(*tension) >= 0.0)
    };
    if tensions.as_ref().is_some_and(within) {
        return Ok(());
    }
    let found = tensions.map_or("none".to_owned(), |tensions| format!("{tensions:.2?} N"));
    let allowed =
        format!("must be a pose that cables hold within the limits of the rig file; it takes {found}");
    let value = format!("[{}]", file.home.get_ref().map(|x| x.to_string()).join(", "));
    Err(check.refuse(file.home.span().start, "home", value, allowed))
}

/// By each load cell, and not by the stand.
fn pretension_is_seen(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let (pretension, most) = (config.slack.pretension, greatest_pretension(config));
    if pretension > most {
        let allowed = format!(
            "must be from 0.1 to {most:.3} N: one cable after the other pulls twice of it, and the platform must stay on its stand"
        );
        let offset = file.slack.pretension.span().start;
        return Err(check.refuse(offset, "slack.pretension", pretension, allowed));
    }
    let disagreement = config.limits.disagreement;
    if disagreement >= pretension {
        let allowed = format!(
            "must be less than slack.pretension ({pretension} N), or a dead load cell is not noticed"
        );
        let offset = file.limits.disagreement.span().start;
        return Err(check.refuse(offset, "limits.disagreement", disagreement, allowed));
    }
    Ok(())
}

/// With twice of it in one cable, neither a greatest tension nor the platform's weight is reached. N.
fn greatest_pretension(config: &Config) -> f64 {
    let rig = &config.rig;
    let up = -rig.gravity.normalize();
    let lift = rig.cables_at(&config.home).direction.map(|direction| direction.dot(&up));
    let lifted = lift.iter().sum::<f64>() + lift.iter().copied().fold(0.0, f64::max);
    let most = if lifted > 0.0 { rig.weight() / lifted } else { f64::INFINITY };
    (0.5 * rig.common_limits().max).min(most)
}

/// The bridge's heartbeat comes with a cycle, and after a pause that it rides through the drives must still be there.
fn drives_are_patient(check: &Checked, file: &File, config: &Config) -> Result<(), Refused> {
    let pause = config.period * u64::from(config.limits.lost_cycles + 1);
    let needed = pause.max(2 * config.period).max(config.heartbeat.period);
    if config.heartbeat.drive_watchdog > needed {
        return Ok(());
    }
    let seconds = |time: u64| time as f64 * 1e-9;
    let allowed = format!(
        "must be longer than {} s: limits.lost_cycles + 1 (at least 2) cycles, which the bridge rides through",
        seconds(needed)
    );
    let (offset, value) = (file.heartbeat.drive_watchdog.span().start, config.heartbeat.drive_watchdog);
    Err(check.refuse(offset, "heartbeat.drive_watchdog", seconds(value), allowed))
}
