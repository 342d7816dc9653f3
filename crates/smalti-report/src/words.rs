//! Texts that several pages share.

/// Lays out a header and rows of cells as lines of text.
pub type TextTable<'a> = dyn Fn(&[&str], &[Vec<String>]) -> String + 'a;

/// A number with thin spaces between thousands.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join("\u{202f}")
}

/// Names as a list in a sentence: `a, b and c`.
pub(crate) fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Text of a file without characters that would control a terminal.
pub(crate) fn plain(text: &str) -> String {
    smalti::names::in_one_line(text).into_owned()
}

/// A word of a command, quoted for a POSIX shell. A leading hyphen gets `./` in front, since the word names a file.
pub(crate) fn quoted(word: &str) -> String {
    let safe = |c: char| c.is_ascii_alphanumeric() || "_./-+,:@%".contains(c);
    if !word.is_empty() && !word.starts_with('-') && word.chars().all(safe) {
        return word.to_owned();
    }
    let dashed = if word.starts_with('-') { format!("./{word}") } else { word.to_owned() };
    format!("'{}'", dashed.replace('\'', "'\\''"))
}

/// An exposure time, ms, with at least three significant digits.
pub(crate) fn time_ms(ms: f64) -> String {
    let digits = match ms {
        ms if ms >= 10.0 || ms <= 0.0 => 1,
        ms => (2 - ms.log10().floor() as i32).clamp(2, 9) as usize,
    };
    format!("{ms:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_times_keep_their_digits() {
        let all = [
            (100.0, "100.0"),
            (33.0, "33.0"),
            (4.26, "4.26"),
            (0.5, "0.500"),
            (0.001_234, "0.00123"),
            (0.0, "0.0"),
        ];
        for (ms, text) in all {
            assert_eq!(time_ms(ms), text);
        }
    }

    #[test]
    fn words_of_commands_are_quoted() {
        assert_eq!(quoted("out/a-1"), "out/a-1");
        assert_eq!(quoted("a b; rm -r '*'"), "'a b; rm -r '\\''*'\\'''");
        assert_eq!(quoted("-o"), "'./-o'");
    }

    #[test]
    fn thousands_are_grouped() {
        assert_eq!(
            [0, 9999, 10_000, 1_234_567].map(grouped),
            ["0", "9999", "10\u{202f}000", "1\u{202f}234\u{202f}567"]
        );
    }
}
