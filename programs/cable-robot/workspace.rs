//! `cable-robot workspace`: where the cables can hold the platform at rest within their limits.

pub mod answer;

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use cable_robot::reach::Slice;
use cable_robot::reach::static_region::{Grid, corners};
use cable_robot::robot::{Pose, RigFile};
use cable_robot_report::facts::limits;
use cable_robot_report::files::{probe, write_whole};
use clap::Args;
use nalgebra::{Vector2, Vector3};

use crate::command::arguments::{Heights, angles, finite, heights};
use crate::command::figure::draw;
use crate::command::progress::Progress;
use crate::command::rig::RigArgument;
use crate::command::{Outcome, metres, number, picture, plane, print, print_json};

pub const EXAMPLE: &str = "\
Example: cable-robot workspace --height 0.7 --svg workspace.svg
         cable-robot workspace --heights 0.6,1.4,3 --orientation 0,0,0 --orientation 0,0.1,0 --svg workspace.svg --csv margins.csv
With a rig file, here one that comes with the project: cable-robot workspace --rig rigs/eight.toml --height 2
Exit code 3: the cables hold the platform nowhere at that height and orientation.";

/// Points of the grid along x and along y.
const GRID: usize = 61;
/// Rays to the border.
const RAYS: usize = 360;
/// Slices that are looked at, at most: about a minute.
const MOST_SLICES: usize = 100;
/// What counts as straight, m.
const STRAIGHT: f64 = 1e-6;

/// Heights in sizes of the rig up to which tensions can be told: as far as [`cable_robot::robot::rig::SINGULARITY_THRESHOLD`] lets cables be parallel.
const FARTHEST: f64 = 1e6;
/// Share of the workspace outside the border that is more than what a grid gives for a border of chords.
const WORTH_SAYING: f64 = 5e-3;

#[derive(Args)]
pub struct Workspace {
    #[command(flatten)]
    rig: RigArgument,
    /// z of the centre of mass, m; without it that of the rig's home
    #[arg(long, value_parser = finite, allow_hyphen_values = true)]
    height: Option<f64>,
    /// Several heights, from,to,how many: m, m, at equal distances
    #[arg(long, value_parser = heights, allow_hyphen_values = true, value_name = "FROM,TO,N", conflicts_with = "height")]
    heights: Option<Heights>,
    /// roll,pitch,yaw in rad, R = Rz(yaw) Ry(pitch) Rx(roll); may be given several times
    #[arg(long, value_parser = angles, default_value = "0,0,0", allow_hyphen_values = true)]
    orientation: Vec<[f64; 3]>,
    /// Prints numbers for machines instead of the picture
    #[arg(long)]
    json: bool,
    /// Also draws the workspace into this file, with lines of equal margin, a panel a height and orientation
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Also writes the margins into this file, a row a point: x, y, z (m), roll, pitch, yaw (rad), margin (N, below 0 outside)
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// The workspace at one height and orientation.
pub struct Found {
    /// Corners of its border, m; the part that is seen from `deepest`.
    pub corners: Vec<Vector2<f64>>,
    /// Where the margin is greatest, m and N.
    pub deepest: (Vector2<f64>, f64),
    /// Margins on and around it.
    pub grid: Grid,
    /// m².
    pub area: f64,
    /// Share of the grid's admissible points that lie outside the border.
    pub unseen: f64,
}

impl Workspace {
    pub fn run(&self) -> Result<Outcome> {
        let file = self.rig.read()?;
        let slices = self.slices(&file)?;
        [&self.svg, &self.csv].into_iter().flatten().try_for_each(|path| probe(path))?;
        let progress = Progress::new("looking", (2 * GRID * slices.len()) as u64);
        let look = |slice: Slice<'_>| find(&slice, &file, || progress.done(1));
        let found: Vec<_> = slices.iter().cloned().map(look).collect();
        drop(progress);
        let found: Vec<_> = slices.into_iter().zip(found).collect();
        if let Some(path) = &self.svg {
            draw::write(path, &picture::chart(&file.name, &found))?;
        }
        if let Some(path) = &self.csv {
            write_whole(path, |to| write_csv(&found, to))?;
        }
        match (&found[..], self.json) {
            ([(slice, found)], true) => {
                print_json(&answer::Workspace::new(&file.name, slice, found.as_ref()))?
            }
            ([(slice, found)], false) => print(&as_text(&file.name, slice, found.as_ref()))?,
            (_, true) => print_json(&answer::Stack::new(&file.name, &found))?,
            (_, false) => print(&table(&file, &found))?,
        }
        if found.iter().all(|(_, found)| found.is_none()) {
            return Ok(Outcome::NotReachable);
        }
        found
            .iter()
            .filter_map(|(slice, found)| Some((slice, found.as_ref()?)))
            .for_each(|(s, f)| warn(s, f));
        Ok(Outcome::Done)
    }

    /// Every height with every orientation.
    fn slices<'a>(&self, file: &'a RigFile) -> Result<Vec<Slice<'a>>> {
        let (name, heights) = match self.heights {
            Some(heights) => ("--heights", heights.all().collect()),
            None => ("--height", vec![self.height.unwrap_or(file.home.0[2])]),
        };
        let mut slices = vec![];
        for height in heights {
            for orientation in &self.orientation {
                let slice = Slice { rig: &file.rig, height, angles: Vector3::from(*orientation) };
                let (low, high) = slice.extent();
                let highest = FARTHEST * (high - low).max();
                ensure!(
                    height.abs() <= highest,
                    "{name} {}: the cables are as good as parallel there; at most {} m makes sense for this rig",
                    number(height),
                    number(highest.round())
                );
                slices.push(slice);
            }
        }
        ensure!(
            slices.len() <= MOST_SLICES,
            "--heights and --orientation: {} slices, at most {MOST_SLICES} are looked at",
            slices.len()
        );
        Ok(slices)
    }
}

/// Says what part of a workspace the border leaves out.
fn warn(slice: &Slice, found: &Found) {
    if found.unseen > WORTH_SAYING {
        crate::command::say(format_args!(
            "cable-robot: {}: {:.1} % of the workspace cannot be seen from its deepest point and lie outside the border given",
            plane::level_of(&slice.pose(&Vector2::zeros())),
            100.0 * found.unseen
        ));
    }
}

/// A row a point of each slice's grid.
fn write_csv(slices: &[(Slice, Option<Found>)], to: &mut impl Write) -> std::io::Result<()> {
    writeln!(to, "x,y,z,roll,pitch,yaw,margin")?;
    for (slice, found) in slices {
        for (point, margin) in found.iter().flat_map(|found| found.grid.points()) {
            let place: Vec<_> = slice.pose(&point).0.iter().map(f64::to_string).collect();
            writeln!(to, "{},{margin}", place.join(","))?;
        }
    }
    Ok(())
}

/// A row a slice.
fn table(file: &RigFile, slices: &[(Slice, Option<Found>)]) -> String {
    let mut text = format!("{}: tensions {}\n", file.name, limits(&file.rig));
    text +=
        "    z (m)  roll (rad)      pitch        yaw   area (m²)  greatest margin (N) at x (m)     y (m)\n";
    for (slice, found) in slices {
        let [roll, pitch, yaw] = [0, 1, 2].map(|k| metres(slice.angles[k]));
        let place = format!("{}   {roll}  {pitch}  {yaw}", metres(slice.height));
        let _ = match found {
            Some(Found { area, deepest: (at, margin), .. }) => {
                writeln!(text, "{place}   {area:9.4}  {margin:19.3} {} {}", metres(at.x), metres(at.y))
            }
            None => writeln!(text, "{place}       empty"),
        };
    }
    text
}

/// `None` where the cables cannot hold the platform at any point of the grid, nor at the rig's home.
pub fn find(slice: &Slice, file: &RigFile, row_done: impl Fn() + Sync) -> Option<Found> {
    let coarse = slice.grid(slice.extent(), GRID, &row_done);
    let home = file.home.position().xy();
    let at_home = slice.margin(&home);
    let seed = coarse.best().or((at_home >= 0.0).then_some((home, at_home)))?;

    let border = corners(&slice.boundary(&seed.0, RAYS), STRAIGHT);
    let (low, high) = (bounds(&border, f64::min), bounds(&border, f64::max));
    let frame = (high - low) * 0.05;
    let grid = slice.grid((low - frame, high + frame), GRID, &row_done);
    let admissible = grid.points().filter(|(_, margin)| *margin >= 0.0).count();
    let outside =
        grid.points().filter(|(point, margin)| *margin >= 0.0 && !surrounds(&border, point)).count();
    Some(Found {
        deepest: grid.best().filter(|best| best.1 > seed.1).unwrap_or(seed),
        area: area(&border),
        corners: border,
        unseen: outside as f64 / admissible.max(1) as f64,
        grid,
    })
}

/// The border at the height and orientation of a pose, m.
pub fn border(file: &RigFile, at: &Pose) -> Vec<[f64; 2]> {
    let slice = Slice { rig: &file.rig, height: at.0[2], angles: at.angles() };
    find(&slice, file, || ())
        .map_or(vec![], |found| found.corners.iter().map(|corner| [corner.x, corner.y]).collect())
}

fn bounds(points: &[Vector2<f64>], pick: fn(f64, f64) -> f64) -> Vector2<f64> {
    points.iter().copied().reduce(|a, b| a.zip_map(&b, pick)).unwrap_or_default()
}

/// Consecutive points of the closed line.
fn edges(line: &[Vector2<f64>]) -> impl Iterator<Item = (&Vector2<f64>, &Vector2<f64>)> {
    line.iter().zip(line.iter().cycle().skip(1))
}

fn area(line: &[Vector2<f64>]) -> f64 {
    0.5 * edges(line).map(|(a, b)| a.perp(b)).sum::<f64>().abs()
}

/// Whether a ray from the point along x crosses the line an odd number of times.
fn surrounds(line: &[Vector2<f64>], point: &Vector2<f64>) -> bool {
    let crossed = |(a, b): &(&Vector2<f64>, &Vector2<f64>)| {
        (a.y > point.y) != (b.y > point.y) && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
    };
    edges(line).filter(crossed).count() % 2 == 1
}

fn as_text(name: &str, slice: &Slice, found: Option<&Found>) -> String {
    let (rig, height) = (slice.rig, number(slice.height));
    let mut text = format!("{name}: {} cables, {} kg", rig.cables.len(), number(rig.mass));
    let _ = writeln!(text, ", tensions {}", limits(rig));
    let Some(found) = found else {
        let at_height = Pose::at(0.0, 0.0, slice.height);
        let why = match rig.can_be_at(&at_height) {
            false => "empty, no anchor is above the platform".to_owned(),
            true => format!(
                "nothing found, the cables hold the platform at none of {GRID} x {GRID} points, nor at home"
            ),
        };
        let _ = writeln!(text, "z = {height} m: {why}");
        return text;
    };
    let (deepest, margin) = found.deepest;
    let _ = writeln!(text, "z = {height} m: area {:.4} m²", found.area);
    let _ = writeln!(
        text,
        "greatest margin: {margin:.3} N at ({}, {}), the least distance of a tension to a limit\n",
        metres(deepest.x).trim(),
        metres(deepest.y).trim()
    );
    text += &picture::characters(&found.grid, margin);
    if found.corners.len() <= 24 {
        text += "\ncorners\n     x (m)     y (m)\n";
        for corner in &found.corners {
            let _ = writeln!(text, " {} {}", metres(corner.x), metres(corner.y));
        }
    } else {
        let count = found.corners.len();
        let _ = writeln!(text, "\nborder: {count} points (--json lists them)");
    }
    text
}
