//! NumPy's `.npz`: a ZIP archive of `.npy` files, stored without compression as `numpy.savez` does.
//!
//! The ZIP is written here: of the format (APPNOTE 6.3.10) it needs a header before each file and a list at the end.

use std::io::Write;
use std::path::Path;

use serde_json::{Map, Value};
use smalti::l3::Pipeline;

use super::content::Tensor;
use super::table;
use crate::{IoError, npy, write};

/// Sizes and places are 32-bit numbers in a ZIP without its later extension.
const LIMIT: u64 = u32::MAX as u64;
/// 1 January 1980, the earliest date there is: equal tables give equal files.
const DATE: u16 = 1 << 5 | 1;
/// 2.0, the version of plain archives.
const VERSION: u16 = 20;

/// Writes the arrays of a pipeline for `numpy.load`, which needs no `allow_pickle` for them: those of the `.l3` file under
/// the same names (`weights`, `offsets`, `counts`, `origin`, `saturations`, `trained`, `mosaic`, `cuts`), and `metadata`, a
/// string of JSON: `json.loads(str(z["metadata"]))`. `docs/formats-l3.md` describes them.
///
/// # Errors
/// [`IoError::Write`], or [`IoError::TooLarge`] where the arrays take more than 4 GiB.
pub fn write_npz(path: &Path, pipeline: &Pipeline) -> Result<(), IoError> {
    let content = table::content(pipeline);
    // Strings that are JSON are given as what they say.
    let value = |s: &String| serde_json::from_str(s).unwrap_or_else(|_| Value::String(s.clone()));
    let metadata: Map<String, Value> =
        content.metadata.iter().map(|(k, v)| ((*k).to_owned(), value(v))).collect();
    let text: Vec<char> = Value::Object(metadata).to_string().chars().collect();
    let descr = format!("<U{}", text.len());
    let mut files = vec![(
        "metadata",
        npy::header(&descr, &[]),
        text.into_iter().flat_map(|c| u32::from(c).to_le_bytes()).collect::<Vec<u8>>(),
    )];
    let npy_of = |t: Tensor| (t.name, npy::header(t.descr, &t.shape), t.bytes);
    files.extend(content.tensors.into_iter().map(npy_of));
    let whole: u64 = files.iter().map(|(_, _, data)| data.len() as u64 + 1024).sum();
    if whole > LIMIT {
        let what = "the archive";
        return Err(IoError::TooLarge { path: path.to_owned(), what, bytes: whole, limit: LIMIT });
    }
    write::atomic(path, |out| {
        let io = |source| IoError::Write { path: path.to_owned(), source };
        let (mut list, mut at, count) = (Vec::new(), 0, files.len() as u16);
        for (name, header, data) in files {
            let header =
                header.ok_or_else(|| IoError::field(path, name, "an array of many axes", "fewer axes"))?;
            let entry = Entry::new(name, &header, &data, at);
            let local = entry.local();
            for piece in [&local, &header, &data] {
                out.write_all(piece).map_err(io)?;
                at += piece.len() as u32;
            }
            entry.list(&mut list);
        }
        out.write_all(&list).map_err(io)?;
        out.write_all(&end(count, list.len() as u32, at)).map_err(io)
    })
}

/// A file of the archive.
struct Entry {
    name: String,
    crc: u32,
    size: u32,
    /// Where its header stands.
    at: u32,
}

impl Entry {
    fn new(name: &str, header: &[u8], data: &[u8], at: u32) -> Self {
        let mut crc = crc32fast::Hasher::new();
        crc.update(header);
        crc.update(data);
        let size = (header.len() + data.len()) as u32;
        Self { name: format!("{name}.npy"), crc: crc.finalize(), size, at }
    }

    /// What the header before the file and its place in the list have in common.
    fn common(&self) -> Vec<u8> {
        let mut out = Vec::new();
        // Version needed, no flags, stored, time, date.
        [VERSION, 0, 0, 0, DATE].iter().for_each(|v| out.extend(v.to_le_bytes()));
        [self.crc, self.size, self.size].iter().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend((self.name.len() as u16).to_le_bytes());
        // No extra field.
        out.extend([0, 0]);
        out
    }

    fn local(&self) -> Vec<u8> {
        [b"PK\x03\x04", &*self.common(), self.name.as_bytes()].concat()
    }

    fn list(&self, out: &mut Vec<u8>) {
        out.extend(b"PK\x01\x02");
        out.extend(VERSION.to_le_bytes());
        out.extend(self.common());
        // No comment, first disk, no attributes.
        out.extend([0; 10]);
        out.extend(self.at.to_le_bytes());
        out.extend(self.name.as_bytes());
    }
}

/// What ends an archive of `count` files, whose list of `size` bytes stands at `at`.
fn end(count: u16, size: u32, at: u32) -> Vec<u8> {
    let mut out = b"PK\x05\x06\0\0\0\0".to_vec();
    [count, count].iter().for_each(|v| out.extend(v.to_le_bytes()));
    [size, at].iter().for_each(|v| out.extend(v.to_le_bytes()));
    out.extend([0, 0]);
    out
}
