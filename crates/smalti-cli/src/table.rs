//! A table in plain text: first column left, numbers right.

/// Lines of cells under a header, columns as wide as their widest cell.
pub(crate) fn render(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |c: usize| {
        let cells = rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count());
        cells.chain(header.get(c).map(|s| s.chars().count())).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let padded = cells.zip(&widths).enumerate().map(|(c, (s, &w))| {
            let pad = " ".repeat(w.saturating_sub(s.chars().count()));
            if c == 0 { format!("{s}{pad}") } else { format!("{pad}{s}") }
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let mut out = vec![line(&mut header.iter().copied())];
    out.push(widths.iter().map(|&w| "─".repeat(w)).collect::<Vec<_>>().join("  "));
    out.extend(rows.iter().map(|r| line(&mut r.iter().map(String::as_str))));
    out.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    #[test]
    fn columns_line_up() {
        let rows = [vec!["a".to_owned(), "1.0".into()], vec!["long".into(), "12.0".into()]];
        assert_eq!(super::render(&["x", "ΔE"], &rows), "x       ΔE\n────  ────\na      1.0\nlong  12.0\n");
    }
}
