//! Spectra as comma-separated values, and as spreadsheets export them.
//!
//! ```text
//! # comments and empty lines are skipped
//! wavelength_nm,R,G,B
//! 400,0.01,0.02,0.30
//! 410,0.01,0.02,0.35
//! ```
//!
//! The first column is the wavelength in nm, ascending; the others are values, named by the header. Without a
//! header the columns are called `1`, `2`, …. `file.csv#G` names one column. Wavelengths at unequal distances are
//! resampled by linear interpolation to a uniform grid from the first to the last, with the smallest distance
//! (rounded down to fit) as step and at most [`MAX_SAMPLES`] samples.
//!
//! A first line with semicolons or tabs separates all columns by them; numbers may then have decimal commas.
//! [`SpectrumTable::transmittances`] also recognises percent. What was recognised is told by [`SpectrumTable::recognised`] and
//! [`Transmittances::note`].

mod layout;
mod percent;
#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::{Path, PathBuf};

use smalti::spectrum::Spectrum;

use crate::error::At;
use crate::wavelengths::{places, uniform_grid};
use crate::{IoError, text, write};

use self::layout::{Layout, heading};
pub use self::percent::Transmittances;

/// Most samples that resampling makes.
pub const MAX_SAMPLES: usize = 10_000;

/// Most values that resampling makes in all columns together.
const MAX_VALUES: usize = 1 << 20;

/// Spectra of one file, all on one grid.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumTable {
    path: PathBuf,
    layout: Layout,
    columns: Vec<(String, Spectrum)>,
    facts: Vec<ColumnFacts>,
}

/// What [`percent`] needs to know about a column.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ColumnFacts {
    /// The heading or the cells state percent.
    is_percent: bool,
    /// The cells have percent signs.
    has_signs: bool,
    /// The largest value, and its line.
    largest: (f64, usize),
}

impl SpectrumTable {
    /// Name and values of every column, in the order of the file; at least one.
    #[must_use]
    pub fn columns(&self) -> &[(String, Spectrum)] {
        &self.columns
    }

    /// The column of that name.
    ///
    /// # Errors
    /// When there is none, with the names there are.
    pub fn column(&self, name: &str) -> Result<&Spectrum, IoError> {
        Ok(&self.columns[self.index(name)?].1)
    }

    fn index(&self, name: &str) -> Result<usize, IoError> {
        let names = || self.columns.iter().map(|(n, _)| n.as_str()).collect::<Vec<_>>().join(", ");
        self.columns.iter().position(|(n, _)| n == name).ok_or_else(|| {
            IoError::field(&self.path, format!("column '{name}'"), "absent", format!("one of: {}", names()))
        })
    }

    /// How the file separates columns and writes decimals, in words, where it is not by commas and points.
    #[must_use]
    pub fn recognised(&self) -> Vec<&'static str> {
        self.layout.in_words()
    }
}

/// One spectrum: `file.csv` where the file has one column of values, `file.csv#column` otherwise.
///
/// The values are those of the file, whatever their unit; see [`read_transmittance`].
///
/// # Errors
/// As [`read`]; when the column is absent, or not named where there are several.
pub fn read_spectrum(path_and_column: &str) -> Result<Spectrum, IoError> {
    let (table, column) = table_and_column(path_and_column)?;
    Ok(table.columns[column].1.clone())
}

/// As [`read_spectrum`], for a transmittance or a quantum efficiency from 0 to 1; percent is recognised. Also returns what is to be
/// told about the file, if anything.
///
/// # Errors
/// As [`read_spectrum`] and [`SpectrumTable::transmittances`].
pub fn read_transmittance(path_and_column: &str) -> Result<(Spectrum, Option<String>), IoError> {
    let (table, column) = table_and_column(path_and_column)?;
    let mut read = table.transmittances(&[&table.columns[column].0])?;
    let note = read.note.take();
    Ok((read.columns.swap_remove(0).1, note))
}

/// As [`read_spectrum`], for relative values, such as the spectral power of a light, whose scale has no meaning. Also returns what is to
/// be told about the file, if anything.
///
/// # Errors
/// As [`read_spectrum`], and when a heading states percent and a value is above 100 %.
pub fn read_relative(path_and_column: &str) -> Result<(Spectrum, Option<String>), IoError> {
    let (table, column) = table_and_column(path_and_column)?;
    let note = table.relative(column)?;
    Ok((table.columns[column].1.clone(), note))
}

/// A file, and the number of the column that `file.csv` or `file.csv#column` names.
fn table_and_column(path_and_column: &str) -> Result<(SpectrumTable, usize), IoError> {
    let (path, column) = match path_and_column.rsplit_once('#') {
        // A file may have '#' in its name.
        Some((path, column)) if !Path::new(path_and_column).is_file() => (path, Some(column)),
        _ => (path_and_column, None),
    };
    let table = read(Path::new(path))?;
    let index = match (column, table.columns()) {
        (Some(name), _) => table.index(name)?,
        (None, [_]) => 0,
        (None, columns) => {
            let names: Vec<_> = columns.iter().map(|(n, _)| format!("{path}#{n}")).collect();
            let found = format!("one of {} columns, not named", columns.len());
            return Err(IoError::field(Path::new(path), "the spectrum", found, names.join(" or ")));
        }
    };
    Ok((table, index))
}

/// All spectra of a CSV file.
///
/// # Errors
/// When the file cannot be read or is empty; with the line number when wavelengths do not ascend, repeat or are
/// not positive, when a value is not a finite number, or a row has another number of values than the header.
pub fn read(path: &Path) -> Result<SpectrumTable, IoError> {
    parse(&text::read_to_string(path)?, path)
}

/// As [`read`], from memory; `path` is only named in errors.
pub fn parse(text: &str, path: &Path) -> Result<SpectrumTable, IoError> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    let wrong = |line: usize, found: String, expected: &str| IoError::line(path, line, found, expected);
    let Some(&(first_line, first)) = lines.peek() else {
        return Err(IoError::field(path, "the file", "empty", "lines wavelength_nm,value"));
    };
    let mut layout = Layout::of(first);
    let first = layout.fields(first);
    let (names, mut facts): (Vec<String>, Vec<ColumnFacts>) =
        if first.first().is_some_and(|v| layout.number(v).is_none()) {
            lines.next();
            first
                .iter()
                .skip(1)
                .map(|text| heading(text))
                .map(|(name, percent)| (name, facts_of(percent)))
                .unzip()
        } else {
            (1..first.len()).map(|i| (i.to_string(), facts_of(false))).unzip()
        };
    if names.is_empty() {
        let expected = "wavelength_nm and at least one column of values";
        return Err(wrong(first_line, "one column".into(), expected));
    }
    if let Some(name) = names.iter().enumerate().find_map(|(i, n)| names[..i].contains(n).then_some(n)) {
        return Err(wrong(first_line, format!("two columns called '{name}'"), "names that differ"));
    }

    let mut wavelengths_nm: Vec<f64> = Vec::new();
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for (line, row) in lines {
        let row = layout.fields(row);
        if row.len() != names.len() + 1 {
            let expected = format!("{} columns", names.len() + 1);
            return Err(wrong(line, format!("{} columns", row.len()), &expected));
        }
        let mut number = |cell: &str, digits: &str| match layout.number(digits) {
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(wrong(line, format!("'{cell}'"), layout.expected())),
        };
        let nm = number(row[0], row[0])?;
        if nm <= 0.0 {
            return Err(wrong(line, format!("wavelength {nm}"), "a positive wavelength in nm"));
        }
        if let Some(&before) = wavelengths_nm.last().filter(|&&before| nm <= before) {
            let found = format!("wavelength {nm} after {before}");
            return Err(wrong(line, found, "ascending wavelengths, each once"));
        }
        for (((cell, column), facts), name) in row[1..].iter().zip(&mut values).zip(&mut facts).zip(&names) {
            // Cells as `12.3 %` state percent for their column, in every row.
            let digits = cell.strip_suffix('%');
            if wavelengths_nm.is_empty() {
                facts.is_percent |= digits.is_some();
                facts.has_signs = digits.is_some();
            } else if digits.is_some() != facts.has_signs {
                let found = format!("'{cell}' in column '{name}'");
                return Err(wrong(line, found, "a percent sign in every row of a column, or in none"));
            }
            let number = number(cell, digits.unwrap_or(cell).trim_end())?;
            column.push(number);
            if number > facts.largest.0 {
                facts.largest = (number, line);
            }
        }
        wavelengths_nm.push(nm);
    }
    if wavelengths_nm.len() < 2 {
        let found = format!("{} row of numbers", wavelengths_nm.len());
        return Err(IoError::field(path, "the table", found, "at least two wavelengths"));
    }

    // Many columns share the samples: a small file must not ask for much memory.
    let most = MAX_SAMPLES.min(MAX_VALUES / names.len()).max(wavelengths_nm.len());
    let grid = uniform_grid(&wavelengths_nm, most).at(path)?;
    let places = places(&wavelengths_nm, grid);
    let resampled = |v: &[f64]| Spectrum::new(grid, places.iter().map(|p| p.of(v)).collect()).at(path);
    let columns = names.into_iter().zip(&values).map(|(name, v)| Ok((name, resampled(v)?)));
    let columns = columns.collect::<Result<Vec<_>, IoError>>()?;
    Ok(SpectrumTable { path: path.to_owned(), layout, columns, facts })
}

fn facts_of(is_percent: bool) -> ColumnFacts {
    ColumnFacts { is_percent, has_signs: false, largest: (f64::NEG_INFINITY, 0) }
}

/// Writes spectra on one grid. Numbers are written so that they read back exactly.
///
/// # Errors
/// When there is no spectrum, the grids differ, a name is empty, repeated or holds a separator, quote, percent sign or line break,
/// or the file cannot be written.
pub fn write(path: &Path, columns: &[(&str, &Spectrum)]) -> Result<(), IoError> {
    let Some((_, first)) = columns.first() else {
        return Err(IoError::field(path, "the table", "empty", "at least one spectrum"));
    };
    let grid = first.grid();
    for (i, (name, spectrum)) in columns.iter().enumerate() {
        if spectrum.grid() != grid {
            let e = smalti::spectrum::SpectrumError::GridMismatch { left: grid, right: spectrum.grid() };
            return Err(e).at(path);
        }
        let unfit = name.trim() != *name
            || name.is_empty()
            || name.contains([',', ';', '\t', '"', '%', '\n', '\r', '#']);
        if unfit || columns[..i].iter().any(|(n, _)| n == name) {
            return Err(IoError::field(path, "column name", format!("'{name}'"), "a plain name, used once"));
        }
    }
    write::stream(path, |out| {
        let names: Vec<_> = columns.iter().map(|(n, _)| *n).collect();
        writeln!(out, "wavelength_nm,{}", names.join(","))?;
        for (i, nm) in grid.wavelengths_nm().enumerate() {
            write!(out, "{nm}")?;
            for (_, spectrum) in columns {
                write!(out, ",{}", spectrum.values()[i])?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}
