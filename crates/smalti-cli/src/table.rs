//! Tables in plain text, with the first column left-aligned and all others right-aligned, that fit the width of a terminal.

use smalti::names::in_one_line;
use unicode_width::UnicodeWidthStr;

/// Between columns.
const GAP: &str = "  ";
/// The least width of shortened texts.
const MIN_TEXT: usize = 8;

/// A table with a header. It fits the width of a terminal; elsewhere its width is not limited.
pub(crate) fn render(header: &[&str], rows: &[Vec<String>]) -> String {
    within(header, rows, crate::terminal::columns())
}

/// A table at most `columns` characters wide where possible. Headings are wrapped first, then texts are shortened, then columns are
/// moved to further blocks below.
fn within(header: &[&str], rows: &[Vec<String>], columns: Option<usize>) -> String {
    let cell =
        |row: &Vec<String>, c: usize| row.get(c).map_or(String::new(), |t| in_one_line(t).into_owned());
    let mut table: Vec<Column> = (0..header.len())
        .map(|c| {
            let head = vec![header.get(c).copied().unwrap_or_default().to_owned()];
            Column { head, cells: rows.iter().map(|r| cell(r, c)).collect(), left: c == 0 }
        })
        .collect();
    let fits = |table: &[Column]| columns.is_none_or(|limit| across(table) <= limit);
    if !fits(&table) {
        table.iter_mut().for_each(Column::break_head);
    }
    while !fits(&table) {
        let texts = table.iter_mut().filter(|c| c.is_text() && c.width() > MIN_TEXT);
        let Some(widest) = texts.max_by_key(|c| c.width()) else { break };
        widest.shorten(widest.width() - 1);
    }
    if fits(&table) {
        return draw(&table.iter().collect::<Vec<_>>());
    }
    fold(&table, columns.unwrap_or(usize::MAX))
}

/// Blocks below each other, each of which begins with the first columns that together identify a row.
fn fold(table: &[Column], limit: usize) -> String {
    let distinct = |count: usize| {
        let mut rows: Vec<Vec<&String>> =
            (0..rows_of(table)).map(|r| table[..count].iter().map(|c| &c.cells[r]).collect()).collect();
        rows.sort();
        rows.windows(2).all(|w| w[0] != w[1])
    };
    let names = (1..table.len()).find(|&n| distinct(n)).unwrap_or(1).min(table.len());
    let (names, mut rest) = table.split_at(names);
    if rest.is_empty() {
        return draw(&names.iter().collect::<Vec<_>>());
    }
    let mut blocks = Vec::new();
    while !rest.is_empty() {
        let fitting = |n: &usize| across(names) + GAP.len() + across(&rest[..*n]) <= limit;
        let count = (1..=rest.len()).take_while(fitting).last().unwrap_or(1);
        let (block, after) = rest.split_at(count);
        blocks.push(draw(&names.iter().chain(block).collect::<Vec<_>>()));
        rest = after;
    }
    blocks.join("\n")
}

struct Column {
    head: Vec<String>,
    cells: Vec<String>,
    left: bool,
}

impl Column {
    fn width(&self) -> usize {
        self.head.iter().chain(&self.cells).map(|s| s.width()).max().unwrap_or(0)
    }

    fn is_text(&self) -> bool {
        self.cells.iter().any(|c| c.chars().any(char::is_alphabetic))
    }

    fn break_head(&mut self) {
        let words: Vec<String> = self.head.iter().flat_map(|h| h.split(' ')).map(str::to_owned).collect();
        let cells = self.cells.iter().map(|s| s.width());
        let limit = words.iter().map(|w| w.width()).chain(cells).max().unwrap_or(0);
        self.head = wrap(&words.join(" "), limit);
    }

    fn shorten(&mut self, limit: usize) {
        self.cells.iter_mut().chain(&mut self.head).for_each(|text| *text = shortened(text, limit));
    }
}

/// A text cut to a width with an ellipsis.
fn shortened(text: &str, limit: usize) -> String {
    if text.width() <= limit {
        return text.to_owned();
    }
    let mut out = text.to_owned();
    while !out.is_empty() && out.width() + 1 > limit {
        out.pop();
    }
    out + "…"
}

/// A text wrapped at spaces to lines of a width; a longer word has a line of its own.
pub(crate) fn wrap(text: &str, limit: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut().filter(|l| l.width() + 1 + word.width() <= limit) {
            Some(line) => *line = format!("{line} {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

fn rows_of(table: &[Column]) -> usize {
    table.first().map_or(0, |c| c.cells.len())
}

fn across(table: &[Column]) -> usize {
    table.iter().map(Column::width).sum::<usize>() + GAP.len() * table.len().saturating_sub(1)
}

fn draw(table: &[&Column]) -> String {
    let widths: Vec<usize> = table.iter().map(|c| c.width()).collect();
    let line = |cells: &dyn Fn(&Column) -> String| {
        let padded = table.iter().zip(&widths).map(|(column, width)| {
            let text = cells(column);
            let pad = " ".repeat(width.saturating_sub(text.width()));
            if column.left { text + &pad } else { pad + &text }
        });
        padded.collect::<Vec<_>>().join(GAP).trim_end().to_owned()
    };
    let heads = table.iter().map(|c| c.head.len()).max().unwrap_or(0);
    // Headings of fewer lines are aligned to the bottom.
    let head = |column: &Column, l: usize| {
        (l + column.head.len()).checked_sub(heads).and_then(|l| column.head.get(l)).cloned()
    };
    let mut out: Vec<String> = (0..heads).map(|l| line(&|c| head(c, l).unwrap_or_default())).collect();
    out.push(widths.iter().map(|&w| "─".repeat(w)).collect::<Vec<_>>().join(GAP));
    let rows = table.first().map_or(0, |c| c.cells.len());
    out.extend((0..rows).map(|r| line(&|c| c.cells.get(r).cloned().unwrap_or_default())));
    out.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: &[&[&str]]) -> Vec<Vec<String>> {
        rows.iter().map(|r| r.iter().map(|c| (*c).to_owned()).collect()).collect()
    }

    #[test]
    fn columns_line_up() {
        let rows = rows(&[&["a", "1.0"], &["long", "12.0"]]);
        assert_eq!(within(&["x", "ΔE"], &rows, None), "x       ΔE\n────  ────\na      1.0\nlong  12.0\n");
        // Characters of double width count twice.
        let wide = within(&["x", "y"], &[vec!["相机".into(), "1".into()]], None);
        assert_eq!(wide, "x     y\n────  ─\n相机  1\n");
    }

    const HEADER: [&str; 5] = ["camera", "cd/m²", "MTF50 cy/mm", "noise %", "CPSNR dB"];

    fn scores() -> Vec<Vec<String>> {
        rows(&[
            &["a camera of a long name", "1", "107.7", "72.72", "23.45"],
            &["a camera of a long name", "80", "107.7", "2.45", "24.61"],
            &["b", "80", "90.9", "2.21", "33.33"],
        ])
    }

    #[test]
    fn a_table_fits_and_loses_no_number() {
        let whole = within(&HEADER, &scores(), None);
        assert_eq!(whole, within(&HEADER, &scores(), Some(62)));
        for limit in 25..=100 {
            let table = within(&HEADER, &scores(), Some(limit));
            assert!(table.lines().all(|l| l.width() <= limit), "{limit}:\n{table}");
            for number in ["107.7", "90.9", "72.72", "2.45", "2.21", "23.45", "24.61", "33.33", "80"] {
                assert!(table.contains(number), "{number} at {limit}:\n{table}");
            }
        }
    }

    #[test]
    fn headings_break_then_texts_shrink_then_columns_fold() {
        let broken = within(&HEADER, &scores(), Some(60));
        assert!(
            broken.contains("MTF50") && !broken.contains("MTF50 cy/mm") && !broken.contains('…'),
            "{broken}"
        );
        let shrunk = within(&HEADER, &scores(), Some(45));
        assert!(shrunk.contains('…') && shrunk.lines().count() == 6, "{shrunk}");
        let folded = within(&HEADER, &scores(), Some(25));
        // Camera and light tell the rows apart, so that each block has both.
        let blocks: Vec<&str> = folded.split("\n\n").collect();
        assert!(blocks.len() == 3 && blocks.iter().all(|b| b.contains("cd/m²")), "{folded}");
    }

    #[test]
    fn what_cannot_fit_is_still_there() {
        let table = within(&HEADER, &scores(), Some(1));
        assert!(table.contains("107.7") && table.contains("33.33"), "{table}");
        assert_eq!(within(&[], &[], Some(1)), "\n");
        assert_eq!(within(&["x"], &[], Some(80)), "x\n─\n");
    }
}
