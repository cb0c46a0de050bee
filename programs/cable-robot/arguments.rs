//! Arguments that several commands share.

use cable_robot::plan::PlannerKind;
use cable_robot::robot::{Coordinates, Pose};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Reads `x,y,z` or `x,y,z,roll,pitch,yaw`.
pub fn pose(text: &str) -> Result<Pose, String> {
    let numbers = numbers(text)?;
    if numbers.len() != 3 && numbers.len() != 6 {
        let count = numbers.len();
        return Err(format!("{count} numbers given; a pose is x,y,z (m) or x,y,z,roll,pitch,yaw (m, rad)"));
    }
    numbers[3..].iter().try_for_each(|angle| radians(*angle))?;
    let mut pose = Coordinates::zeros();
    pose.as_mut_slice()[..numbers.len()].copy_from_slice(&numbers);
    Ok(Pose(pose))
}

/// Reads `x,y`.
pub fn place(text: &str) -> Result<[f64; 2], String> {
    let numbers = numbers(text)?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("{count} numbers given; a place is x,y (m)"))
}

/// Reads `roll,pitch,yaw`.
pub fn angles(text: &str) -> Result<[f64; 3], String> {
    let numbers = numbers(text)?;
    let count = numbers.len();
    numbers.iter().try_for_each(|angle| radians(*angle))?;
    numbers.try_into().map_err(|_| format!("{count} numbers given; an orientation is roll,pitch,yaw (rad)"))
}

/// Most slices of a stack.
const MOST_HEIGHTS: f64 = 100.0;

/// Heights at equal distances, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heights {
    pub from: f64,
    pub to: f64,
    pub count: usize,
}

impl Heights {
    pub fn all(self) -> impl Iterator<Item = f64> {
        let step = (self.to - self.from) / (self.count - 1) as f64;
        (0..self.count).map(move |k| if k + 1 == self.count { self.to } else { self.from + step * k as f64 })
    }
}

/// Reads `from,to,count`.
pub fn heights(text: &str) -> Result<Heights, String> {
    let [from, to, count] = numbers(text)?.try_into().map_err(|numbers: Vec<f64>| {
        format!("{} numbers given; heights are from,to,how many (m, m, 2 to {MOST_HEIGHTS})", numbers.len())
    })?;
    if count.fract() != 0.0 || !(2.0..=MOST_HEIGHTS).contains(&count) {
        return Err(format!("{count} heights: a whole number from 2 to {MOST_HEIGHTS} is wanted"));
    }
    Ok(Heights { from, to, count: count as usize })
}

/// More than a turn is no orientation that anybody means, but perhaps degrees.
fn radians(angle: f64) -> Result<(), String> {
    let ok = angle.abs() <= std::f64::consts::TAU;
    if ok { Ok(()) } else { Err(format!("{angle}: angles are in radians, at most a turn (6.2832) each way")) }
}

/// Reads a bound of what a model may be wrong by.
pub fn bound(text: &str) -> Result<f64, String> {
    let bound = finite(text)?;
    if bound >= 0.0 { Ok(bound) } else { Err(format!("{text}: must be 0 or greater")) }
}

/// Reads a bound of a relative error.
pub fn share(text: &str) -> Result<f64, String> {
    let share = bound(text)?;
    if share < 1.0 { Ok(share) } else { Err(format!("{text}: a relative error below 1")) }
}

/// Reads the rates of the six coordinates.
pub fn rates(text: &str) -> Result<Coordinates, String> {
    six(text, "rates are six (m/s, rad/s)")
}

/// Reads their accelerations.
pub fn accelerations(text: &str) -> Result<Coordinates, String> {
    six(text, "accelerations are six (m/s², rad/s²)")
}

fn six(text: &str, wanted: &str) -> Result<Coordinates, String> {
    let numbers = numbers(text)?;
    let count = numbers.len();
    let six: [f64; 6] = numbers.try_into().map_err(|_| format!("{count} numbers given; {wanted}"))?;
    Ok(six.into())
}

/// Reads a finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| format!("{text:?} is not a number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{text} is not a finite number")) }
}

/// Reads a duration or a step, s.
pub fn seconds(text: &str) -> Result<f64, String> {
    let seconds = finite(text)?;
    if seconds > 0.0 { Ok(seconds) } else { Err(format!("{text} s: must be greater than 0")) }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(finite).collect()
}

/// Reads the name of a planner.
pub fn planner() -> impl TypedValueParser<Value = PlannerKind> {
    let item = |kind: PlannerKind| PossibleValue::new(kind.key()).help(kind.described().1);
    PossibleValuesParser::new(PlannerKind::ALL.map(item))
        .try_map(|key| PlannerKind::named(&key).ok_or_else(|| format!("{key:?} is no planner")))
}
