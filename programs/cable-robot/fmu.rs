//! `cable-robot fmu`: the FMUs of a rig, packed with the library of FMUs that are there already.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use cable_robot::robot::RigFile;
use cable_robot_fieldbus::Files;
use cable_robot_files::read_text;
use cable_robot_fmi::describe::{System, VERSIONS, Version};
use cable_robot_fmi::models::Variant;
use cable_robot_fmi::models::node::NODES;
use cable_robot_fmi::resources::RIG_FILE;
use cable_robot_fmi::{CO_SIMULATION, Interface, MODELS, Model};
use cable_robot_fmi::{archive, can};
use clap::{Args, ValueHint};
use serde_json::json;

use crate::command::{Outcome, installation, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot fmu --rig rigs/eight.toml --output my-fmus
It needs no compiler: it takes the library from the FMUs that `cargo fmu build` packed, or those in --library.";

#[derive(Args)]
pub struct Fmu {
    /// Rig file (TOML, see docs/rigs.md)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, required_unless_present = "can")]
    rig: Option<PathBuf>,
    /// Fieldbus file (TOML, see docs/rig.md): packs instead of controller and plant the bridge and the rig as nodes on its CAN buses, for FMI-LS-BUS (docs/ls-bus.md)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = ["rig", "ssp", "reals", "full"])]
    can: Option<PathBuf>,
    /// Folder to write to: FOLDER/fmi2/CableRobotController.fmu and so on
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// Folder of the FMUs of the paper's rig, fmi2 and fmi3 in it; without it where the program lies or `cargo fmu build` packs them
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    library: Option<PathBuf>,
    /// Writes controller and plant, connected, to FOLDER as well: CableRobot.ssp (SSP 1.0, FMI 2), CableRobotFMI3.ssp (SSP 2.0, FMI 3), CableRobotClosed.ssp (SSP 1.0, without inputs and outputs, for masters that know none)
    #[arg(long)]
    ssp: bool,
    /// Shows importers reals only, for those that know nothing else: Booleans as 0 or 1, enumerations as numbers
    #[arg(long)]
    reals: bool,
    /// Shows importers of FMI 3 all that it has: arrays, Event Mode with a clock that ticks where the planner decides, steps that end there
    #[arg(long, conflicts_with_all = ["reals", "ssp"])]
    full: bool,
    /// Prints the paths for machines
    #[arg(long)]
    json: bool,
}

impl Fmu {
    fn variant(&self) -> Variant {
        match (self.reals, self.full) {
            (true, _) => Variant::Reals,
            (_, true) => Variant::Full,
            _ => Variant::Scalars,
        }
    }

    pub fn run(&self) -> Result<Outcome> {
        let library = library_folder(self.library.as_deref())?;
        let mut paths = vec![];
        if let Some(fieldbus) = &self.can {
            paths = pack_nodes(fieldbus, &self.output, &library)?;
        }
        if let Some(rig) = &self.rig {
            paths = pack(rig, self.variant(), &self.output, &library)?;
            if self.ssp {
                paths.extend(pack_systems(rig, self.variant(), &self.output)?);
            }
        }
        if self.json {
            print_json(&json!({ "fmus": paths }))?;
        } else {
            let lines: Vec<_> = paths.iter().map(|path| path.display().to_string()).collect();
            print(&lines.join("\n"))?;
        }
        Ok(Outcome::Done)
    }
}

/// The folder of FMUs given, or the one beside the program or where the project packs them.
pub fn library_folder(given: Option<&Path>) -> Result<PathBuf> {
    if let Some(folder) = given.or(installation().fmus.as_deref()) {
        return Ok(folder.to_owned());
    }
    let program = std::env::current_exe().unwrap_or_default();
    let beside = program.parent().unwrap_or(Path::new(""));
    let places = [beside.join("fmu"), beside.join("../fmu"), PathBuf::from("target/fmu")];
    let is_there = |folder: &&PathBuf| path_of(folder, Model::Controller, Version::Fmi3).is_file();
    match places.iter().find(is_there) {
        Some(folder) => Ok(folder.clone()),
        None => bail!(
            "no FMUs to take the library from: run `cargo fmu build`, or name their folder with --library"
        ),
    }
}

fn path_of(folder: &Path, model: Model, version: Version) -> PathBuf {
    folder.join(version.name()).join(model.identifier()).with_extension("fmu")
}

/// The step that masters of a system are expected to take, s.
const STEP: f64 = 1e-3;

/// Name of the file, version of the FMUs in it, and whether it has no inputs and outputs.
const SYSTEMS: [(&str, Version, bool); 3] = [
    ("CableRobot.ssp", Version::Fmi2, false),
    ("CableRobotFMI3.ssp", Version::Fmi3, false),
    ("CableRobotClosed.ssp", Version::Fmi2, true),
];

/// Packs the FMUs in a folder as systems; their paths.
fn pack_systems(rig: &Path, variant: Variant, folder: &Path) -> Result<Vec<PathBuf>> {
    let file = read_rig(rig)?.1;
    let [controller, plant] = CO_SIMULATION.map(|model| interface(model, &file, variant));
    let pack = |(name, fmi, is_closed): (&str, Version, bool)| {
        let system = System { controller: &controller, plant: &plant, fmi, is_closed, step: STEP };
        let mut files = archive::Files::new();
        files.insert("SystemStructure.ssd".into(), system.structure().into_bytes());
        for model in CO_SIMULATION {
            let path = path_of(folder, model, fmi);
            let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
            files.insert(format!("resources/{}.fmu", model.identifier()), bytes);
        }
        let path = folder.join(name);
        archive::write(&path, &files).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    };
    SYSTEMS.into_iter().map(pack).collect()
}

/// Packs the nodes on the buses of a fieldbus file; their paths.
fn pack_nodes(fieldbus: &Path, output: &Path, library: &Path) -> Result<Vec<PathBuf>> {
    let files = Files::read(fieldbus)?;
    can::controller_parameters(&files.config).with_context(|| fieldbus.display().to_string())?;
    let pack = |kind| {
        let model = Model::Node(kind);
        let from = path_of(library, model, Version::Fmi3);
        let (libraries, _) = archive::libraries(&from).with_context(|| {
            format!(
                "cannot read {}: run `cargo fmu build`, or name its folder with --library",
                from.display()
            )
        })?;
        let path = path_of(output, model, Version::Fmi3);
        archive::write(&path, &can::contents(kind, &files, &libraries))
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    };
    NODES.into_iter().map(pack).collect()
}

fn interface(model: Model, file: &RigFile, variant: Variant) -> Interface {
    Interface::of_rig(model, file).shown_as(variant)
}

fn read_rig(path: &Path) -> Result<(String, RigFile)> {
    let text = read_text(path).with_context(|| format!("cannot read {}", path.display()))?;
    let file = RigFile::parse(&text).with_context(|| path.display().to_string())?;
    Ok((text, file))
}

/// Packs all models in both versions for the rig of a file, in a variant; their paths. FMI 2 has neither arrays nor clocks.
pub fn pack(rig: &Path, variant: Variant, output: &Path, library: &Path) -> Result<Vec<PathBuf>> {
    let (text, file) = read_rig(rig)?;
    let mut paths = vec![];
    for version in VERSIONS {
        for model in MODELS {
            let from = path_of(library, model, version);
            let (libraries, description) =
                archive::libraries(&from).with_context(|| format!("cannot read {}", from.display()))?;
            ensure!(
                description.contains(model.interface().token()),
                "{} is of another version of cable-robot: its library would not know the rig",
                from.display()
            );
            let variant = match (version, variant) {
                (Version::Fmi2, Variant::Full) => Variant::Scalars,
                (_, variant) => variant,
            };
            let interface = interface(model, &file, variant);
            let path = path_of(output, model, version);
            archive::write(&path, &archive::contents(&interface, version, &libraries, &[(RIG_FILE, &text)]))
                .with_context(|| format!("cannot write {}", path.display()))?;
            paths.push(path);
        }
    }
    Ok(paths)
}
