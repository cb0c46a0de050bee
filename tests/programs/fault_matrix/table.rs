//! The table that is printed.

use std::collections::BTreeMap;

use cable_robot_fieldbus::Nanoseconds;

/// What was seen.
pub struct Row {
    /// What failed.
    pub name: String,
    /// The stated time in which the controller's tensions end.
    pub stated: String,
    /// What it took; `None` if they did not end.
    pub ended: Option<Nanoseconds>,
    /// When the safe output was reached.
    pub safe: Option<Nanoseconds>,
    /// The longest that a motor followed a command without a newer one.
    pub oldest: Option<Nanoseconds>,
    /// Where the platform is once the program has ended, and how fast it came there.
    pub down: String,
    /// The drives in the end, before the program ended.
    pub drives: String,
    /// Of the program; `None` if it was killed.
    pub exit: Option<i32>,
    /// What the log says first.
    pub line: String,
}

/// `1 Fault, 5 Operation enabled`.
pub fn count(states: impl IntoIterator<Item = String>) -> String {
    let mut counts = BTreeMap::new();
    states.into_iter().for_each(|state| *counts.entry(state).or_insert(0) += 1);
    counts.iter().map(|(state, count)| format!("{count} {state}")).collect::<Vec<_>>().join(", ")
}

/// As Markdown, so that it can stand in docs/rig.md.
pub fn print(rows: &[Row]) {
    println!(
        "| fault | stated | controller's tensions end | safe output | oldest command | drives | in the end | exit | log |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for row in rows {
        let time = |time: Option<Nanoseconds>| {
            time.map_or("-".to_owned(), |time| format!("{:.0} ms", time as f64 * 1e-6))
        };
        let exit = row.exit.map_or("killed".to_owned(), |code| code.to_string());
        println!(
            "| {} | {} | {} | {} | {} | {} | {} | {exit} | {} |",
            row.name,
            row.stated,
            time(row.ended),
            time(row.safe),
            time(row.oldest),
            row.drives,
            row.down,
            row.line
        );
    }
}
