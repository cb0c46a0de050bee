//! Columns of numbers with names, and the CSV file they make.

use std::collections::HashSet;
use std::io::{self, Read, Write};

use thiserror::Error;

use super::limits::{MOST_COLUMNS, MOST_NUMBERS};
use cable_robot_files::Lines;

/// Times are at most this far from 0, s: thirty years.
const LONGEST: f64 = 1e9;

/// Bytes of a row that go into the file at once: three hundred columns have fewer than ten thousand.
const LONGEST_ROW: usize = 1 << 16;

/// Columns of one length, each with its name; the first is `time` (s).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

/// What is wrong with a CSV file. Lines and columns are counted from 1; the header is line 1.
#[derive(Debug, Error)]
pub enum TableError {
    /// The file cannot be read, or is not CSV: a row of another length, text that is not UTF-8.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// The header does not start with `time`.
    #[error("line 1: the first column is {found:?}; it must be \"time\"")]
    NoTime {
        /// What stands there.
        found: String,
    },
    /// Two columns of one name.
    #[error("line 1: there are two columns {name:?}")]
    Twice {
        /// The name.
        name: String,
    },
    /// More columns than any run has.
    #[error("line 1: there are {count} columns; at most {MOST_COLUMNS} are read")]
    TooManyColumns {
        /// How many.
        count: usize,
    },
    /// More than fits into memory.
    #[error("line {line}: more than {MOST_NUMBERS} numbers, the most that are read")]
    TooManyNumbers {
        /// Line of the file.
        line: u64,
    },
    /// A column that is needed is not there.
    #[error("line 1: there is no column {name:?}")]
    Missing {
        /// The name looked for.
        name: String,
    },
    /// A field that holds no number.
    #[error("line {line}, column {column} ({name}): {text:?} is not a finite number")]
    NotANumber {
        /// Line of the file.
        line: u64,
        /// Number of the column.
        column: usize,
        /// Its name.
        name: String,
        /// What stands there.
        text: String,
    },
    /// Times that do not grow.
    #[error("line {line}: time = {time} does not come after {before}, the time of the row before")]
    Order {
        /// Line of the file.
        line: u64,
        /// s.
        time: f64,
        /// s.
        before: f64,
    },
    /// A time that no run lasts.
    #[error("line {line}: time = {time:e} is not allowed: it must be from {} to {LONGEST} s", -LONGEST)]
    Time {
        /// Line of the file.
        line: u64,
        /// s.
        time: f64,
    },
    /// A header and nothing else.
    #[error("there is no row below the header; a run has at least one")]
    Empty,
}

impl Table {
    /// An empty table: `time` and these columns.
    pub fn new(names: impl IntoIterator<Item = String>) -> Self {
        let names: Vec<_> = std::iter::once("time".to_owned()).chain(names).collect();
        Self { columns: vec![Vec::new(); names.len()], names }
    }

    /// Adds a row: the time (s) and a value for each other column, in their order.
    ///
    /// # Panics
    /// If there are more or fewer values than columns.
    pub fn push(&mut self, time: f64, values: &[f64]) {
        assert_eq!(values.len() + 1, self.names.len(), "a value for each column");
        let row = std::iter::once(&time).chain(values);
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
    }

    /// Names of the columns, `time` first.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// The column of this name, if there is one.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[index])
    }

    /// The column of this name.
    ///
    /// # Errors
    /// [`TableError::Missing`].
    pub fn column(&self, name: &str) -> Result<&[f64], TableError> {
        self.get(name).ok_or_else(|| TableError::Missing { name: name.to_owned() })
    }

    /// Takes out the columns of these names.
    pub fn drop_columns(&mut self, names: &[String]) {
        let (all, columns) = (std::mem::take(&mut self.names), std::mem::take(&mut self.columns));
        let kept = all.into_iter().zip(columns).filter(|(name, _)| !names.contains(name));
        (self.names, self.columns) = kept.unzip();
    }

    /// Writes CSV: the names, then a line a row, every number in full.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_csv(&self, writer: impl Write) -> Result<(), csv::Error> {
        let mut rows = Rows::begin(writer, &self.names)?;
        for row in 0..self.rows() {
            let numbers: Vec<_> = self.columns.iter().map(|column| column[row]).collect();
            rows.add(&numbers)?;
        }
        Ok(rows.flush()?)
    }

    /// Reads what [`write_csv`](Self::write_csv) wrote; columns may stand in any order, `time` first.
    ///
    /// # Errors
    /// [`TableError`] with line and column.
    pub fn read_csv(reader: impl Read) -> Result<Self, TableError> {
        let mut rows = CsvRows::begin(reader)?;
        let mut table = rows.empty();
        while rows.next(&mut table)? {}
        Ok(table)
    }

    /// The same columns, without a row.
    pub fn empty(&self) -> Self {
        Self::new(self.names[1..].iter().cloned())
    }

    /// Takes out all rows but the last.
    pub fn keep_last(&mut self) {
        let gone = self.rows().saturating_sub(1);
        self.columns.iter_mut().for_each(|column| drop(column.drain(..gone)));
    }

    /// All columns, in their order.
    #[cfg(feature = "export")]
    pub(super) fn columns(&self) -> impl Iterator<Item = &[f64]> {
        self.columns.iter().map(Vec::as_slice)
    }

    /// The last row, in the order of the columns; nothing of an empty table.
    #[cfg(feature = "export")]
    pub(super) fn last_row(&self) -> Vec<f64> {
        self.columns.iter().filter_map(|column| column.last().copied()).collect()
    }

    /// Adds row number `row`, from 0, of a table with the same columns.
    pub fn push_of(&mut self, other: &Self, row: usize) {
        self.columns.iter_mut().zip(&other.columns).for_each(|(column, from)| column.push(from[row]));
    }

    /// Adds a row of text.
    fn take(&mut self, record: &csv::StringRecord) -> Result<(), TableError> {
        let line = record.position().map_or(0, csv::Position::line);
        let before = self.columns[0].last().copied();
        for (k, text) in record.iter().enumerate() {
            let number: Option<f64> = text.trim().parse().ok();
            let Some(value) = number.filter(|value| value.is_finite()) else {
                let (name, text) = (self.names[k].clone(), text.to_owned());
                return Err(TableError::NotANumber { line, column: k + 1, name, text });
            };
            self.columns[k].push(value);
        }
        let time = self.columns[0].last().copied();
        match (before, time) {
            (_, Some(time)) if time.abs() > LONGEST => Err(TableError::Time { line, time }),
            (Some(before), Some(time)) if time <= before => Err(TableError::Order { line, time, before }),
            _ => Ok(()),
        }
    }
}

/// A table's CSV, read row by row.
pub struct CsvRows<R> {
    csv: csv::Reader<Lines<R>>,
    record: csv::StringRecord,
    names: Vec<String>,
    /// Read so far.
    rows: usize,
}

impl<R: Read> CsvRows<R> {
    /// Reads the names.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn begin(reader: R) -> Result<Self, TableError> {
        let mut csv = csv::Reader::from_reader(Lines::new(reader));
        let names: Vec<String> = csv.headers()?.iter().map(str::to_owned).collect();
        let first = names.first().cloned().unwrap_or_default();
        if first != "time" {
            return Err(TableError::NoTime { found: first });
        }
        if names.len() > MOST_COLUMNS {
            return Err(TableError::TooManyColumns { count: names.len() });
        }
        let mut known = HashSet::new();
        if let Some(name) = names.iter().find(|name| !known.insert(*name)) {
            return Err(TableError::Twice { name: name.clone() });
        }
        Ok(Self { csv, record: csv::StringRecord::new(), names, rows: 0 })
    }

    /// A table of its columns, without a row.
    pub fn empty(&self) -> Table {
        Table::new(self.names[1..].iter().cloned())
    }

    /// Adds the next row to a table of the same columns, whose last is the row before; `false` at the end.
    ///
    /// # Errors
    /// [`TableError`] with line and column.
    pub fn next(&mut self, table: &mut Table) -> Result<bool, TableError> {
        if !self.csv.read_record(&mut self.record)? {
            return if self.rows == 0 { Err(TableError::Empty) } else { Ok(false) };
        }
        table.take(&self.record)?;
        self.rows += 1;
        if self.rows * self.names.len() > MOST_NUMBERS {
            return Err(TableError::TooManyNumbers { line: self.csv.position().line() });
        }
        Ok(true)
    }
}

/// A table's CSV, written as its rows come.
pub struct Rows<W: Write> {
    csv: csv::Writer<W>,
}

impl<W: Write> Rows<W> {
    /// Writes the names.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn begin(writer: W, names: &[String]) -> Result<Self, csv::Error> {
        let mut csv = csv::WriterBuilder::new().buffer_capacity(LONGEST_ROW).from_writer(writer);
        csv.write_record(names)?;
        Ok(Self { csv })
    }

    /// Writes a row, which [`flush`](Self::flush) brings to its reader.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn add(&mut self, row: &[f64]) -> Result<(), csv::Error> {
        self.csv.serialize(row)
    }

    /// Nothing waits in this process any more.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn flush(&mut self) -> io::Result<()> {
        self.csv.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        Table::read_csv(text.as_bytes()).expect_err(text).to_string()
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit() {
        let mut table = Table::new(["a".to_owned(), "b,\"c\"".to_owned()]);
        table.push(0.0, &[0.1 + 0.2, -0.0]);
        table.push(1e-3, &[f64::MIN_POSITIVE, 1.0 / 3.0]);
        let mut text = vec![];
        table.write_csv(&mut text).unwrap();
        assert_eq!(Table::read_csv(text.as_slice()).unwrap(), table);
        assert_eq!(table.column("a").unwrap()[0], 0.1 + 0.2);
        assert!(table.column("c").unwrap_err().to_string().contains("no column \"c\""));
    }

    #[test]
    fn columns_without_number_are_refused_with_theirs() {
        let names: Vec<_> = (0..100_000).map(|k| format!("c{k}")).collect();
        let said = refusal(&format!("time,{}\n", names.join(",")));
        assert_eq!(said, "line 1: there are 100001 columns; at most 10000 are read");
        let most = format!("time,{}\n0{}\n", names[..9999].join(","), ",1".repeat(9999));
        assert_eq!(Table::read_csv(most.as_bytes()).unwrap().names().len(), 10_000);
    }

    /// As of a file with holes, which has no content and ten gigabytes.
    #[test]
    fn a_line_without_end_is_refused_with_the_number_of_bytes() {
        for before in ["", "time,a\n0,1\n"] {
            let endless = before.as_bytes().chain(io::repeat(0));
            let said = Table::read_csv(endless).expect_err("endless").to_string();
            assert!(said.contains("a line has more than 1048576 bytes, the most that are read"), "{said}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_line_and_column() {
        assert_eq!(refusal("x,y\n1,2\n"), "line 1: the first column is \"x\"; it must be \"time\"");
        assert_eq!(refusal(""), "line 1: the first column is \"\"; it must be \"time\"");
        assert_eq!(refusal("time,a,a\n0,1,2\n"), "line 1: there are two columns \"a\"");
        assert_eq!(refusal("time,a\n"), "there is no row below the header; a run has at least one");
        let word = refusal("time,a\n0,1\n1,fast\n");
        assert_eq!(word, "line 3, column 2 (a): \"fast\" is not a finite number");
        assert!(refusal("time,a\n0,NaN\n").starts_with("line 2, column 2 (a): \"NaN\""));
        assert!(refusal("time,a\n0,1\n1\n").contains("line: 3"), "{}", refusal("time,a\n0,1\n1\n"));
        let back = refusal("time\n0\n2\n1\n");
        let far = refusal("time\n0\n1e305\n");
        assert!(
            far.starts_with("line 3: time = 1") && far.ends_with("from -1000000000 to 1000000000 s"),
            "{far}"
        );
        assert_eq!(back, "line 4: time = 1 does not come after 2, the time of the row before");
    }
}
