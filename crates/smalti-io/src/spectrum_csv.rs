//! Spectra as comma-separated values.
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

use std::io::Write;
use std::path::{Path, PathBuf};

use smalti::spectrum::Spectrum;

use crate::error::At;
use crate::wavelengths::{places, uniform_grid};
use crate::{IoError, text, write};

/// Most samples that resampling makes.
pub const MAX_SAMPLES: usize = 10_000;

/// Most values that resampling makes in all columns together.
const MAX_VALUES: usize = 1 << 20;

/// Spectra of one file, all on one grid.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumTable {
    path: PathBuf,
    columns: Vec<(String, Spectrum)>,
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
        let names = || self.columns.iter().map(|(n, _)| n.as_str()).collect::<Vec<_>>().join(", ");
        self.columns.iter().find(|(n, _)| n == name).map(|(_, s)| s).ok_or_else(|| {
            IoError::field(&self.path, format!("column '{name}'"), "absent", format!("one of: {}", names()))
        })
    }
}

/// One spectrum: `file.csv` where the file has one column of values, `file.csv#column` otherwise.
///
/// # Errors
/// As [`read`]; when the column is absent, or not named where there are several.
pub fn read_spectrum(path_and_column: &str) -> Result<Spectrum, IoError> {
    let (path, column) = match path_and_column.rsplit_once('#') {
        // A file may have '#' in its name.
        Some((path, column)) if !Path::new(path_and_column).is_file() => (path, Some(column)),
        _ => (path_and_column, None),
    };
    let table = read(Path::new(path))?;
    match (column, table.columns()) {
        (Some(name), _) => table.column(name).cloned(),
        (None, [(_, only)]) => Ok(only.clone()),
        (None, columns) => {
            let names: Vec<_> = columns.iter().map(|(n, _)| format!("{path}#{n}")).collect();
            let found = format!("one of {} columns, not named", columns.len());
            Err(IoError::field(Path::new(path), "the spectrum", found, names.join(" or ")))
        }
    }
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
    let fields =
        |line: &str| line.split(',').map(|v| v.trim().trim_matches('"').to_owned()).collect::<Vec<_>>();

    let Some(&(first_line, first)) = lines.peek() else {
        return Err(IoError::field(path, "the file", "empty", "lines wavelength_nm,value"));
    };
    let first = fields(first);
    let names: Vec<String> = if first.first().is_some_and(|v| v.parse::<f64>().is_err()) {
        lines.next();
        first.iter().skip(1).cloned().collect()
    } else {
        (1..first.len()).map(|i| i.to_string()).collect()
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
        let row = fields(row);
        if row.len() != names.len() + 1 {
            let expected = format!("{} columns", names.len() + 1);
            return Err(wrong(line, format!("{} columns", row.len()), &expected));
        }
        let mut numbers = row.iter().map(|v| match v.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(wrong(line, format!("'{v}'"), "a finite number")),
        });
        let nm = numbers.next().transpose()?.unwrap_or(f64::NAN);
        if nm <= 0.0 {
            return Err(wrong(line, format!("wavelength {nm}"), "a positive wavelength in nm"));
        }
        if let Some(&before) = wavelengths_nm.last().filter(|&&before| nm <= before) {
            let found = format!("wavelength {nm} after {before}");
            return Err(wrong(line, found, "ascending wavelengths, each once"));
        }
        wavelengths_nm.push(nm);
        for (column, number) in values.iter_mut().zip(numbers) {
            column.push(number?);
        }
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
    Ok(SpectrumTable { path: path.to_owned(), columns })
}

/// Writes spectra on one grid. Numbers are written so that they read back exactly.
///
/// # Errors
/// When there is no spectrum, the grids differ, a name is empty, repeated or holds a comma, quote or line break,
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
        let unfit = name.trim() != *name || name.is_empty() || name.contains([',', '"', '\n', '\r', '#']);
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use smalti::spectrum::WavelengthGrid;

    use super::*;

    fn error(text: &str) -> String {
        parse(text, Path::new("f.csv")).unwrap_err().to_string()
    }

    #[test]
    fn a_header_comments_and_quotes_are_understood() {
        let t =
            parse("# made by hand\n\n\"wavelength_nm\", G ,B\r\n400,1,2\n410,3,4\n", Path::new("f")).unwrap();
        assert_eq!(t.column("G").unwrap().values(), [1.0, 3.0]);
        assert_eq!(t.columns()[1].0, "B");
        assert_eq!(parse("400,1\n410,2", Path::new("f")).unwrap().columns()[0].0, "1");
    }

    #[test]
    fn unequal_distances_are_resampled_linearly() {
        let t = parse("400,0\n405,1\n420,4", Path::new("f")).unwrap();
        let s = &t.columns()[0].1;
        assert_eq!(s.grid(), WavelengthGrid::new(400.0, 5.0, 5).unwrap());
        for (got, want) in s.values().iter().zip([0.0, 1.0, 2.0, 3.0, 4.0]) {
            assert!((got - want).abs() < 1e-12);
        }
    }

    #[test]
    fn many_columns_share_the_samples() {
        let columns = 2000;
        let row = |nm: f64| format!("{nm}{}\n", ",1".repeat(columns));
        let text = [400.0, 400.001, 800.0].map(row).concat();
        let grid = parse(&text, Path::new("f")).unwrap().columns()[0].1.grid();
        assert_eq!(grid.len(), MAX_VALUES / columns);
    }

    #[test]
    fn errors_name_the_line_and_what_was_expected() {
        assert_eq!(error(""), "f.csv: the file is empty; expected lines wavelength_nm,value");
        assert_eq!(error("nm,v\n400,x"), "f.csv: line 2: found 'x'; expected a finite number");
        assert_eq!(error("nm,v\n400,NaN\n410,1"), "f.csv: line 2: found 'NaN'; expected a finite number");
        assert_eq!(
            error("# c\nnm,v\n410,1\n400,1"),
            "f.csv: line 4: found wavelength 400 after 410; expected ascending wavelengths, each once"
        );
        assert!(error("400,1\n400,1").contains("line 2"));
        assert!(error("-400,1\n400,1").contains("positive wavelength"));
        assert!(error("nm,a,b\n400,1").contains("line 2: found 2 columns; expected 3 columns"));
        assert!(error("nm,a,a\n400,1,1").contains("two columns called 'a'"));
        assert!(error("nm,v\n400,1").contains("at least two wavelengths"));
        assert!(error("400\n410").contains("one column"));
    }

    #[test]
    fn a_missing_column_lists_those_there_are() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("f.csv");
        std::fs::write(&path, "nm,R,G\n400,1,2\n410,3,4\n").unwrap();
        let name = path.to_str().unwrap();
        assert!(read_spectrum(&format!("{name}#B")).unwrap_err().to_string().contains("one of: R, G"));
        assert!(read_spectrum(name).unwrap_err().to_string().contains("f.csv#R or "));
        assert_eq!(read_spectrum(&format!("{name}#G")).unwrap().values(), [2.0, 4.0]);
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back_exactly(
            start in 300.0..500.0f64, step in 0.5..20.0f64,
            values in prop::collection::vec(-1e6..1e6f64, 2..40),
        ) {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("f.csv");
            let s = Spectrum::new(WavelengthGrid::new(start, step, values.len()).unwrap(), values).unwrap();
            write(&path, &[("a", &s), ("b", &s)]).unwrap();
            let back = read(&path).unwrap();
            prop_assert_eq!(back.column("b").unwrap().values(), s.values());
            prop_assert!((back.column("a").unwrap().grid().end_nm() - s.grid().end_nm()).abs() < 1e-9);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "[0-9.,#a\n\r \"eE+-]{0,200}") {
            if let Ok(t) = parse(&text, Path::new("f")) {
                prop_assert!(t.columns().iter().all(|(_, s)| s.grid().len() <= MAX_SAMPLES.max(text.len())));
            }
        }
    }
}
