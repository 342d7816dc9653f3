//! The folder of a comparison: the files of its report, its learned tables, and `results.json`.

use std::fs;
use std::path::Path;

use smalti::l3::Pipeline;

use crate::{IoError, l3, text, write};

/// The document of a comparison. It is removed first and written last, so that a folder that contains it is complete.
pub const RESULTS: &str = "results.json";

/// What the folder of a comparison contains.
#[derive(Debug, Clone, Copy)]
pub struct ComparisonFiles<'a> {
    /// The name of the page.
    pub page: &'a str,
    /// The folder of pictures within the folder.
    pub pictures: &'a str,
    /// All files but the document, relative to the folder. The document lists them as `files`.
    pub files: &'a [String],
    /// The learned tables with the names of their files.
    pub tables: &'a [(String, &'a Pipeline)],
    /// The document.
    pub document: &'a str,
}

/// Writes the folder of a comparison and removes the files of an earlier one that the new one lacks. `draw` stores page and pictures
/// by name.
///
/// # Errors
/// Those of `draw`, or when a file cannot be written.
pub fn write<E: From<IoError>>(
    dir: &Path,
    content: &ComparisonFiles<'_>,
    draw: impl FnOnce(&mut dyn FnMut(&str, &[u8]) -> Result<(), IoError>) -> Result<(), E>,
) -> Result<(), E> {
    for file in earlier_files(dir, content).iter().filter(|file| !content.files.contains(file)) {
        // A file that is gone, or that cannot be removed, must not lose the new results.
        let _ = fs::remove_file(dir.join(file));
    }
    let mut files = write::Files::new(dir, &[RESULTS], &[]);
    draw(&mut |name, bytes| files.write(name, bytes))?;
    for (name, pipeline) in content.tables {
        l3::write_table(&dir.join(name), pipeline)?;
    }
    Ok(files.write(RESULTS, content.document.as_bytes())?)
}

/// The files that an earlier comparison lists in its document, as far as their names are those of a comparison.
fn earlier_files(dir: &Path, content: &ComparisonFiles<'_>) -> Vec<String> {
    let text = text::read_to_string(&dir.join(RESULTS)).ok();
    let results = text.and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok());
    let listed = results.as_ref().and_then(|r| r.get("files")?.as_array());
    let is_own = |file: &&str| {
        // A name that leads elsewhere is not one that a comparison gives.
        let name = file.strip_prefix(content.pictures).and_then(|f| f.strip_prefix('/')).unwrap_or(file);
        (name.ends_with(".png") || name.ends_with(".l3") || *file == content.page)
            && Path::new(name).file_name().is_some_and(|n| n == name)
    };
    let files = listed.into_iter().flatten().filter_map(serde_json::Value::as_str);
    files.filter(is_own).map(str::to_owned).collect()
}
