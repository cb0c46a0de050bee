//! Keeps what a co-simulation shows, column by column.

use super::{CosimError, Master, Variable};

/// Samples chosen variables; Booleans become 0 and 1.
pub struct Recorder {
    variables: Vec<(usize, Variable)>,
    names: Vec<String>,
    times: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Recorder {
    /// Will sample these variables, each named `instance.variable`.
    ///
    /// # Errors
    /// An unknown instance or variable.
    pub fn new(master: &Master, names: Vec<String>) -> Result<Self, CosimError> {
        let variables = names.iter().map(|name| master.resolve(name)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { columns: vec![Vec::new(); names.len()], variables, names, times: Vec::new() })
    }

    /// Adds a row: the values of now.
    ///
    /// # Errors
    /// What an instance reports; the row is then not added.
    pub fn sample(&mut self, master: &Master) -> Result<(), CosimError> {
        let row = self.variables.iter().map(|variable| Ok(master.read(variable)?.as_f64()));
        let row = row.collect::<Result<Vec<_>, CosimError>>()?;
        self.times.push(master.time());
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        Ok(())
    }

    /// Times of the rows, s.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The samples of one variable, in the order of [`times`](Self::times).
    ///
    /// # Errors
    /// [`CosimError::Setup`] if it is not recorded.
    pub fn column(&self, name: &str) -> Result<&[f64], CosimError> {
        match self.names.iter().position(|recorded| recorded == name) {
            Some(index) => Ok(&self.columns[index]),
            None => Err(CosimError::Setup(format!("{name} is not recorded"))),
        }
    }
}
