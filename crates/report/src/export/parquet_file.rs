//! Parquet: the columns of `run.csv` as doubles, with `run.json` and the units as metadata of the file.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use cable_robot_files::read_text;
use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::variables::unit;
use super::{ExportError, Failure, whole};
use crate::run_folder::{RUN_CSV, RUN_JSON, RunFolder, RunFolderError, RunInfo};
use crate::table::{CsvRows, Table};

/// Rows that are in memory at once.
const GROUP: usize = 1 << 14;

/// Writes the rows of a run folder as Parquet; how many there are. `run.csv` is read through a reader of its own.
///
/// # Errors
/// [`ExportError`]; the file that stood there is then untouched.
pub fn parquet<R: Read>(
    folder: &Path,
    file: &Path,
    reader: impl FnOnce(File) -> R,
) -> Result<usize, ExportError> {
    let wrong = |reason| RunFolderError::Csv { path: folder.join(RUN_CSV), reason };
    let (info, rows) = RunFolder::open(folder)?;
    let path = folder.join(RUN_JSON);
    let json = read_text(&path).map_err(|reason| RunFolderError::Read { path, reason })?;
    whole(file, |out| {
        let mut rows = CsvRows::begin(reader(rows)).map_err(wrong)?;
        let mut table = rows.empty();
        let properties = properties(&info, json, table.names());
        let mut writer = SerializedFileWriter::new(out, schema(table.names())?, Arc::new(properties))?;
        let mut count = 0;
        loop {
            let known = table.rows();
            while table.rows() - known < GROUP && rows.next(&mut table).map_err(wrong)? {}
            if table.rows() == known {
                break;
            }
            count += table.rows() - known;
            write_group(&mut writer, &table, known)?;
            table.keep_last();
        }
        writer.close()?;
        Ok(count)
    })
}

fn schema(names: &[String]) -> Result<Arc<Type>, Failure> {
    let column = |name: &String| {
        let column = Type::primitive_type_builder(name, Physical::DOUBLE);
        column.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let columns = names.iter().map(column).collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("run").with_fields(columns).build()?))
}

fn properties(info: &RunInfo, json: String, names: &[String]) -> WriterProperties {
    let units: serde_json::Map<_, _> =
        names.iter().filter_map(|name| Some((name.clone(), unit(name)?.into()))).collect();
    let units = serde_json::Value::from(units).to_string();
    let metadata = [(RUN_JSON, json), ("units", units)];
    WriterProperties::builder()
        .set_created_by(format!("cable-robot {}", info.program_version))
        .set_key_value_metadata(Some(metadata.map(|(key, text)| KeyValue::new(key.to_owned(), text)).into()))
        .build()
}

/// Writes the rows from number `from` on.
fn write_group<W: std::io::Write + Send>(
    file: &mut SerializedFileWriter<W>,
    table: &Table,
    from: usize,
) -> Result<(), Failure> {
    let mut group = file.next_row_group()?;
    let mut columns = table.columns();
    while let (Some(mut column), Some(values)) = (group.next_column()?, columns.next()) {
        column.typed::<DoubleType>().write_batch(&values[from..], None, None)?;
        column.close()?;
    }
    group.close()?;
    Ok(())
}
