//! Fields of a scenario that are set on the command line.

use std::str::FromStr;

use anyhow::{Context, Result, anyhow, ensure};
use toml::{Table, Value};

/// A field of a scenario file, with its value: `controller.lambda=8`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// As given.
    pub name: String,
    pub value: Value,
}

/// A field with several values: `controller.lambda=3,5,8`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    name: String,
    values: Vec<Value>,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = parts(text)?;
        Ok(Self { name, value: value_of(&value) })
    }
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, values) = parts(text)?;
        Ok(Self { name, values: values.split(',').map(|value| value_of(value.trim())).collect() })
    }
}

fn parts(text: &str) -> Result<(String, String), String> {
    match text.split_once('=').map(|(name, value)| (name.trim(), value.trim())) {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => {
            Ok((name.to_owned(), value.to_owned()))
        }
        _ => Err("a field and its value are wanted, such as controller.lambda=8".to_owned()),
    }
}

/// As TOML has it; a word that is none is a text, so that `exact` needs no quotes.
fn value_of(text: &str) -> Value {
    let read = toml::from_str::<Table>(&format!("value = {text}")).ok();
    read.and_then(|mut table| table.remove("value")).unwrap_or_else(|| Value::String(text.to_owned()))
}

/// Every combination of the values, the last field changing fastest.
pub fn combinations(sweeps: &[Sweep]) -> Vec<Vec<Setting>> {
    sweeps.iter().fold(vec![vec![]], |before, sweep| {
        let with = |settings: &Vec<Setting>, value: &Value| {
            let setting = Setting { name: sweep.name.clone(), value: value.clone() };
            settings.iter().cloned().chain([setting]).collect()
        };
        before.iter().flat_map(|settings| sweep.values.iter().map(|value| with(settings, value))).collect()
    })
}

/// The text of a scenario file with these fields set; its lines are others then.
pub fn applied(text: &str, settings: &[Setting]) -> Result<String> {
    let mut file: Table = toml::from_str(text)?;
    for setting in settings {
        set(&mut file, setting).with_context(|| format!("--set {}={}", setting.name, setting.value))?;
    }
    Ok(toml::to_string(&file)?)
}

fn set(file: &mut Table, Setting { name, value }: &Setting) -> Result<()> {
    let (tables, field) = name.rsplit_once('.').unwrap_or(("", name));
    ensure!(!field.is_empty(), "{name} names no field: one is wanted, such as controller.lambda");
    let mut table = file;
    for part in tables.split('.').filter(|part| !part.is_empty()) {
        let inner = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
        table =
            inner.as_table_mut().ok_or_else(|| anyhow!("{part} has no fields that can be set one by one"))?;
    }
    table.insert(field.to_owned(), value.clone());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_set_in_tables_that_are_there_and_in_new_ones() {
        let file = "title = \"A\"\n[controller]\nlambda = 3.0\neta = 3.0\n";
        let set = |settings: &[&str]| {
            let settings: Vec<Setting> = settings.iter().map(|setting| setting.parse().unwrap()).collect();
            toml::from_str::<Table>(&applied(file, &settings).unwrap()).unwrap()
        };
        let found = set(&[
            "controller.lambda=8",
            "imperfections.friction = 0.2",
            "controller.planner=exact",
            "start=[0,0,1]",
        ]);
        assert_eq!(found["controller"]["lambda"], Value::Integer(8));
        assert_eq!(found["controller"]["eta"], Value::Float(3.0));
        assert_eq!(found["controller"]["planner"], Value::String("exact".into()));
        assert_eq!(found["imperfections"]["friction"], Value::Float(0.2));
        assert_eq!(found["start"].as_array().unwrap().len(), 3);
        assert!(applied(file, &["title.short=1".parse().unwrap()]).is_err());
        assert!("controller.lambda".parse::<Setting>().is_err() && "=3".parse::<Setting>().is_err());
    }

    #[test]
    fn sweeps_make_every_combination() {
        let sweeps = ["a=1,2", "b=x, y,z"].map(|sweep| sweep.parse().unwrap());
        let all = combinations(&sweeps);
        assert_eq!(all.len(), 6);
        assert_eq!(all[1][0].value, Value::Integer(1));
        assert_eq!(all[1][1].value, Value::String("y".into()));
        assert_eq!(combinations(&[]), [vec![]]);
    }
}
