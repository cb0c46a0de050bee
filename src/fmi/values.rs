//! The values of an instance: one `f64` a value reference, whatever the type.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::variables::{Causality, Kind, Row};
use crate::robot::{Coordinates, PerCable, Pose};

/// All values of one instance, indexed by value reference. Gaps between rows are unused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Values(Vec<f64>);

impl Values {
    /// The start values of a table; outputs are zero until they are calculated.
    pub fn new(rows: &[&Row]) -> Self {
        let length = rows.iter().map(|row| row.references().end).max().unwrap_or(0);
        let mut values = Self(vec![0.0; length as usize]);
        for row in rows {
            for reference in row.references() {
                values.put(reference, row.start_of(reference).unwrap_or(0.0));
            }
        }
        values
    }

    /// Whether this can be the values of a table: the right number of them, and finite where they were set.
    pub fn fits(&self, rows: &[&Row]) -> bool {
        let mut set =
            rows.iter().filter(|row| row.causality != Causality::Output).flat_map(|row| row.references());
        self.0.len() == Self::new(rows).0.len() && set.all(|reference| self.at(reference).is_finite())
    }

    /// The value behind a reference of the table.
    pub fn at(&self, reference: u32) -> f64 {
        self.0[reference as usize]
    }

    /// Replaces the value behind a reference of the table.
    pub fn put(&mut self, reference: u32, value: f64) {
        self.0[reference as usize] = value;
    }

    /// A scalar row.
    pub fn scalar(&self, row: &Row) -> f64 {
        self.at(row.first)
    }

    /// A Boolean scalar row.
    pub fn boolean(&self, row: &Row) -> bool {
        self.scalar(row) != 0.0
    }

    /// An integer or enumeration row.
    pub fn integer(&self, row: &Row) -> i32 {
        self.scalar(row) as i32
    }

    /// A row of one value a cable.
    pub fn cables(&self, row: &Row) -> PerCable<f64> {
        std::array::from_fn(|i| self.at(row.first + i as u32))
    }

    /// A row with x, y, z.
    pub fn vector(&self, row: &Row) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.at(row.first + i as u32))
    }

    /// A pose row.
    pub fn pose(&self, row: &Row) -> Pose {
        Pose(Coordinates::from_fn(|i, _| self.at(row.first + i as u32)))
    }

    /// Replaces all scalars of a row.
    pub fn write(&mut self, row: &Row, values: impl IntoIterator<Item = f64>) {
        for (reference, value) in row.references().zip(values) {
            self.put(reference, value);
        }
    }

    /// The value as a person reads it: with the name of an enumeration's item.
    pub fn text(&self, row: &Row, reference: u32) -> String {
        let value = self.at(reference);
        match row.kind {
            Kind::Enumeration(kind) => kind.items[value as usize - 1].0.to_owned(),
            Kind::Boolean => (value != 0.0).to_string(),
            Kind::Float64 | Kind::Int32 => value.to_string(),
        }
    }
}
