//! Strings and arrays in the safetensors container, with a hash over all of them: learned tables and statistics.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use safetensors::SafeTensors;
use safetensors::tensor::Metadata;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use crate::file::at_most;
use crate::npy::Element;
use crate::{IoError, write};

/// The key of the hash. It is the only one that is not hashed.
const HASH: &str = "blake3";
/// The largest header; safetensors itself stops here.
const MAX_HEADER: u64 = 100_000_000;

/// An array on its way into a file.
pub(crate) struct Tensor {
    pub(crate) name: &'static str,
    /// What NumPy calls the type of its elements.
    pub(crate) descr: &'static str,
    pub(crate) shape: Vec<usize>,
    /// The elements in C order, little-endian.
    pub(crate) bytes: Vec<u8>,
}

impl Tensor {
    pub(crate) fn new<T: Element>(
        name: &'static str,
        shape: &[usize],
        data: impl IntoIterator<Item = T>,
    ) -> Self {
        let mut bytes = Vec::new();
        data.into_iter().for_each(|v| v.extend(&mut bytes));
        Self { name, descr: T::DESCR, shape: shape.to_vec(), bytes }
    }
}

/// What safetensors calls NumPy's types.
fn dtype(descr: &str) -> &'static str {
    match descr {
        "|u1" => "U8",
        "<u2" => "U16",
        "<u4" => "U32",
        "<u8" => "U64",
        "<f4" => "F32",
        _ => "F64",
    }
}

/// Strings and arrays on their way into a file.
#[derive(Default)]
pub(crate) struct Content {
    pub(crate) metadata: BTreeMap<&'static str, String>,
    pub(crate) tensors: Vec<Tensor>,
}

impl Content {
    pub(crate) fn text(&mut self, key: &'static str, value: impl ToString) {
        self.metadata.insert(key, value.to_string());
    }

    pub(crate) fn tensor<T: Element>(
        &mut self,
        name: &'static str,
        shape: &[usize],
        data: impl IntoIterator<Item = T>,
    ) {
        self.tensors.push(Tensor::new(name, shape, data));
    }

    /// Writes the file. Equal content gives equal bytes, which the writer of the safetensors crate (its strings are in a
    /// hash map) does not promise.
    pub(crate) fn write(self, path: &Path) -> Result<(), IoError> {
        let pieces = self.into_pieces(path)?;
        write::stream(path, |out| pieces.iter().try_for_each(|piece| out.write_all(piece)))
    }

    /// The bytes of the file; `path` is only named in errors.
    pub(crate) fn into_bytes(self, path: &Path) -> Result<Vec<u8>, IoError> {
        Ok(self.into_pieces(path)?.concat())
    }

    /// The bytes of the file in pieces: the header, and each array; `path` is only named in errors.
    pub(crate) fn into_pieces(mut self, path: &Path) -> Result<Vec<Vec<u8>>, IoError> {
        let header = self.header(path)?;
        Ok(std::iter::once(header).chain(self.tensors.into_iter().map(|t| t.bytes)).collect())
    }

    /// What precedes the data. It sorts the tensors.
    fn header(&mut self, path: &Path) -> Result<Vec<u8>, IoError> {
        // As safetensors orders them: the widest type first, so that every array is aligned.
        let width = |t: &Tensor| std::cmp::Reverse(t.descr.as_bytes().last().copied());
        self.tensors.sort_by_key(|t| (width(t), t.name));
        let hash = self.hash();
        let strings = std::iter::once((HASH, &hash)).chain(self.metadata.iter().map(|(k, v)| (*k, v)));
        let strings: Map<String, Value> = strings.map(|(k, v)| (k.to_owned(), json!(v))).collect();
        let mut header = Map::new();
        header.insert("__metadata__".into(), Value::Object(strings));
        let mut at = 0;
        for t in &self.tensors {
            let end = at + t.bytes.len();
            header.insert(
                t.name.into(),
                json!({ "dtype": dtype(t.descr), "shape": t.shape, "data_offsets": [at, end] }),
            );
            at = end;
        }
        let mut header = Value::Object(header).to_string();
        // The data begin at a multiple of 8 bytes.
        header.push_str(&" ".repeat(header.len().next_multiple_of(8) - header.len()));
        at_most(MAX_HEADER, path, "the description of how it was trained", header.len() as u64)?;
        Ok([&(header.len() as u64).to_le_bytes(), header.as_bytes()].concat())
    }

    fn hash(&self) -> String {
        let mut tensors: Vec<_> =
            self.tensors.iter().map(|t| (t.name, dtype(t.descr).into(), &*t.shape, &*t.bytes)).collect();
        tensors.sort_by_key(|t| t.0);
        hash(self.metadata.iter().map(|(k, v)| (*k, v.as_str())), tensors.into_iter())
    }
}

/// BLAKE3 over strings, ascending by key, and arrays, ascending by name. Every piece of text and data follows its length.
fn hash<'a>(
    strings: impl Iterator<Item = (&'a str, &'a str)>,
    tensors: impl Iterator<Item = (&'a str, Cow<'a, str>, &'a [usize], &'a [u8])>,
) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut put = |piece: &[u8]| {
        hasher.update(&(piece.len() as u64).to_le_bytes());
        hasher.update(piece);
    };
    for (key, value) in strings {
        put(key.as_bytes());
        put(value.as_bytes());
    }
    for (name, dtype, shape, data) in tensors {
        put(name.as_bytes());
        put(dtype.as_bytes());
        put(&shape.iter().flat_map(|&n| (n as u64).to_le_bytes()).collect::<Vec<u8>>());
        put(data);
    }
    hasher.finalize().to_hex().to_string()
}

/// The content of a file that has been checked against its hash.
pub(crate) struct Opened<'a> {
    path: &'a Path,
    metadata: BTreeMap<String, String>,
    tensors: SafeTensors<'a>,
}

impl<'a> Opened<'a> {
    /// Opens a file of a format in one of these versions. Nothing is copied but its header.
    pub(crate) fn new(
        bytes: &'a [u8],
        path: &'a Path,
        expected: &'static str,
        (format, versions): (&'static str, &[&'static str]),
    ) -> Result<Self, IoError> {
        let unknown = || IoError::unknown(path, expected);
        let (length, rest) = bytes.split_first_chunk::<8>().ok_or_else(unknown)?;
        let length = u64::from_le_bytes(*length);
        if rest.first().is_some_and(|&b| b != b'{') || !(2..=MAX_HEADER).contains(&length) {
            return Err(unknown());
        }
        let Some(header) = usize::try_from(length).ok().and_then(|n| rest.get(..n)) else {
            return Err(IoError::truncated(path, "its header", length, rest.len() as u64));
        };
        let decode = |message: String| IoError::decode(path, "safetensors", message);
        // The header is parsed twice, to say how much is missing where something is.
        let declared: Metadata = serde_json::from_slice(header).map_err(|e| decode(e.to_string()))?;
        let (need, have) = (declared.data_len() as u64, (rest.len() - header.len()) as u64);
        if need > have {
            return Err(IoError::truncated(path, "its arrays", need, have));
        }
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| decode(e.to_string()))?;
        let metadata = declared.metadata().iter().flatten().map(|(k, v)| (k.clone(), v.clone())).collect();
        let opened = Self { path, metadata, tensors };
        if opened.text("format").ok() != Some(format) {
            let found = opened.text("format").map_or("missing".to_owned(), |f| format!("'{f}'"));
            return Err(opened.wrong("format", found, format!("'{format}'")));
        }
        let found = opened.text("version")?;
        if !versions.contains(&found) {
            let (found, expected) = (found.to_owned(), versions.join(" or "));
            return Err(IoError::Version { path: path.to_owned(), format, found, expected });
        }
        opened.check()?;
        Ok(opened)
    }

    fn check(&self) -> Result<(), IoError> {
        let views: BTreeMap<&str, _> = self.tensors.iter().collect();
        let tensors: Vec<_> =
            views.iter().map(|(name, v)| (*name, v.dtype().to_string(), v.shape(), v.data())).collect();
        let strings = self.metadata.iter().filter(|(k, _)| *k != HASH);
        let found = hash(
            strings.map(|(k, v)| (k.as_str(), v.as_str())),
            tensors.iter().map(|(name, dtype, shape, data)| (*name, dtype.as_str().into(), *shape, *data)),
        );
        let stated = self.text(HASH)?;
        if stated == found {
            return Ok(());
        }
        Err(IoError::Damaged { path: self.path.to_owned(), found, stated: stated.to_owned() })
    }

    pub(crate) fn path(&self) -> &'a Path {
        self.path
    }

    /// An error about a key or tensor.
    pub(crate) fn wrong(
        &self,
        field: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> IoError {
        IoError::field(self.path, field, found, expected)
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.metadata.contains_key(key)
    }

    pub(crate) fn text(&self, key: &str) -> Result<&str, IoError> {
        self.metadata.get(key).map(String::as_str).ok_or_else(|| self.wrong(key, "missing", "a string"))
    }

    pub(crate) fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, IoError> {
        let text = self.text(key)?;
        text.parse().map_err(|_| self.wrong(key, format!("'{text}'"), "a number"))
    }

    pub(crate) fn json<T: DeserializeOwned>(&self, key: &str) -> Result<T, IoError> {
        serde_json::from_str(self.text(key)?)
            .map_err(|e| self.wrong(key, format!("invalid ({e})"), "JSON as documented"))
    }

    /// The elements of an array of any shape of so many axes.
    pub(crate) fn any<T: Element>(&self, name: &str, axes: usize) -> Result<(Vec<usize>, Vec<T>), IoError> {
        let field = || format!("tensor '{name}'");
        let wanted = dtype(T::DESCR);
        let Ok(view) = self.tensors.tensor(name) else {
            return Err(self.wrong(&field(), "missing", format!("{wanted} of {axes} axes")));
        };
        if view.dtype().to_string() != wanted || view.shape().len() != axes {
            let found = format!("{} {:?}", view.dtype(), view.shape());
            return Err(self.wrong(&field(), found, format!("{wanted} of {axes} axes")));
        }
        Ok((view.shape().to_vec(), view.data().chunks_exact(size_of::<T>()).map(T::from_le).collect()))
    }

    /// The elements of an array of a given shape.
    pub(crate) fn shaped<T: Element>(&self, name: &str, shape: &[usize]) -> Result<Vec<T>, IoError> {
        let (found, data) = self.any(name, shape.len())?;
        if found != shape {
            let field = format!("tensor '{name}'");
            return Err(self.wrong(&field, format!("of shape {found:?}"), format!("shape {shape:?}")));
        }
        Ok(data)
    }
}
