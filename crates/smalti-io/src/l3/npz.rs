//! NumPy's `.npz`: a ZIP archive of `.npy` files, stored without compression as `numpy.savez` does.

use std::io::Write;
use std::path::Path;

use serde_json::{Map, Value};
use smalti::l3::Pipeline;

use super::table;
use crate::container::Tensor;
use crate::npz::zip_write::{Stored, end};
use crate::{IoError, npy, write};

/// Writes the arrays of a pipeline for `numpy.load`, which needs no `allow_pickle` for them: those of the `.l3` file under
/// the same names (`weights`, `offsets`, `counts`, `origin`, `saturations`, `trained`, `mosaic`, `cuts`), and `metadata`, a
/// string of JSON: `json.loads(str(z["metadata"]))`. `docs/formats-l3.md` describes them.
///
/// # Errors
/// [`IoError::Write`].
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
    write::atomic(path, |out| {
        let io = IoError::writing(path);
        let (mut members, mut at) = (Vec::new(), 0);
        for (name, header, data) in files {
            let header =
                header.ok_or_else(|| IoError::field(path, name, "an array of many axes", "fewer axes"))?;
            members.push(Stored::write(out, name, &[&header, &data], &mut at).map_err(io)?);
        }
        out.write_all(&end(&members, at)).map_err(io)
    })
}
