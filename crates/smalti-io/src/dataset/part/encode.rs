//! Encoding of columns as a Parquet file.

use std::sync::Arc;

use parquet::basic::{Compression, Encoding};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterVersion};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::ColumnPath;

use super::super::error::DatasetError;
use super::super::manifest::Manifest;
use super::super::schema::{self, Column, ColumnKind, ColumnSpec};
use super::marks;

/// Parquet definition levels of a list element: empty list, null, and value.
const EMPTY: i16 = 0;
const NULL: i16 = 1;
const VALUE: i16 = 2;

/// Encodes a part. The bytes depend only on the manifest, the chunk and the values.
///
/// # Errors
/// When the columns do not match the plan or the number of trials in the chunk, or exceed a limit.
pub fn encode(manifest: &Manifest, chunk: u64, columns: &[Column]) -> Result<Vec<u8>, DatasetError> {
    schema::check_columns(&manifest.plan.schema, manifest.plan.rows(chunk), chunk, columns)?;
    let failed = |message: String| DatasetError::Encode { chunk, message };
    let mut bytes = file(manifest, chunk, columns).map_err(|e| failed(e.to_string()))?;
    marks::seal(&mut bytes).map_err(|e| failed(e.to_string()))?;
    Ok(bytes)
}

/// As [`encode`], but without checks, and with zeros in place of the hash.
pub(super) fn file(manifest: &Manifest, chunk: u64, columns: &[Column]) -> Result<Vec<u8>, ParquetError> {
    let schema = super::schema::parquet(&manifest.plan.schema)?;
    let properties = properties(&manifest.plan.schema, manifest, chunk);
    let mut writer = SerializedFileWriter::new(Vec::new(), schema.root_schema_ptr(), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut target) = group.next_column()? else { break };
        write(column, &mut target)?;
        target.close()?;
    }
    group.close()?;
    writer.into_inner()
}

/// Sets every property that affects the bytes, so that a changed default of the library does not alter them.
fn properties(specs: &[ColumnSpec], manifest: &Manifest, chunk: u64) -> WriterProperties {
    let pairs = marks::pairs(manifest, chunk);
    let mut builder = WriterProperties::builder()
        .set_created_by(concat!("smalti version ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(
            pairs.into_iter().map(|(key, value)| KeyValue::new(key.to_owned(), value)).collect(),
        ))
        .set_writer_version(WriterVersion::PARQUET_1_0)
        .set_compression(Compression::SNAPPY)
        .set_encoding(Encoding::PLAIN)
        .set_dictionary_enabled(false)
        .set_dictionary_page_size_limit(1 << 20)
        .set_data_page_size_limit(1 << 20)
        .set_data_page_row_count_limit(1 << 16)
        .set_write_batch_size(1024)
        .set_max_row_group_row_count(None)
        .set_max_row_group_bytes(None)
        // With the minimum and maximum of each part, readers of a few trials can skip the other parts.
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_statistics_truncate_length(Some(64))
        .set_offset_index_disabled(true);
    for spec in specs {
        let path = ColumnPath::from(spec.name.as_str());
        builder = match spec.kind {
            // Trial numbers are consecutive, so that their differences take hardly any space.
            ColumnKind::Int => builder.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED),
            ColumnKind::Text => builder.set_column_dictionary_enabled(path, true),
            ColumnKind::Float | ColumnKind::Floats => builder,
        };
    }
    builder.build()
}

fn write(column: &Column, target: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
    match (column, target.untyped()) {
        (Column::Int(values), ColumnWriter::Int64ColumnWriter(out)) => out.write_batch(values, None, None),
        (Column::Float(values), ColumnWriter::DoubleColumnWriter(out)) => {
            let levels: Vec<i16> = values.iter().map(|v| i16::from(!v.is_nan())).collect();
            let values: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
            out.write_batch(&values, Some(&levels), None)
        }
        (Column::Text(values), ColumnWriter::ByteArrayColumnWriter(out)) => {
            let values: Vec<ByteArray> = values.iter().map(|v| ByteArray::from(v.as_str())).collect();
            out.write_batch(&values, None, None)
        }
        (Column::Floats(lists), ColumnWriter::DoubleColumnWriter(out)) => {
            let (mut levels, mut repeats) = (Vec::new(), Vec::new());
            for list in lists {
                if list.is_empty() {
                    levels.push(EMPTY);
                    repeats.push(0);
                }
                for (i, value) in list.iter().enumerate() {
                    levels.push(if value.is_nan() { NULL } else { VALUE });
                    repeats.push(i16::from(i > 0));
                }
            }
            let values: Vec<f64> = lists.iter().flatten().copied().filter(|v| !v.is_nan()).collect();
            out.write_batch(&values, Some(&levels), Some(&repeats))
        }
        _ => Err(ParquetError::General("the type of a column differs from the schema".into())),
    }
    .map(drop)
}
