//! The calibration file: the numbers that commissioning measured, and what the files would better say. Beside the record of what was passed.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result, ensure};
use cable_robot::robot::PerCable;
use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::commission::{self, Accuracy, Fitted, Gains, Placement, Weighing, World};
use cable_robot_files::read_text;
use cable_robot_report::files::write_whole;
use serde::{Deserialize, Serialize};

const FORMAT: u32 = 1;
/// Of what the survey tells, what is off by so many standard deviations is shown.
const SHOWN: f64 = 2.0;

/// What was measured in a session.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    /// What each load cell said of a slack cable, N.
    pub zero: Option<PerCable<f64>>,
    /// Of a cable (from 0): what its motor pulled at last, N, and by how much each cable came in, m.
    pub pulls: BTreeMap<usize, (f64, PerCable<f64>)>,
    /// Lengths at poses.
    pub placements: Vec<Placement>,
    /// Readings of load cells with the platform hanging.
    pub weighings: Vec<Weighing>,
}

/// The file.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    format: u32,
    zero: Option<Zero>,
    pulls: BTreeMap<usize, Pull>,
    poses: Option<Poses>,
    weight: Option<Weight>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Zero {
    unix_time: u64,
    /// N.
    reading: Vec<f64>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pull {
    unix_time: u64,
    /// N.
    tension: f64,
    /// Of each cable, m.
    came_in: Vec<f64>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Poses {
    unix_time: u64,
    /// Standard deviations of placing, m and rad, and of reading, m.
    accuracy: [f64; 3],
    /// Each pose (m, rad), and by how much each cable was longer there than at home, m.
    placements: Vec<([f64; 6], Vec<f64>)>,
    offered: Option<Offered>,
}

/// What explains the lengths best, attachments believed.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Offered {
    /// m, rad.
    home: [f64; 6],
    /// m.
    anchors: Vec<[f64; 3]>,
    /// m.
    pulley_radii: Vec<f64>,
    measures: Vec<Measure>,
    /// Standard deviations, root of the mean square over all lengths.
    residual: f64,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Measure {
    name: String,
    /// More than the files say by this, m, rad or a share.
    more: f64,
    /// Its standard deviation.
    deviation: f64,
    /// Whether the lengths tell it, rather than the files.
    is_measured: bool,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Weight {
    unix_time: u64,
    /// Each pose (m, rad), and what the load cells said there, N.
    weighings: Vec<([f64; 6], Vec<f64>)>,
    /// What each cell says for a newton, and its standard deviation, if the mass is right.
    gains: Option<Vec<[f64; 2]>>,
    /// What each cell's `scale` would be then.
    scales: Option<Vec<f64>>,
    /// How many combinations of gains the weighings tell.
    rank: usize,
}

/// Beside the fieldbus file.
pub fn path(fieldbus: &Path) -> PathBuf {
    fieldbus.with_extension("calibration.json")
}

impl Calibration {
    /// Of a fieldbus file; an empty one if there is none.
    pub fn read(fieldbus: &Path) -> Result<Self> {
        let path = path(fieldbus);
        if !path.exists() {
            return Ok(Self { format: FORMAT, ..Self::default() });
        }
        let text = read_text(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let found: Self =
            serde_json::from_str(&text).with_context(|| format!("{}: move it away", path.display()))?;
        let format = found.format;
        ensure!(format == FORMAT, "{}: format {format} is not known, only {FORMAT}", path.display());
        Ok(found)
    }

    /// Notes what was measured. What was measured before stays where nothing new is.
    pub fn note(
        &mut self,
        numbers: &Numbers,
        config: &Config,
        accuracy: &Accuracy,
        fitted: Option<&commission::Calibration>,
        gains: Option<&Gains>,
    ) {
        let unix_time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
        if let Some(reading) = &numbers.zero {
            self.zero = Some(Zero { unix_time, reading: reading.to_vec() });
        }
        self.pulls.extend(numbers.pulls.iter().map(|(cable, (tension, came_in))| {
            (cable + 1, Pull { unix_time, tension: *tension, came_in: came_in.to_vec() })
        }));
        if !numbers.placements.is_empty() {
            self.poses = Some(Poses {
                unix_time,
                accuracy: [accuracy.position, accuracy.angle, accuracy.length],
                placements: numbers
                    .placements
                    .iter()
                    .map(|placement| (placement.pose.0.into(), placement.lengthening.to_vec()))
                    .collect(),
                offered: fitted.map(|found| Offered::of(found, config)),
            });
        }
        if !numbers.weighings.is_empty() {
            let of_cell = |gains: &Gains, i: usize| config.load_cells[i].cell.scale / gains.gain[i];
            let cells = 0..config.load_cells.len();
            self.weight = Some(Weight {
                unix_time,
                weighings: numbers
                    .weighings
                    .iter()
                    .map(|weighing| (weighing.pose.0.into(), weighing.reading.to_vec()))
                    .collect(),
                gains: gains
                    .map(|gains| cells.clone().map(|i| [gains.gain[i], gains.deviation[i]]).collect()),
                scales: gains.map(|gains| cells.map(|i| of_cell(gains, i)).collect()),
                rank: gains.map_or(0, |gains| gains.rank),
            });
        }
    }

    /// Writes it beside the fieldbus file.
    pub fn write(&self, fieldbus: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        write_whole(&path(fieldbus), |file| writeln!(file, "{text}"))?;
        Ok(())
    }
}

impl Offered {
    fn of(found: &commission::Calibration, config: &Config) -> Self {
        let file = World::of(config);
        let cables = 0..file.scale.len();
        let measured: Vec<_> = found.measured(&file).collect();
        let measure = |fitted: &Fitted| Measure {
            name: fitted.quantity.to_string(),
            more: fitted.amount,
            deviation: fitted.deviation,
            is_measured: measured.contains(&fitted),
        };
        Self {
            home: found.world.home.0.into(),
            anchors: cables.clone().map(|i| found.world.rig.cables[i].anchor.into()).collect(),
            pulley_radii: cables
                .map(|i| config.drives[i].winch.pulley_radius / found.world.scale[i])
                .collect(),
            measures: found.fitted.iter().map(measure).collect(),
            residual: found.residual,
        }
    }
}

/// What the files would better say, in lines; empty if nothing is off by more than it may be.
pub fn offer(file: &World, found: &commission::Calibration) -> String {
    let is_off = |fitted: &&Fitted| fitted.amount.abs() > SHOWN * fitted.deviation;
    let lines: Vec<_> = found.measured(file).filter(is_off).map(|fitted| format!("\n  {fitted}")).collect();
    if lines.is_empty() {
        return String::new();
    }
    let residual = found.residual;
    format!(
        "home, pulley radii and anchors fitted together (an offer; all of it stands in the calibration file) leave {residual:.2} standard deviations; off by more than {SHOWN} of theirs are{}",
        lines.concat()
    )
}

/// Gains of load cells, in words.
pub fn gains_text(gains: &Gains) -> String {
    let cell = |i: usize| {
        let unmeasured = if gains.is_measured(i) { "" } else { " (not measured)" };
        format!("{}: {:.3} ± {:.3}{unmeasured}", i + 1, gains.gain[i], gains.deviation[i])
    };
    let cells: Vec<_> = (0..gains.gain.len()).map(cell).collect();
    let (rank, count) = (gains.rank, gains.gain.len());
    let more =
        if rank < count { "; put the platform on blocks elsewhere, placed, and weigh there too" } else { "" };
    format!(
        "load cells say for each newton, if the mass is right: {} ({rank} of {count} combinations measured{more})",
        cells.join("  ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::tests::config;
    use cable_robot::robot::Pose;

    fn accuracy() -> Accuracy {
        Accuracy { position: 0.001, angle: 0.002, length: 0.001 }
    }

    #[test]
    fn what_was_measured_before_stays_and_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let fieldbus = folder.path().join("lab.toml");
        let mut calibration = Calibration::read(&fieldbus).unwrap();
        let zero = Numbers { zero: Some(PerCable::filled(6, 0.25)), ..Numbers::default() };
        calibration.note(&zero, &config(), &accuracy(), None, None);
        calibration.write(&fieldbus).unwrap();
        let mut calibration = Calibration::read(&fieldbus).unwrap();
        let file = World::of(&config());
        let poses = [[0.1, 0.05, 0.9], [-0.1, 0.1, 0.8]].map(|[x, y, z]| Pose::at(x, y, z));
        let placement = |pose: &Pose| Placement { pose: *pose, lengthening: file.lengthening(pose) };
        let placements = poses.iter().map(placement).collect();
        let numbers = Numbers { placements, ..Numbers::default() };
        let found = commission::Calibration::new(&file, &numbers.placements, &accuracy());
        calibration.note(&numbers, &config(), &accuracy(), found.as_ref(), None);
        assert_eq!(calibration.zero.as_ref().unwrap().reading, [0.25; 6]);
        let poses = calibration.poses.as_ref().unwrap();
        let offered = poses.offered.as_ref().unwrap();
        assert!(offered.residual < 1e-6 && offered.anchors.len() == 6, "{offered:?}");
        calibration.write(&fieldbus).unwrap();
        assert_eq!(Calibration::read(&fieldbus).unwrap(), calibration);
        std::fs::write(path(&fieldbus), "{\"format\": 7}").unwrap();
        let error = format!("{:#}", Calibration::read(&fieldbus).unwrap_err());
        assert!(error.contains("lab.calibration.json"), "{error}");
    }

    #[test]
    fn a_home_that_is_off_is_offered() {
        let file = World::of(&config());
        let mut truth = file;
        truth.home.0[0] += 0.05;
        let poses =
            [[0.1, 0.05, 0.9], [-0.1, 0.1, 0.8], [0.0, -0.1, 0.95]].map(|[x, y, z]| Pose::at(x, y, z));
        let placement = |pose: &Pose| Placement { pose: *pose, lengthening: truth.lengthening(pose) };
        let placements: Vec<_> = poses.iter().map(placement).collect();
        let offered = |placements: &[Placement]| {
            offer(&file, &commission::Calibration::new(&file, placements, &accuracy()).unwrap())
        };
        let text = offered(&placements);
        assert!(text.contains("home, x: +"), "{text}");
        let right: Vec<_> =
            poses.iter().map(|pose| Placement { pose: *pose, lengthening: file.lengthening(pose) }).collect();
        assert_eq!(offered(&right), "");
    }
}
