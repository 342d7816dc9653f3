//! The files that a camera names: curves, tables of curves, point spread functions.

use std::collections::BTreeSet;
use std::path::Path;

use smalti::camera::CameraDescription;
use smalti::camera::description::{CfaDescription, FILTER_TABLE};
use smalti::numeric::Planes;
use smalti::sensor::Filter;

use crate::diagnostic::Diagnostic;
use crate::toml_source::beside;
use crate::{IoError, Limits, npy, spectrum_csv};

/// The columns of a file with the filters of all letters.
pub(super) struct FilterFile {
    name: String,
    letters: BTreeSet<char>,
}

/// Replaces a file with the filters of all letters by a [`Filter::File`] for each of its columns; filters that are stated by letter
/// take precedence. `None` without such a file.
pub(super) fn filters_of_table(
    cfa: &mut CfaDescription,
    folder: &Path,
    notes: &mut Vec<String>,
) -> Result<Option<FilterFile>, String> {
    let name = match cfa.filters.remove(FILTER_TABLE) {
        Some(Filter::File(name)) => name,
        Some(_) => return Err(format!("`{FILTER_TABLE}`: expected the name of a CSV file")),
        None => return Ok(None),
    };
    let path = beside(folder, &name);
    let table = spectrum_csv::read(&path).map_err(|e| e.to_string())?;
    let columns: Vec<&str> = table.columns().iter().map(|(column, _)| column.as_str()).collect();
    let mut letters = BTreeSet::new();
    for column in &columns {
        let mut chars = column.chars();
        let Some(letter) = chars.next().filter(|_| chars.next().is_none()) else {
            let field = format!("the column '{column}'");
            let expected = "the single letter of a filter, such as R, in the heading of every column";
            return Err(IoError::field(&path, field, "not named by a letter", expected).to_string());
        };
        letters.insert(letter);
    }
    let read = table.transmittances(&columns).map_err(|e| e.to_string())?;
    tell(notes, read.note);
    for column in columns {
        let of_column = Filter::File(format!("{name}#{column}"));
        cfa.filters.entry(column.to_owned()).or_insert(of_column);
    }
    Ok(Some(FilterFile { name, letters }))
}

/// Checks that a file with the filters of all letters has those of the mosaic, and drops the others.
pub(super) fn fit_table(
    cfa: &mut CfaDescription,
    table: Option<&FilterFile>,
    notes: &mut Vec<String>,
) -> Result<(), String> {
    let Some(FilterFile { name, letters }) = table else { return Ok(()) };
    let wanted = cfa.letters().map_err(|e| e.to_string())?;
    let missing: Vec<char> =
        wanted.iter().copied().filter(|l| !cfa.filters.contains_key(&l.to_string())).collect();
    if !missing.is_empty() {
        return Err(format!(
            "{name} has no column {}; it has {}. Expected a column for each letter of the mosaic, or the filter stated beside the \
             file, as in {{ file = {name:?}, {} = {{ file = \"{}.csv\" }} }}",
            listed(&missing),
            listed(letters),
            missing[0],
            missing[0],
        ));
    }
    let unused: Vec<char> = letters.iter().copied().filter(|l| !wanted.contains(l)).collect();
    if !unused.is_empty() {
        unused.iter().for_each(|letter| drop(cfa.filters.remove(&letter.to_string())));
        let (columns, are) = if unused.len() == 1 { ("column", "is") } else { ("columns", "are") };
        let (unused, wanted) = (listed(&unused), listed(&wanted));
        notes.push(format!("{name}: the {columns} {unused} {are} not used, since the mosaic has {wanted}"));
    }
    Ok(())
}

/// Letters in a message.
pub(super) fn listed<'a>(letters: impl IntoIterator<Item = &'a char>) -> String {
    letters.into_iter().map(char::to_string).collect::<Vec<_>>().join(", ")
}

/// Adds a note that is not there yet.
pub(crate) fn tell(notes: &mut Vec<String>, note: Option<String>) {
    notes.extend(note.filter(|note| !notes.contains(note)));
}

/// Replaces the name of every file by its content, so that the description is complete.
pub(super) fn read_files(
    d: &mut CameraDescription,
    folder: &Path,
    notes: &mut Vec<String>,
    wrong: &dyn Fn(&str, &str) -> Box<Diagnostic>,
) -> Result<(), Box<Diagnostic>> {
    let lens = [
        ("optics.transmittance".to_owned(), Some(&mut d.optics.transmittance)),
        ("optics.ir_cut".to_owned(), d.optics.ir_cut.as_mut()),
    ];
    let sensor = [("sensor.quantum_efficiency".to_owned(), Some(&mut d.sensor.quantum_efficiency))];
    let filters =
        d.sensor.cfa.filters.iter_mut().map(|(letter, f)| (format!("sensor.cfa.filters.{letter}"), Some(f)));
    for (key, filter) in lens.into_iter().chain(sensor).chain(filters) {
        if let Some(filter) = filter {
            let note = read_curve(filter, folder).map_err(|e| wrong(&key, &e))?;
            tell(notes, note);
        }
    }
    if let Some(psf) = &mut d.optics.psf {
        let path = beside(folder, &psf.file);
        let read = || -> Result<(Planes, String), String> {
            let array = npy::read(&path, Limits::default()).map_err(|e| e.to_string())?;
            let (count, rows, cols) = match array.shape[..] {
                [rows, cols] => (1, rows, cols),
                [count, rows, cols] => (count, rows, cols),
                _ => {
                    let (path, got) = (path.display(), array.shape.len());
                    return Err(format!("{path}: expected 2 or 3 dimensions, got {got}"));
                }
            };
            let planes = Planes::new(rows, cols, count, array.to_f32()).map_err(|e| e.to_string())?;
            let bytes: Vec<u8> = planes.data().iter().flat_map(|v| v.to_le_bytes()).collect();
            Ok((planes, blake3::hash(&bytes).to_hex().to_string()))
        };
        let (planes, hash) = read().map_err(|e| wrong("optics.psf.file", &e))?;
        if !psf.hash.is_empty() && psf.hash != hash {
            let message = format!("the file has the hash {hash}, not that of the description");
            return Err(wrong("optics.psf.hash", &message));
        }
        (psf.planes, psf.hash) = (Some(planes), hash);
    }
    Ok(())
}

/// Replaces a named file by the samples in it. Returns what is to be told about the file.
pub(crate) fn read_curve(filter: &mut Filter, folder: &Path) -> Result<Option<String>, String> {
    let Filter::File(name) = filter else { return Ok(None) };
    let path = beside(folder, name);
    let (spectrum, note) =
        spectrum_csv::read_transmittance(&path.to_string_lossy()).map_err(|e| e.to_string())?;
    *filter = Filter::sampled(&spectrum);
    Ok(note)
}
