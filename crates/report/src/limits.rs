//! How much is read from files; more is refused with its number.

/// Columns of a table; of sixteen cables a run has some 300.
pub const MOST_COLUMNS: usize = 10_000;
/// Numbers in a table: a million rows of sixteen cables are 3e8.
pub const MOST_NUMBERS: usize = 500_000_000;
