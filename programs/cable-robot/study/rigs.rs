//! Every rig of a folder: its workspace, the planner's tick, and random goals through its packed FMUs in closed loop.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use cable_robot::control::static_margin;
use cable_robot::plan::{ControllerParameters, Planner, PlannerKind, Status};
use cable_robot::reach::Slice;
use cable_robot::robot::{Coordinates, Pose, RigFile};
use cable_robot::sim::{ClosedLoop, Moment, PlantInputs};
use cable_robot_cosim::FmuModel;
use cable_robot_fmi::Model;
use cable_robot_fmi::models::Variant;
use cable_robot_import::Fmu;
use clap::{Args, ValueHint};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;

use crate::command::fmu::{library_folder, pack};
use crate::command::progress::Progress;
use crate::command::{Outcome, print, print_json, rig, workspace};

pub const EXAMPLE: &str = "\
Example: cable-robot study rigs rigs/public
Goals lie up to 15 % of the rig's radius from home, where 3 % of the weight can be kept from every limit; as many are outside the
workspace. Exit code 3: a goal was not reached, a tension left its limits, or a goal outside was not called unreachable.";

/// Farthest goal from home, as a share of the rig's radius, and the margin that it leaves, as a share of the weight.
const REACH: f64 = 0.15;
const SPARE: f64 = 0.03;
/// Goals outside are looked for as far as this many radii from home.
const OUTSIDE: f64 = 1.2;
/// Points drawn before a rig counts as one without such goals.
const MOST_DRAWN: usize = 10_000;
/// Communication step and the time after which a goal counts as not reached, s.
const STEP: f64 = 1e-3;
const PATIENCE: f64 = 60.0;
/// How long a goal outside is run, s.
const SHORT: f64 = 6.0;

#[derive(Args)]
pub struct Rigs {
    /// Folder of rig files
    #[arg(value_hint = ValueHint::DirPath)]
    folder: PathBuf,
    /// Goals inside the workspace of each rig, and as many outside
    #[arg(long, default_value_t = 5)]
    goals: usize,
    /// Of the goals
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder of the packed FMUs whose library is used
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    library: Option<PathBuf>,
    /// Prints numbers for machines
    #[arg(long)]
    json: bool,
}

/// What became of a rig.
struct Row {
    name: String,
    outcome: Result<Driven, String>,
}

/// A rig that can be driven.
struct Driven {
    cables: usize,
    /// m².
    area: f64,
    /// Median time of a planner's decision, µs.
    tick: f64,
    weight: f64,
    runs: Vec<Run>,
}

/// A goal and what became of it.
struct Run {
    /// m, in the rig file's frame.
    goal: [f64; 3],
    inside: bool,
    reached: bool,
    unreachable: bool,
    /// Least distance of a tension from its limits, N.
    margin: f64,
    /// s.
    time: f64,
}

impl Driven {
    fn is_good(&self) -> bool {
        self.runs.iter().all(|run| run.margin > 0.0 && if run.inside { run.reached } else { run.unreachable })
    }
}

impl Rigs {
    pub fn run(&self) -> Result<Outcome> {
        let library = library_folder(self.library.as_deref())?;
        let mut files: Vec<_> = std::fs::read_dir(&self.folder)
            .with_context(|| format!("cannot read {}", self.folder.display()))?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
            .collect();
        files.sort();
        let progress = Progress::new("driving", (files.len() * 2 * self.goals) as u64);
        let rows: Vec<Row> = files.par_iter().map(|path| self.row(path, &library, &progress)).collect();
        drop(progress);
        if self.json {
            print_json(&as_json(&rows))?
        } else {
            print(&as_text(&rows))?
        }
        let good = rows.iter().all(|row| row.outcome.as_ref().map_or(true, Driven::is_good));
        Ok(if good { Outcome::Done } else { Outcome::NotReachable })
    }

    fn row(&self, path: &Path, library: &Path, progress: &Progress) -> Row {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let outcome = rig::read(path).map_err(|error| error.root_cause().to_string());
        let outcome = outcome.and_then(|file| {
            self.drive(path, &file, library, progress).map_err(|error| format!("{error:#}"))
        });
        Row { name, outcome }
    }

    fn drive(&self, path: &Path, file: &RigFile, library: &Path, progress: &Progress) -> Result<Driven> {
        let folder = tempfile::tempdir()?;
        pack(path, Variant::Scalars, folder.path(), library)?;
        let packed = |model: Model| folder.path().join("fmi3").join(model.identifier()).with_extension("fmu");
        let open = |model| {
            let path = packed(model);
            Fmu::open(&path).map(|fmu| (path, fmu))
        };
        let fmus = [open(Model::Controller)?, open(Model::Plant)?];
        let slice = Slice { rig: &file.rig, height: file.home.0[2], angles: Vector3::zeros() };
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let (inside, outside) = goals(file, self.goals, &mut rng);
        let tick = tick(file, &inside);
        let mut runs = vec![];
        for (goal, is_inside) in inside.iter().map(|g| (g, true)).chain(outside.iter().map(|g| (g, false))) {
            runs.push(run(&fmus, file, goal, is_inside)?);
            progress.done(1);
        }
        Ok(Driven {
            cables: file.rig.cables.len(),
            area: workspace::find(&slice, file, || {}).map_or(0.0, |found| found.area),
            tick,
            weight: file.rig.weight(),
            runs,
        })
    }
}

/// Goals with zero orientation inside the static workspace and outside of it.
fn goals(file: &RigFile, count: usize, rng: &mut Pcg64) -> (Vec<Pose>, Vec<Pose>) {
    let RigFile { rig, home, .. } = file;
    let mut draw = |size: f64, accept: &dyn Fn(f64) -> bool| {
        let mut found = vec![];
        for _ in 0..MOST_DRAWN {
            let by = Coordinates::from_fn(|k, _| if k < 3 { rng.random_range(-1.0..1.0) } else { 0.0 });
            let goal = Pose(home.0 + by * (size * rig.radius()));
            if found.len() < count && by.norm() <= 1.0 && accept(static_margin(rig, &goal)) {
                found.push(goal);
            }
        }
        found
    };
    let inside = draw(REACH, &|margin| margin > SPARE * rig.weight());
    (inside, draw(OUTSIDE, &|margin| margin < -SPARE * rig.weight()))
}

/// Median time of the decision from rest at home for one of the goals, µs.
fn tick(file: &RigFile, goals: &[Pose]) -> f64 {
    let planner = PlannerKind::Exact;
    let RigFile { rig, lambda, eta, home, .. } = file;
    let parameters =
        ControllerParameters { lambda: *lambda, eta: *eta, planner, ..ControllerParameters::of(rig) };
    let planner = Planner::from(parameters);
    let mut times: Vec<f64> = (0..20)
        .flat_map(|_| goals)
        .map(|goal| {
            let start = Instant::now();
            std::hint::black_box(planner.next_from_rest(home, goal));
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Controller and plant from home to the goal.
fn run([controller, plant]: &[(PathBuf, Fmu); 2], file: &RigFile, goal: &Pose, inside: bool) -> Result<Run> {
    let open = |(path, fmu): &(PathBuf, Fmu)| FmuModel::of(fmu, path, file, Box::new(|_| {}));
    let outside = PlantInputs::none(file.rig.cables.len());
    let mut closed_loop = ClosedLoop::with_models(open(controller)?, open(plant)?, *goal, &outside)?;
    let (stop, mut margin) = (if inside { PATIENCE } else { SHORT }, f64::INFINITY);
    loop {
        let Moment { time, controller, plant, .. } = closed_loop.moment();
        let tensions = plant.measured_tension.iter().zip(&file.rig.cables);
        margin = tensions.map(|(u, cable)| cable.limits.margin(*u)).fold(margin, f64::min);
        if *time >= stop || controller.at_goal {
            return Ok(Run {
                goal: goal.position().into(),
                inside,
                reached: controller.at_goal,
                unreachable: controller.status == Status::GoalUnreachable,
                margin,
                time: *time,
            });
        }
        closed_loop.step(STEP)?;
    }
}

fn as_text(rows: &[Row]) -> String {
    let mut text = String::from(
        "rig                 cables    area (m²)  tick (µs)  reached  longest (s)  outside named  least margin (N)  weight (N)\n",
    );
    for Row { name, outcome } in rows {
        match outcome {
            Err(why) => text += &format!("{name:<19} refused: {why}\n"),
            Ok(driven) => {
                let count = |inside: bool, good: fn(&Run) -> bool| {
                    let runs = || driven.runs.iter().filter(move |run| run.inside == inside);
                    format!("{}/{}", runs().filter(|run| good(run)).count(), runs().count())
                };
                let longest =
                    driven.runs.iter().filter(|run| run.inside).map(|run| run.time).fold(0.0, f64::max);
                let margin = driven.runs.iter().map(|run| run.margin).fold(f64::INFINITY, f64::min);
                text += &format!(
                    "{name:<19} {:>6} {:>12.3} {:>10.0}  {:>7} {longest:>12.2} {:>14} {margin:>17.3} {:>11.1}\n",
                    driven.cables,
                    driven.area,
                    driven.tick,
                    count(true, |run| run.reached),
                    count(false, |run| run.unreachable),
                    driven.weight
                );
            }
        }
    }
    text
}

fn as_json(rows: &[Row]) -> serde_json::Value {
    let row = |Row { name, outcome }: &Row| match outcome {
        Err(why) => json!({ "rig": name, "refused": why }),
        Ok(driven) => {
            let runs: Vec<_> = driven
                .runs
                .iter()
                .map(|run| {
                    json!({ "goal": run.goal, "inside": run.inside, "reached": run.reached, "unreachable": run.unreachable,
                            "margin": run.margin, "time": run.time })
                })
                .collect();
            json!({ "rig": name, "cables": driven.cables, "area": driven.area, "tickMicroseconds": driven.tick,
                    "weight": driven.weight, "runs": runs })
        }
    };
    json!(rows.iter().map(row).collect::<Vec<_>>())
}
