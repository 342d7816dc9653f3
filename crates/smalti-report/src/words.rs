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

/// The words of a command of `smalti` for a POSIX shell.
pub(crate) fn command(words: &[String]) -> String {
    words.iter().fold("smalti".to_owned(), |line, word| format!("{line} {}", typed(word)))
}

/// A word for a POSIX shell; options stay options.
fn typed(word: &str) -> String {
    let name = word.trim_start_matches('-');
    let dashes = &word[..word.len() - name.len()];
    match (dashes, name.split_once('=')) {
        ("", _) => quoted(word),
        (_, Some((option, value))) if !value.is_empty() => {
            format!("{dashes}{}={}", quoted(option), quoted_value(value))
        }
        (_, _) if name.is_empty() => word.to_owned(),
        _ => format!("{dashes}{}", quoted(name)),
    }
}

/// The value of `--key=value`. One that begins with a hyphen does not name a file.
fn quoted_value(value: &str) -> String {
    if value.starts_with('-') { format!("'{}'", value.replace('\'', "'\\''")) } else { quoted(value) }
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
    fn the_command_is_what_was_typed() {
        let words = [
            "compare",
            "bayer",
            "a b.toml",
            "--luminance",
            "1,80",
            "--set",
            "x=[1,2]",
            "--output=it's",
            "-o",
            "$(rm)",
            "--gain=-1",
            "-",
            "./-o",
        ];
        assert_eq!(
            command(&words.map(str::to_owned)),
            "smalti compare bayer 'a b.toml' --luminance 1,80 --set 'x=[1,2]' --output='it'\\''s' -o '$(rm)' --gain='-1' - ./-o"
        );
    }

    #[test]
    fn thousands_are_grouped() {
        assert_eq!(
            [0, 9999, 10_000, 1_234_567].map(grouped),
            ["0", "9999", "10\u{202f}000", "1\u{202f}234\u{202f}567"]
        );
    }
}
