//! The commissioning record: which steps were passed, with which values of the files and which drives. A change asks for the steps that depend on it
//! again; a comment in a file does not.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cable_robot::robot::PerCable;
use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::bridge::Identity;
use cable_robot_files::read_text;
use cable_robot_report::files::write_whole;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

const FORMAT: u32 = 1;

/// A step of commissioning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// Load cells say about nothing of slack cables.
    Zero,
    /// The motor of a cable (from 0) pulls its own cable in, a person saw it.
    Pull(usize),
    /// Every drive stops without the bridge.
    Watchdog,
    /// Lengths and measured poses agree.
    Poses,
    /// The platform weighs what the rig file says.
    Weigh,
}

/// Steps with what they depended on, and the drives.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    format: u32,
    /// Vendor, product, revision, serial number (0x1018) of each cable's drive.
    drives: Vec<Identity>,
    /// Name of a step, and SHA-256 of the parsed values that it depends on.
    steps: BTreeMap<String, String>,
}

impl Step {
    /// All of a rig of so many cables, in the order of their making.
    pub fn all(cables: usize) -> Vec<Self> {
        [Self::Zero]
            .into_iter()
            .chain((0..cables).map(Self::Pull))
            .chain([Self::Watchdog, Self::Poses, Self::Weigh])
            .collect()
    }

    /// As an operator knows it.
    pub fn name(self) -> String {
        match self {
            Self::Zero => "zero".to_owned(),
            Self::Pull(cable) => format!("pull {}", cable + 1),
            Self::Watchdog => "watchdog".to_owned(),
            Self::Poses => "poses".to_owned(),
            Self::Weigh => "weigh".to_owned(),
        }
    }

    /// Of the parsed values that it depends on.
    fn digest(self, config: &Config) -> String {
        let winches = config.drives.iter().map(|drive| drive.winch).collect::<Vec<_>>();
        let addresses = config.drives.iter().map(|drive| (drive.bus, drive.node)).collect::<Vec<_>>();
        let ends = config.rig.cables.map(|cable| (cable.anchor, cable.attachment, cable.pulley));
        match self {
            Self::Zero => digest(&config.load_cells),
            Self::Pull(cable) => digest(&config.drives[cable]),
            Self::Watchdog => digest(&(addresses, config.heartbeat.drive_watchdog, &config.drive_objects)),
            Self::Weigh => digest(&(config.rig.mass, config.rig.gravity, ends, &config.load_cells)),
            Self::Poses => digest(&(addresses, winches, ends, config.rig.gravity, config.home)),
        }
    }
}

/// Every number in full: equal text is equal bits.
fn digest(values: &impl Debug) -> String {
    Sha256::digest(format!("{values:?}")).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Beside the fieldbus file.
pub fn path(fieldbus: &Path) -> PathBuf {
    fieldbus.with_extension("commissioned.json")
}

impl Record {
    /// Of a fieldbus file; an empty one if there is none.
    pub fn read(fieldbus: &Path) -> Result<Self> {
        let path = path(fieldbus);
        if !path.exists() {
            return Ok(Self::default());
        }
        let text = read_text(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let record: Self = serde_json::from_str(&text)
            .with_context(|| format!("{}: remove it and commission anew (--survey)", path.display()))?;
        let format = record.format;
        ensure!(format == FORMAT, "{}: format {format} is not known, only {FORMAT}", path.display());
        Ok(record)
    }

    /// What is missing, and why; nothing if the rig is as it was commissioned.
    pub fn missing(&self, config: &Config) -> Vec<String> {
        let why = |step: Step| match self.steps.get(&step.name()) {
            None => Some(format!("{} (never passed)", step.name())),
            Some(digest) if *digest != step.digest(config) => {
                Some(format!("{} (the files say something else than then)", step.name()))
            }
            Some(_) => None,
        };
        Step::all(config.drives.len()).into_iter().filter_map(why).collect()
    }

    /// The drives, as they were.
    pub fn drives(&self) -> Option<PerCable<Identity>> {
        PerCable::from_slice(&self.drives)
    }

    /// Notes what was passed with these drives. What was passed before stays, unless a drive is another one.
    pub fn note(&mut self, steps: &[Step], config: &Config, drives: &PerCable<Identity>) {
        let same = |cable: usize| self.drives.get(cable) == Some(&drives[cable]);
        let changed: Vec<_> = (0..drives.len()).filter(|cable| !same(*cable)).collect();
        let stays = |step: Step| match step {
            Step::Zero | Step::Weigh => true,
            Step::Pull(cable) => !changed.contains(&cable),
            Step::Watchdog | Step::Poses => changed.is_empty(),
        };
        for step in Step::all(drives.len()).into_iter().filter(|step| !stays(*step)) {
            self.steps.remove(&step.name());
        }
        self.steps.extend(steps.iter().map(|step| (step.name(), step.digest(config))));
        (self.format, self.drives) = (FORMAT, drives.to_vec());
    }

    /// Writes it beside the fieldbus file.
    pub fn write(&self, fieldbus: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        write_whole(&path(fieldbus), |file| writeln!(file, "{text}"))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::tests::config;

    fn drives() -> PerCable<Identity> {
        PerCable::from_fn(6, |i| [Some(1), Some(2), None, Some(i as u32)])
    }

    fn complete(config: &Config) -> Record {
        let mut record = Record::default();
        record.note(&Step::all(6), config, &drives());
        record
    }

    #[test]
    fn a_change_asks_for_the_steps_that_depend_on_it_and_for_no_others() {
        let config = config();
        let record = complete(&config);
        assert_eq!(record.missing(&config), Vec::<String>::new());
        assert_eq!(Record::default().missing(&config).len(), 10);
        let asks = |change: &dyn Fn(&mut Config)| {
            let mut changed = config.clone();
            change(&mut changed);
            let missing = record.missing(&changed).into_iter();
            missing.map(|text| text.split(" (").next().unwrap().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(asks(&|config| config.limits.tilt *= 2.0), Vec::<String>::new());
        assert_eq!(asks(&|config| config.drives[2].winch.pulley_radius *= 1.01), ["pull 3", "poses"]);
        assert_eq!(asks(&|config| config.home.0[0] += 1e-3), ["poses"]);
        assert_eq!(asks(&|config| config.load_cells[0].cell.offset += 0.1), ["zero", "weigh"]);
        assert_eq!(asks(&|config| config.heartbeat.drive_watchdog *= 2), ["watchdog"]);
        assert_eq!(asks(&|config| config.rig.cables[0].anchor.x += 1e-3), ["poses", "weigh"]);
        assert_eq!(asks(&|config| config.rig.mass += 0.1), ["weigh"]);
    }

    #[test]
    fn an_exchanged_drive_asks_for_its_own_steps_again() {
        let config = config();
        let mut record = complete(&config);
        let mut exchanged = drives();
        exchanged[4][3] = Some(99);
        record.note(&[], &config, &exchanged);
        let missing = record.missing(&config).join(", ");
        assert_eq!(missing, "pull 5 (never passed), watchdog (never passed), poses (never passed)");
    }

    #[test]
    fn a_record_comes_back_as_it_was_written_and_a_foreign_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let fieldbus = folder.path().join("lab.toml");
        assert_eq!(Record::read(&fieldbus).unwrap(), Record::default());
        let record = complete(&config());
        record.write(&fieldbus).unwrap();
        assert_eq!(Record::read(&fieldbus).unwrap(), record);
        for text in ["{}", "{\"format\": 2, \"drives\": [], \"steps\": {}}", "[", ""] {
            std::fs::write(path(&fieldbus), text).unwrap();
            let error = format!("{:#}", Record::read(&fieldbus).unwrap_err());
            assert!(error.contains("lab.commissioned.json"), "{error}");
        }
    }
}
