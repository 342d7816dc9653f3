//! Groups and datasets as named variables.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hdf5_pure::{
    AttrValue, Chunk, Dataset, Datatype, DatatypeByteOrder, FloatingPointLayout, FormatError, Group,
    Layout as Stored, Object,
};

use super::octave::{self, Variable};
use crate::file::guarded;
use crate::raster::{Filter, Kind, Place, Shared};
use crate::scene_file::tiles::Tiles;
use crate::variables::{self, Array, Attribute, Chunks, Fields, Layout, Numbers, Reading, Value};
use crate::{IoError, Limits};

/// The name of the format in messages.
const FORMAT: &str = "HDF5";

// Registered identifiers of filters.
const DEFLATE: u16 = 1;
const SHUFFLE: u16 = 2;
/// Attributes that decide what the numbers of a dataset are.
const MEANINGFUL: [&str; 4] = ["quantity", "comment", "units", "MATLAB_class"];
// Longer ones are no names of things.
const MAX_TEXT_BYTES: u64 = 1 << 20;

/// What is read, and how.
#[derive(Clone)]
pub(super) struct Context {
    source: Shared<'static>,
    pub(super) limits: Limits,
    pub(super) path: PathBuf,
}

/// A group.
pub(crate) struct Members {
    pub(super) group: Group,
    datasets: Vec<String>,
    groups: Vec<String>,
    pub(super) context: Context,
}

/// A spectral image, from wherever the file is.
pub(crate) fn from_source(source: Shared<'static>, of: Reading<'_>) -> Result<Box<dyn Tiles>, IoError> {
    guarded(of.path, FORMAT, || variables::open(&open(source, of.path, of.options.limits)?, of))
}

/// The root group of a file.
fn open(source: Shared<'static>, path: &Path, limits: Limits) -> Result<Members, IoError> {
    let context = Context { source: Arc::clone(&source), limits, path: path.to_owned() };
    let have = source.len();
    let file = hdf5_pure::File::from_source(Positioned(source)).map_err(|e| context.decode(e))?;
    // Without this, what lies behind the end of the file would be missing in silence, such as an attribute with the quantity.
    let need = file.superblock().eof_address;
    if need > have {
        return Err(IoError::truncated(path, "what the superblock states", need, have));
    }
    context.members(file.root())
}

/// The source behind the interface that the crate requires.
struct Positioned(Shared<'static>);

impl hdf5_pure::Source for Positioned {
    fn len(&self) -> u64 {
        self.0.len()
    }

    fn read_at(&self, offset: u64, buf: &mut [u8]) -> Result<(), FormatError> {
        self.0.read_at(offset, buf).map_err(|_| FormatError::UnexpectedEof {
            expected: usize::try_from(offset).unwrap_or(usize::MAX).saturating_add(buf.len()),
            available: usize::try_from(self.0.len()).unwrap_or(usize::MAX),
        })
    }
}

impl Fields for Members {
    fn names(&self) -> Vec<String> {
        self.datasets.iter().chain(&self.groups).cloned().collect()
    }

    fn get(&self, name: &str) -> Result<Option<Value>, IoError> {
        let context = &self.context;
        if self.datasets.iter().any(|n| n == name) {
            let dataset = self.group.dataset(name).map_err(|e| context.decode(e))?;
            return context.value(&dataset, true).map(Some);
        }
        if self.groups.iter().any(|n| n == name) {
            let group = self.group.group(name).map_err(|e| context.decode(e))?;
            let attributes = group.attrs().map_err(|e| context.decode(e))?;
            let members = context.members(group)?;
            if attributes.contains_key(octave::MARK) {
                let variable = Variable {
                    group: &members.group,
                    fields: &members,
                    path: &context.path,
                    limits: context.limits,
                    decode: &|e| context.decode(e),
                };
                return octave::value(&variable).map(Some);
            }
            return Ok(Some(Value::Fields(Box::new(members))));
        }
        Ok(None)
    }
}

impl Context {
    pub(super) fn decode(&self, error: impl ToString) -> IoError {
        IoError::decode(&self.path, FORMAT, error)
    }

    fn members(&self, group: Group) -> Result<Members, IoError> {
        let datasets = group.datasets().map_err(|e| self.decode(e))?;
        let mut groups = group.groups().map_err(|e| self.decode(e))?;
        // Where MATLAB keeps what cells and objects refer to.
        groups.retain(|name| !name.starts_with('#'));
        Ok(Members { group, datasets, groups, context: self.clone() })
    }

    /// A dataset. References are followed once: MATLAB keeps cells and fields of arrays of structs so.
    fn value(&self, dataset: &Dataset, follow: bool) -> Result<Value, IoError> {
        let decode = |e| self.decode(e);
        let attributes = dataset.attrs().map_err(decode)?;
        // The crate omits an attribute whose value it cannot find; the file would then mean something else.
        for name in MEANINGFUL {
            let is_text = |datatype: &Datatype| {
                matches!(datatype, Datatype::String { .. } | Datatype::VariableLength { is_string: true, .. })
            };
            if !attributes.contains_key(name)
                && dataset.attr_datatypes().map_err(decode)?.get(name).is_some_and(is_text)
            {
                return Err(IoError::field(
                    &self.path,
                    format!("the attribute '{name}'"),
                    "unreadable",
                    "a text",
                ));
            }
        }
        let class = attributes.get("MATLAB_class").and_then(AttrValue::as_str).map(str::to_owned);
        // An empty array is stored as the list of its dimensions.
        if attributes.contains_key("MATLAB_empty") {
            return Ok(Value::Other("empty"));
        }
        let shape = dataset.shape().map_err(decode)?;
        let one = shape.iter().all(|&d| d == 1);
        let (kind, big_endian) = match dataset.datatype().map_err(decode)? {
            Datatype::Reference { .. } if one && follow => {
                return match dataset.dereference().map_err(decode)?.into_iter().next() {
                    Some(Object::Dataset(dataset)) => self.value(&dataset, false),
                    Some(Object::Group(group)) => self.members(group).map(|m| Value::Fields(Box::new(m))),
                    _ => Ok(Value::Other("a reference")),
                };
            }
            Datatype::Reference { .. } => return Ok(Value::Other("a cell array")),
            Datatype::String { size, .. } if u64::from(size) <= MAX_TEXT_BYTES && one => {
                return self.string(dataset);
            }
            Datatype::VariableLength { is_string: true, .. } if one => return self.string(dataset),
            Datatype::Compound { .. } => return Ok(Value::Other("complex numbers or records")),
            datatype => match number(&datatype) {
                Some(number) => number,
                None => return Ok(Value::Other("neither numbers nor text")),
            },
        };
        let mut dims = Vec::with_capacity(shape.len());
        for &d in shape.iter().rev() {
            dims.push(usize::try_from(d).map_err(|e| self.decode(e))?);
        }
        let Some((source, layout)) = self.layout(dataset, &dims, kind)? else {
            return Ok(Value::Other("a virtual dataset"));
        };
        let array = Array { dims, kind, big_endian, source, layout };
        if class.as_deref() == Some("char") {
            return self.characters(&array).map(Value::Text);
        }
        let attributes = attributes
            .into_iter()
            .filter_map(|(name, value)| {
                let integers = || Some(value.to_i64s()?.into_iter().map(|v| v as f64).collect());
                let value = match value.as_str() {
                    Some(text) => Attribute::Text(text.to_owned()),
                    None => Attribute::Numbers(value.to_f64s().or_else(integers)?),
                };
                Some((name, value))
            })
            .collect();
        Ok(Value::Numbers(Numbers { array, matlab: class.is_some(), attributes }))
    }

    fn string(&self, dataset: &Dataset) -> Result<Value, IoError> {
        let strings = dataset.read_string().map_err(|e| self.decode(e))?;
        Ok(strings.into_iter().next().map_or(Value::Other("empty"), Value::Text))
    }

    /// A text of MATLAB: UTF-16.
    fn characters(&self, array: &Array) -> Result<String, IoError> {
        if array.bytes() > MAX_TEXT_BYTES {
            return Err(self.decode(format!("a text of {} bytes", array.bytes())));
        }
        let units = array.numbers(&self.path, self.limits)?;
        Ok(String::from_utf16_lossy(&units.iter().map(|&u| u as u16).collect::<Vec<u16>>()))
    }

    /// Where the numbers are; none where they are in other files.
    fn layout(
        &self,
        dataset: &Dataset,
        dims: &[usize],
        kind: Kind,
    ) -> Result<Option<(Shared<'static>, Layout)>, IoError> {
        let bytes = dims.iter().fold(kind.size() as u64, |n, &d| n.saturating_mul(d as u64));
        self.limits.check(&self.path, "a dataset", bytes, self.source.len())?;
        match dataset.layout().map_err(|e| self.decode(e))? {
            Stored::Virtual => return Ok(None),
            Stored::Contiguous { address: Some(offset), size } if size >= bytes => {
                return Ok(Some((Arc::clone(&self.source), Layout::Run { offset })));
            }
            Stored::Chunked { chunk_shape, .. } => {
                self.refuse_too_many(dims, &chunk_shape)?;
                let chunk = chunk_shape.iter().fold(kind.size() as u64, |n, &d| n.saturating_mul(d));
                self.limits.check(&self.path, "a chunk", chunk, self.source.len())?;
                let chunks = dataset.chunks().map_err(|e| self.decode(e))?;
                // The crate takes memory for what a chunk is said to be long.
                let have = self.source.len();
                if let Some(c) = chunks.iter().find(|c| c.storage_size > have.saturating_sub(c.address)) {
                    return Err(IoError::truncated(&self.path, "a chunk", c.storage_size, have));
                }
                if let Some(chunks) = placed(dataset, dims, &chunk_shape, &chunks) {
                    return Ok(Some((Arc::clone(&self.source), Layout::Chunks(chunks))));
                }
            }
            _ => {}
        }
        // The crate reads rare cases: other filters, arrays that were written in part, small arrays in the header.
        // It allocates memory for the declared elements, which may be longer than numbers of this kind.
        let size = dataset.element_size().map_err(|e| self.decode(e))?;
        if size != kind.size() as u64 {
            return Err(self.decode(format!("elements of {size} bytes; expected {}", kind.size())));
        }
        let raw = dataset.read_raw().map_err(|e| self.decode(e))?;
        if raw.len() as u64 != bytes {
            return Err(self.decode(format!("a dataset of {} bytes; expected {bytes}", raw.len())));
        }
        Ok(Some((Arc::new(raw), Layout::Run { offset: 0 })))
    }

    /// Refuses more chunks than the file has room to list: every one of them would take memory.
    fn refuse_too_many(&self, dims: &[usize], chunk_shape: &[u64]) -> Result<(), IoError> {
        // Where a chunk is, and at least a byte of it.
        const MIN_CHUNK_BYTES: u64 = 8;
        let along = dims.iter().rev().zip(chunk_shape).map(|(&d, &c)| (d as u64).div_ceil(c.max(1)));
        let need = along.fold(MIN_CHUNK_BYTES, u64::saturating_mul);
        let have = self.source.len();
        if need > have {
            return Err(IoError::truncated(&self.path, "the list of chunks", need, have));
        }
        Ok(())
    }
}

/// The chunks of an array of at most three axes, deflated at most.
fn placed(dataset: &Dataset, dims: &[usize], chunk_shape: &[u64], chunks: &[Chunk]) -> Option<Chunks> {
    let filters = dataset
        .filter_pipeline()
        .iter()
        .map(|f| match f.id {
            DEFLATE => Some(Filter::Deflate),
            SHUFFLE => Some(Filter::Shuffle),
            _ => None,
        })
        .collect::<Option<Vec<Filter>>>()?;
    let fastest_first = |of: &[u64], rest: usize| -> Option<[usize; 3]> {
        let mut three = [rest; 3];
        for (i, &n) in of.iter().rev().enumerate() {
            *three.get_mut(i)? = usize::try_from(n).ok()?;
        }
        Some(three)
    };
    let mut stored = Vec::new();
    for chunk in chunks {
        let place = Place { offset: chunk.address, bytes: chunk.storage_size, skipped: chunk.filter_mask };
        stored.push((fastest_first(&chunk.offset, 0)?, place));
    }
    let mut three = [1; 3];
    for (i, &d) in dims.iter().enumerate() {
        *three.get_mut(i)? = d;
    }
    Chunks::new(three, fastest_first(chunk_shape, 1)?, filters, stored)
}

/// A type of number that is read here, and whether it is big-endian: whole numbers without holes, IEEE 754.
fn number(datatype: &Datatype) -> Option<(Kind, bool)> {
    let (kind, order) = match datatype {
        Datatype::FixedPoint { size, byte_order, layout }
            if layout.bit_offset == 0 && u64::from(layout.bit_precision) == 8 * u64::from(*size) =>
        {
            let kind = match (size, layout.signed) {
                (1, true) => Kind::I8,
                (1, false) => Kind::U8,
                (2, true) => Kind::I16,
                (2, false) => Kind::U16,
                (4, true) => Kind::I32,
                (4, false) => Kind::U32,
                (8, true) => Kind::I64,
                (8, false) => Kind::U64,
                _ => return None,
            };
            (kind, byte_order)
        }
        Datatype::FloatingPoint { byte_order, layout, .. } => {
            let kind = match *layout {
                FloatingPointLayout::IEEE754_BINARY32 => Kind::F32,
                FloatingPointLayout::IEEE754_BINARY64 => Kind::F64,
                _ => return None,
            };
            (kind, byte_order)
        }
        _ => return None,
    };
    match order {
        DatatypeByteOrder::LittleEndian => Some((kind, false)),
        DatatypeByteOrder::BigEndian => Some((kind, true)),
        DatatypeByteOrder::Vax => None,
    }
}
