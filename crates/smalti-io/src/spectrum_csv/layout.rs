//! How a text file separates its columns and writes its numbers.

/// The separator of columns and the decimal mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    separator: char,
    /// The decimal mark, once a number has one. Columns that commas separate have decimal points.
    decimal: Option<char>,
}

impl Layout {
    /// The layout of a file from its first line: semicolons, else tabs, else commas.
    pub(super) fn of(line: &str) -> Self {
        let separator = [';', '\t'].into_iter().find(|c| line.contains(*c)).unwrap_or(',');
        Self { separator, decimal: (separator == ',').then_some('.') }
    }

    /// The fields of a line, without the quotes around them.
    pub(super) fn fields<'a>(&self, line: &'a str) -> Vec<&'a str> {
        line.split(self.separator).map(|v| v.trim().trim_matches('"').trim()).collect()
    }

    /// The number in a field; `None` also where its decimal mark is not that of the numbers before, since `1,000` would be one
    /// thousand beside decimal points.
    pub(super) fn number(&mut self, field: &str) -> Option<f64> {
        let mark = field.chars().find(|c| [',', '.'].contains(c));
        let number = match (mark, self.decimal) {
            (Some(mark), Some(known)) if mark != known => None,
            (Some(','), _) => field.replacen(',', ".", 1).parse().ok(),
            _ => field.parse().ok(),
        };
        if number.is_some() {
            self.decimal = self.decimal.or(mark);
        }
        number
    }

    /// What [`Layout::number`] expects.
    pub(super) fn expected(&self) -> &'static str {
        match self.decimal {
            Some(',') => "a finite number with a decimal comma, as before",
            Some(_) if self.separator != ',' => "a finite number with a decimal point, as before",
            _ => "a finite number",
        }
    }

    /// What is not plain in it.
    pub(super) fn in_words(&self) -> Vec<&'static str> {
        let separator = match self.separator {
            ';' => Some("columns separated by semicolons"),
            '\t' => Some("columns separated by tabs"),
            _ => None,
        };
        separator.into_iter().chain((self.decimal == Some(',')).then_some("decimal commas")).collect()
    }
}

/// The name in a heading, and whether it states percent: `R (%)`, `R [%]`, `R %` and `R_percent` are `R` in percent.
pub(super) fn heading(text: &str) -> (String, bool) {
    let lower = text.to_ascii_lowercase();
    let stripped = ["(%)", "[%]", "%", "_percent", "(percent)", "[percent]", " percent"]
        .iter()
        .find(|end| lower.ends_with(**end))
        .map(|end| text[..text.len() - end.len()].trim_end_matches([' ', '_']));
    match stripped {
        Some("") => (text.to_owned(), true),
        Some(name) => (name.to_owned(), true),
        None => (text.to_owned(), false),
    }
}
