//! Tests of spectra as text.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use smalti::spectrum::WavelengthGrid;

use super::*;

fn error(text: &str) -> String {
    parse(text, Path::new("f.csv")).unwrap_err().to_string()
}

#[test]
fn a_header_comments_and_quotes_are_understood() {
    let t = parse("# made by hand\n\n\"wavelength_nm\", G ,B\r\n400,1,2\n410,3,4\n", Path::new("f")).unwrap();
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

const PLAIN: &str = "wavelength_nm,R,W\n400,0.05,0.9\n410,0.25,0.95\n";

#[test]
fn separators_and_decimal_marks_are_recognised_and_told() {
    let plain = parse(PLAIN, Path::new("f.csv")).unwrap();
    assert!(plain.recognised().is_empty());
    for (text, told) in [
        (PLAIN.replace(',', ";"), vec!["columns separated by semicolons"]),
        (PLAIN.replace(',', "\t"), vec!["columns separated by tabs"]),
        (
            PLAIN.replace(',', ";").replace('.', ","),
            vec!["columns separated by semicolons", "decimal commas"],
        ),
        (PLAIN.replace(',', "\t").replace('.', ","), vec!["columns separated by tabs", "decimal commas"]),
    ] {
        let table = parse(&text, Path::new("f.csv")).unwrap();
        assert_eq!((table.columns(), table.recognised()), (plain.columns(), told), "{text}");
    }
    // Beside decimal points, a comma may separate thousands.
    let mixed = "nm;R\n400;0.5\n410;1,000\n";
    assert_eq!(
        error(mixed),
        "f.csv: line 3: found '1,000'; expected a finite number with a decimal point, as before"
    );
    assert!(
        error("nm;R\n400;0,5\n410;0.6\n")
            .contains("line 3: found '0.6'; expected a finite number with a decimal comma")
    );
    assert!(error("400,5;0.5\n410,5;0,6\n").contains("line 1: found '0.5'"));
    assert!(error("nm;R\n400;1.000,5\n").contains("line 2: found '1.000,5'"));
}

/// The power of a light has any scale; what a heading states as percent must be that.
#[test]
fn relative_values_have_any_scale_and_their_file_is_told() {
    let relative =
        |text: &str| parse(text, Path::new("f.csv")).unwrap().relative(0).map_err(|e| e.to_string());
    assert_eq!(relative("nm,power\n400,0.2\n410,5000\n"), Ok(None));
    let told = |text: &str| relative(text).unwrap().unwrap();
    assert_eq!(
        told("nm;power\n400;0,2\n410;1,5\n"),
        "f.csv: columns separated by semicolons, decimal commas"
    );
    assert_eq!(
        told("nm\tpower (%)\n400\t20\n410\t100\n"),
        "f.csv: columns separated by tabs, values in percent"
    );
    let above = relative("nm,power (%)\n400,20\n410,120\n").unwrap_err();
    assert_eq!(
        above,
        "f.csv: line 3: found 120 in column 'power'; expected at most 100 %; divide values in another unit, such as digital numbers, by their maximum"
    );
}

fn transmittances(text: &str, names: &[&str]) -> Result<Transmittances, String> {
    parse(text, Path::new("f.csv")).unwrap().transmittances(names).map_err(|e| e.to_string())
}

#[test]
fn percent_is_recognised_by_values_and_headings() {
    let plain = transmittances(PLAIN, &["R", "W"]).unwrap();
    assert_eq!(plain.note, None);
    let percent = "nm,R,W\n400,5,90\n410,25,95\n";
    let read = transmittances(percent, &["R", "W"]).unwrap();
    assert_eq!(read.note.as_deref(), Some("f.csv: values in percent, divided by 100"));
    for ((name, got), (other, want)) in read.columns.iter().zip(&plain.columns) {
        assert_eq!(name, other);
        assert!(got.values().iter().zip(want.values()).all(|(g, w)| (g - w).abs() < 1e-15));
    }
    for heading in ["I (%)", "I [%]", "I %", "I%", "I_percent", "I (Percent)"] {
        // A dark filter: less than 1 % everywhere.
        let read = transmittances(&format!("nm,{heading}\n400,0.2\n410,0.8\n"), &["I"]).unwrap();
        assert!((read.columns[0].1.values()[1] - 0.008).abs() < 1e-15, "{heading}");
    }
}

#[test]
fn percent_signs_in_cells_stand_in_every_row_or_in_none() {
    let read = transmittances("nm,R,W\n400,0.2%,90 %\n410,\"0.8 %\",95%\n", &["R", "W"]).unwrap();
    assert_eq!(read.note.as_deref(), Some("f.csv: values in percent, divided by 100"));
    assert!((read.columns[0].1.values()[1] - 0.008).abs() < 1e-15);
    assert!((read.columns[1].1.values()[0] - 0.9).abs() < 1e-15);
    let error = |text: &str| parse(text, Path::new("f.csv")).unwrap_err().to_string();
    assert_eq!(error("nm,R\n400%,5\n"), "f.csv: line 2: found '400%'; expected a finite number");
    for (text, found) in [("nm,R\n400,5%\n410,6\n", "'6'"), ("nm,R\n400,5\n410,6%\n", "'6%'")] {
        let expected = "a percent sign in every row of a column, or in none";
        assert_eq!(error(text), format!("f.csv: line 3: found {found} in column 'R'; expected {expected}"));
    }
}

#[test]
fn percent_that_cannot_be_names_line_and_column() {
    let error = |text, names: &[&str]| transmittances(text, names).unwrap_err();
    assert_eq!(
        error("nm,R,W\n400,5,90\n410,25,101\n", &["R", "W"]),
        "f.csv: line 3: found 101 in column 'W'; expected at most 100 %; divide values in another unit, such as digital numbers, by their maximum"
    );
    // A column of fractions beside one of percent.
    let mixed = error("nm,R,W\n400,0.5,90\n410,0.25,95\n", &["R", "W"]);
    assert!(
        mixed.starts_with(
            "f.csv: line 2: found 0.5 in column 'R'; expected percent as in column 'W' (95 in line 3)"
        ),
        "{mixed}"
    );
    let mixed = error("nm,R,W (%)\n400,0.5,0.9\n410,0.25,0.95\n", &["R", "W"]);
    assert!(mixed.contains("column 'R'"), "{mixed}");
    // Neither: a curve that is not normalised is no percentage.
    let neither = error("nm,R\n400,0.5\n410,1.2\n", &["R"]);
    assert!(
        neither.starts_with("f.csv: line 3: found 1.2 in column 'R'; expected a transmittance from 0 to 1"),
        "{neither}"
    );
    // Columns that are not asked for have units of their own.
    assert!(transmittances("nm,R,power\n400,0.5,300\n410,0.4,400\n", &["R"]).is_ok());
}

proptest! {
    #[test]
    fn every_notation_of_a_table_reads_the_same(
        rows in prop::collection::vec((0.0..1.0f64, 0.06..1.0f64), 2..30),
        separator in prop::sample::select(vec![',', ';', '\t']), comma: bool, percent: bool,
    ) {
        // The columns are told to be in percent by their largest values, which are at least 6.
        let scale = if percent { 100.0 } else { 1.0 };
        let number = |v: f64| {
            let text = format!("{v}");
            if comma && separator != ',' { text.replace('.', ",") } else { text }
        };
        let mut text = format!("nm{separator}R{separator}G\n");
        for (i, (a, b)) in rows.iter().enumerate() {
            let (nm, a) = (400.0 + 2.5 * i as f64, a.max(if i == 0 { 0.06 } else { 0.0 }));
            text += &format!("{}{separator}{}{separator}{}\n", number(nm), number(a * scale), number(b * scale));
        }
        let read = parse(&text, Path::new("f")).unwrap().transmittances(&["R", "G"]).unwrap();
        prop_assert_eq!(read.note.is_some(), percent || separator != ',');
        for (got, (_, want)) in read.columns[1].1.values().iter().zip(&rows) {
            prop_assert!((got - want).abs() < 1e-12);
        }
    }

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
    fn any_text_is_read_or_refused(text in "[0-9.,;%#a\n\r\t \"eE+-]{0,200}") {
        if let Ok(t) = parse(&text, Path::new("f")) {
            prop_assert!(t.columns().iter().all(|(_, s)| s.grid().len() <= MAX_SAMPLES.max(text.len())));
        }
    }
}
