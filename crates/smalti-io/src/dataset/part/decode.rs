//! Decoding of columns from a Parquet file.
//!
//! The hash reveals damage, but a malicious file can state a correct hash. Memory is therefore bounded independently of the file: the
//! schema comes from the plan, and pages are measured before and after decompression.

use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::Compression;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::ColumnReaderImpl;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::{
    PageIndexPolicy, ParquetMetaData, ParquetMetaDataOptions, ParquetMetaDataReader,
};
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;

use super::super::error::{DatasetError, PartProblem};
use super::super::manifest::Manifest;
use super::super::schema::{Column, ColumnKind};
use super::super::{MAX_LIST_VALUES, MAX_TEXT_BYTES};
use super::marks;

/// Maximum expansion by Snappy, whose copies of three bytes yield at most 64.
const EXPANSION: u64 = 22;

/// Decodes the columns with these indices in the plan from the bytes of a part. `path` is used in error messages.
///
/// # Errors
/// [`DatasetError::Part`] when the bytes are truncated, damaged or malformed, or belong to another chunk or plan.
pub fn part_from_bytes(
    bytes: Vec<u8>,
    path: &Path,
    manifest: &Manifest,
    chunk: u64,
    columns: &[usize],
) -> Result<Vec<Column>, DatasetError> {
    marks::check_seal(&bytes).map_err(|p| p.at(path))?;
    std::panic::catch_unwind(|| decode(Bytes::from(bytes), manifest, chunk, columns))
        .unwrap_or_else(|_| Err(PartProblem::malformed("the Parquet library cannot decode it")))
        .map_err(|p| p.at(path))
}

fn decode(
    bytes: Bytes,
    manifest: &Manifest,
    chunk: u64,
    columns: &[usize],
) -> Result<Vec<Column>, PartProblem> {
    let specs = &manifest.plan.schema;
    let rows = manifest.plan.rows(chunk);
    let metadata = metadata(&bytes, manifest)?;
    let pairs = metadata.file_metadata().key_value_metadata();
    marks::check(manifest, chunk, |key| pairs?.iter().find(|p| p.key == key)?.value.clone())?;
    let [group] = metadata.row_groups() else {
        return Err(PartProblem::malformed(format!("{} row groups; expected 1", metadata.num_row_groups())));
    };
    if usize::try_from(group.num_rows()) != Ok(rows) || group.num_columns() != specs.len() {
        let what = format!("{} rows of {} columns", group.num_rows(), group.num_columns());
        return Err(PartProblem::malformed(what));
    }
    let source = Arc::new(Source(bytes));
    columns
        .iter()
        .map(|&i| {
            let spec = specs.get(i).ok_or_else(|| PartProblem::malformed(format!("no column {i}")))?;
            let meta = group.column(i);
            if meta.compression() != Compression::SNAPPY {
                return Err(PartProblem::malformed(format!("column {} does not use Snappy", spec.name)));
            }
            let pages = SerializedPageReader::new(Arc::clone(&source), meta, rows, None)
                .map_err(PartProblem::malformed)?;
            let most = if spec.kind == ColumnKind::Floats { MAX_LIST_VALUES } else { rows };
            let pages = Box::new(Measured { pages, left: most, ahead: None });
            column(spec.kind, rows, meta.column_descr_ptr(), pages)
                .map_err(|e| PartProblem::malformed(format!("column {}: {e}", spec.name)))
        })
        .collect()
}

fn metadata(bytes: &Bytes, manifest: &Manifest) -> Result<ParquetMetaData, PartProblem> {
    let schema = super::schema::parquet(&manifest.plan.schema).map_err(PartProblem::malformed)?;
    // Given a schema, the library does not parse that of the file, whose nesting could exhaust the stack.
    let options = ParquetMetaDataOptions::new().with_schema(schema);
    ParquetMetaDataReader::new()
        .with_page_index_policy(PageIndexPolicy::Skip)
        .with_metadata_options(Some(options))
        .parse_and_finish(bytes)
        .map_err(PartProblem::malformed)
}

type Pages = Box<dyn PageReader>;
type Descriptor = parquet::schema::types::ColumnDescPtr;

fn column(kind: ColumnKind, rows: usize, descr: Descriptor, pages: Pages) -> Result<Column, ParquetError> {
    match kind {
        ColumnKind::Int => Ok(Column::Int(values::<Int64Type>(rows, descr, pages)?.values)),
        ColumnKind::Float => {
            let read = values::<DoubleType>(rows, descr, pages)?;
            let mut values = read.values.into_iter();
            let value = |level: &i16| if *level == 1 { values.next() } else { None }.unwrap_or(f64::NAN);
            Ok(Column::Float(read.levels.iter().map(value).collect()))
        }
        ColumnKind::Text => texts(values::<ByteArrayType>(rows, descr, pages)?.values).map(Column::Text),
        ColumnKind::Floats => Ok(Column::Floats(lists(values::<DoubleType>(rows, descr, pages)?))),
    }
}

/// Values other than null, and the definition and repetition levels that locate them.
struct Read<T> {
    values: Vec<T>,
    levels: Vec<i16>,
    repeats: Vec<i16>,
}

fn values<T: DataType>(rows: usize, descr: Descriptor, pages: Pages) -> Result<Read<T::T>, ParquetError> {
    let nullable = descr.max_def_level() > 0;
    let mut reader = ColumnReaderImpl::<T>::new(descr, pages);
    let mut out = Read { values: Vec::new(), levels: Vec::new(), repeats: Vec::new() };
    // The library ignores `repeats` for columns without lists.
    let (records, ..) = reader.read_records(
        rows,
        nullable.then_some(&mut out.levels),
        Some(&mut out.repeats),
        &mut out.values,
    )?;
    if records == rows { Ok(out) } else { Err(general(format!("{records} rows; expected {rows}"))) }
}

pub(super) fn texts(values: Vec<ByteArray>) -> Result<Vec<String>, ParquetError> {
    // With a dictionary, a small file can repeat a long text many times.
    let total = values.iter().fold(0usize, |sum, v| sum.saturating_add(v.len()));
    if total > MAX_TEXT_BYTES {
        return Err(general(format!("{total} bytes of text; expected at most {MAX_TEXT_BYTES}")));
    }
    values.iter().map(|v| v.as_utf8().map(str::to_owned)).collect()
}

fn lists(read: Read<f64>) -> Vec<Vec<f64>> {
    let mut values = read.values.into_iter();
    let mut out: Vec<Vec<f64>> = Vec::new();
    for (level, repeat) in read.levels.iter().zip(&read.repeats) {
        if *repeat == 0 {
            out.push(Vec::new());
        }
        let Some(list) = out.last_mut() else { continue };
        match level {
            0 => {}
            1 => list.push(f64::NAN),
            _ => list.extend(values.next()),
        }
    }
    out
}

fn general(message: String) -> ParquetError {
    ParquetError::General(message)
}

/// The bytes of a file. Checks the size that a page declares before the library allocates it.
pub(super) struct Source(pub(super) Bytes);

impl Length for Source {
    fn len(&self) -> u64 {
        self.0.len() as u64
    }
}

impl ChunkReader for Source {
    type T = <Bytes as ChunkReader>::T;

    /// The library calls this to read a page.
    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        let header = usize::try_from(start).ok().and_then(|s| self.0.get(s..)).unwrap_or_default();
        let size =
            uncompressed_size(header).ok_or_else(|| general(format!("no page header at byte {start}")))?;
        let most = self.len().saturating_mul(EXPANSION);
        if size > most {
            return Err(general(format!("a page declares {size} bytes; expected at most {most}")));
        }
        self.0.get_read(start)
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        self.0.get_bytes(start, length)
    }
}

/// Uncompressed size of a page, bytes, from the second field of its header; `None` if malformed or negative. In Thrift's compact protocol,
/// each of the first two fields is a byte 0x15 (next field, 32-bit integer) and a zigzag number in groups of seven bits.
pub(super) fn uncompressed_size(header: &[u8]) -> Option<u64> {
    let mut bytes = header.iter().copied();
    let mut field = || -> Option<u64> {
        bytes.next().filter(|b| *b == 0x15)?;
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = bytes.next()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return (number % 2 == 0).then_some(number / 2);
            }
        }
        None
    };
    field()?;
    field()
}

/// Limits the total number of values in pages, since a run of equal levels of any length takes only a few bytes.
struct Measured {
    pages: SerializedPageReader<Source>,
    left: usize,
    /// A page that was peeked at. `pages` is never peeked at, since it would then read the content of the page separately, where
    /// [`Source`] expects a header.
    ahead: Option<Page>,
}

impl PageReader for Measured {
    fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
        if let Some(page) = self.ahead.take() {
            return Ok(Some(page));
        }
        let page = self.pages.get_next_page()?;
        if let Some(page) = page.as_ref().filter(|p| !p.is_dictionary_page()) {
            let values = page.num_values() as usize;
            self.left = self
                .left
                .checked_sub(values)
                .ok_or_else(|| general(format!("a page of {values} values exceeds the limit")))?;
        }
        Ok(page)
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>, ParquetError> {
        self.ahead = self.get_next_page()?;
        Ok(self.ahead.as_ref().map(|page| PageMetadata {
            num_rows: None,
            num_levels: Some(page.num_values() as usize),
            is_dict: page.is_dictionary_page(),
        }))
    }

    fn skip_next_page(&mut self) -> Result<(), ParquetError> {
        self.get_next_page().map(drop)
    }
}

impl Iterator for Measured {
    type Item = Result<Page, ParquetError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
