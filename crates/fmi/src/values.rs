//! The values of an instance: one `f64` a value reference, whatever the type.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::error::FmiError;
use super::models::{Interface, Scalar};
use super::variables::{Causality, Kind, Row};
use cable_robot::robot::{Coordinates, PerCable, Pose};

/// All values of one instance, indexed by value reference. Gaps between rows are unused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Values {
    cables: usize,
    numbers: Vec<f64>,
}

impl Values {
    /// Zero for each reference of a table of so many cables.
    pub fn zero(rows: &[&Row], cables: usize) -> Self {
        let references = rows.iter().flat_map(|row| (0..row.count(cables)).map(|k| row.reference(k)));
        let length = references.max().map_or(0, |last| last as usize + 1);
        Self { cables, numbers: vec![0.0; length] }
    }

    /// The same values for a table with more rows; of those they are zero.
    pub fn grown(&self, rows: &[&Row]) -> Self {
        let mut grown = Self::zero(rows, self.cables);
        grown.numbers[..self.numbers.len()].copy_from_slice(&self.numbers);
        grown
    }

    /// Whether an interface has so many values.
    pub fn fits(&self, interface: &Interface) -> bool {
        (self.cables, self.numbers.len()) == (interface.cables(), interface.start().numbers.len())
    }

    /// Checks those that are set from outside as where they are set.
    ///
    /// # Errors
    /// [`FmiError::BadValue`] for the first that is none of its row's type.
    pub fn check(&self, interface: &Interface) -> Result<(), FmiError> {
        let set = |scalar: &Scalar| !matches!(scalar.row.causality, Causality::Output | Causality::Local);
        interface.scalars().filter(set).try_for_each(|scalar| scalar.check(self.at(scalar.reference)))
    }

    /// Whether they are the same numbers, bit for bit.
    pub fn are(&self, others: &Self) -> bool {
        let bits = |number: &f64| number.to_bits();
        self.cables == others.cables && self.numbers.iter().map(bits).eq(others.numbers.iter().map(bits))
    }

    /// The value behind a reference of the table.
    pub fn at(&self, reference: u32) -> f64 {
        self.numbers[reference as usize]
    }

    /// Replaces the value behind a reference of the table.
    pub fn put(&mut self, reference: u32, value: f64) {
        self.numbers[reference as usize] = value;
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
        PerCable::from_fn(self.cables, |i| self.at(row.reference(i)))
    }

    /// A row with x, y, z.
    pub fn vector(&self, row: &Row) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.at(row.first + i as u32))
    }

    /// A pose row.
    pub fn pose(&self, row: &Row) -> Pose {
        Pose(Coordinates::from_fn(|i, _| self.at(row.first + i as u32)))
    }

    /// x, y, z of each cable.
    pub fn cable_vectors(&self, row: &Row) -> PerCable<Vector3<f64>> {
        PerCable::from_fn(self.cables, |i| Vector3::from_fn(|k, _| self.at(row.reference(3 * i + k))))
    }

    /// A symmetric tensor.
    pub fn tensor(&self, row: &Row) -> Matrix3<f64> {
        let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|k| self.at(row.reference(k)));
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Replaces all scalars of a row.
    pub fn write(&mut self, row: &Row, values: impl IntoIterator<Item = f64>) {
        for (position, value) in (0..row.count(self.cables)).zip(values) {
            self.put(row.reference(position), value);
        }
    }

    /// The value as a person reads it: with the name of an enumeration's item.
    pub fn text(&self, row: &Row, reference: u32) -> String {
        let value = self.at(reference);
        match row.kind {
            Kind::Enumeration(kind) => {
                let item = kind.numbered().find(|(number, ..)| f64::from(*number) == value);
                item.map_or_else(|| value.to_string(), |(_, name, _)| name.to_owned())
            }
            Kind::Boolean | Kind::Clock => (value != 0.0).to_string(),
            Kind::Float64 | Kind::Int32 | Kind::String => value.to_string(),
        }
    }
}
