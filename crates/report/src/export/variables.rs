//! The columns of a run as JSON: what stands together, its units and words.

use serde::ser::{Serialize, Serializer};
use serde_json::{Value, json};

use cable_robot::robot::MOST_CABLES;
use cable_robot_fmi::models::{controller, plant};
use cable_robot_fmi::variables::{Kind, Row};

/// The variable that a column holds, and which of its scalars; `None` of a column that is none of ours.
fn variable(column: &str) -> Option<(&'static Row, usize)> {
    let (model, scalar) = column.split_once('.')?;
    let rows = match model {
        "plant" => plant::ROWS,
        "controller" => controller::ROWS,
        _ => return None,
    };
    let of_this_name = rows.iter().filter(|row| scalar.starts_with(row.name));
    of_this_name.copied().find_map(|row| {
        let position = (0..row.count(MOST_CABLES)).find(|k| row.scalar_name(*k) == scalar);
        position.map(|position| (row, position))
    })
}

/// The unit of a column, if it has one.
pub fn unit(column: &str) -> Option<&'static str> {
    if column == "time" {
        return Some("s");
    }
    variable(column).and_then(|(row, position)| row.unit_of(position)).map(|unit| unit.name)
}

/// What a column is, with its unit.
fn words(column: &str) -> String {
    let Some((row, _)) = variable(column) else { return format!("Column {column}") };
    let unit = unit(column).map_or(String::new(), |unit| format!(", {unit}"));
    let names = match row.kind {
        Kind::Enumeration(of) => {
            let items: Vec<_> = of.numbered().map(|(number, name, _)| format!("{number} {name}")).collect();
            format!(": {}", items.join(", "))
        }
        _ => String::new(),
    };
    format!("{}{unit}{names}", row.description)
}

fn is_boolean(column: &str) -> bool {
    variable(column).is_some_and(|(row, _)| matches!(row.kind, Kind::Boolean))
}

/// The columns of one model: a message a row.
pub struct Group {
    /// `plant`, `controller`; `run` for what is neither's.
    pub name: String,
    fields: Vec<Field>,
}

/// A variable: the columns whose names differ in what comes behind it.
struct Field {
    name: String,
    /// Of the first column, but for its unit in case the others have another.
    column: String,
    is_boolean: bool,
    members: Members,
}

/// Columns, by their place in the table.
enum Members {
    /// `status`
    One(usize),
    /// `goalPose.x`: name and column of each.
    Named(Vec<(String, usize, String)>),
    /// `motorTension[1]`
    Each(Vec<usize>),
}

/// The groups of a table with these columns, in their order; each begins with the time.
pub fn groups(names: &[String]) -> Vec<Group> {
    let mut groups: Vec<Group> = vec![];
    for (place, column) in names.iter().enumerate().skip(1) {
        let (model, scalar) = column.split_once('.').unwrap_or(("run", column));
        let k = groups.iter().position(|group| group.name == model).unwrap_or_else(|| {
            groups.push(Group { name: model.to_owned(), fields: vec![] });
            groups.len() - 1
        });
        groups[k].add(scalar, place, column);
    }
    groups
}

impl Group {
    fn add(&mut self, scalar: &str, place: usize, column: &str) {
        let (name, member) = match (scalar.split_once('.'), scalar.split_once('[')) {
            (Some((name, member)), None) => {
                (name, Members::Named(vec![(member.to_owned(), place, column.to_owned())]))
            }
            (None, Some((name, _))) => (name, Members::Each(vec![place])),
            _ => (scalar, Members::One(place)),
        };
        let known = self.fields.iter_mut().find(|field| field.name == name).map(|field| &mut field.members);
        match (known, member) {
            (Some(Members::Named(all)), Members::Named(one)) => all.extend(one),
            (Some(Members::Each(all)), Members::Each(one)) => all.extend(one),
            (_, members) => {
                let (name, column) = (name.to_owned(), column.to_owned());
                self.fields.push(Field { name, is_boolean: is_boolean(&column), column, members });
            }
        }
    }

    /// A row's message.
    pub fn message<'a>(&'a self, row: &'a [f64]) -> impl Serialize + 'a {
        Message { group: self, row }
    }

    /// JSON Schema of the messages.
    pub fn schema(&self) -> Value {
        let time = ("time".to_owned(), json!({ "type": "number", "description": "Time of the run, s" }));
        let fields = self.fields.iter().map(|field| (field.name.clone(), field.schema()));
        let properties: serde_json::Map<String, Value> = [time].into_iter().chain(fields).collect();
        json!({ "title": self.name, "type": "object", "properties": properties })
    }
}

impl Field {
    fn schema(&self) -> Value {
        let kind = if self.is_boolean { "boolean" } else { "number" };
        match &self.members {
            Members::One(_) => json!({ "type": kind, "description": words(&self.column) }),
            Members::Each(_) => json!({
                "type": "array",
                "items": { "type": kind },
                "description": format!("{}; item 0 is cable 1", words(&self.column)),
            }),
            Members::Named(all) => {
                let member = |(name, _, column): &(String, usize, String)| {
                    (name.clone(), json!({ "type": kind, "description": words(column) }))
                };
                let properties: serde_json::Map<String, Value> = all.iter().map(member).collect();
                json!({ "type": "object", "properties": properties })
            }
        }
    }

    fn value(&self, row: &[f64]) -> Value {
        let one = |place: usize| if self.is_boolean { json!(row[place] != 0.0) } else { json!(row[place]) };
        match &self.members {
            Members::One(place) => one(*place),
            Members::Each(all) => all.iter().map(|place| one(*place)).collect(),
            Members::Named(all) => all.iter().map(|(name, place, _)| (name.clone(), one(*place))).collect(),
        }
    }
}

struct Message<'a> {
    group: &'a Group,
    row: &'a [f64],
}

impl Serialize for Message<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let fields = self.group.fields.iter().map(|field| (field.name.as_str(), field.value(self.row)));
        serializer.collect_map([("time", json!(self.row[0]))].into_iter().chain(fields))
    }
}
