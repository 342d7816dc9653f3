//! Suggestions for mistyped names, and text of others that is safe to show.

use std::borrow::Cow;

/// The known name closest to `name`, ignoring case; the first of several that are equally close.
///
/// A known name that begins with `name` (at least two letters) is preferred. Otherwise the distance is the
/// number of letters to insert, delete, replace or swap with a neighbour, and it may be at most a third of
/// the letters of `name`.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer input is no typing error, and the cost grows with the product of the lengths.
    if name.len() > 64 {
        return None;
    }
    let typed = name.trim().to_lowercase();
    let known: Vec<&str> = known.into_iter().collect();
    let longer = known.iter().find(|k| typed.chars().count() > 1 && k.to_lowercase().starts_with(&typed));
    if let Some(longer) = longer {
        return Some(longer);
    }
    let changes = |k: &str| strsim::osa_distance(&typed, &k.to_lowercase());
    let (least, best) = known.into_iter().map(|k| (changes(k), k)).min_by_key(|(n, _)| *n)?;
    (least * 3 <= typed.chars().count().max(3)).then_some(best)
}

/// The end of an error message: `; did you mean 'bayer'?`, or an empty string.
pub(crate) fn did_you_mean(suggestion: Option<&str>) -> String {
    suggestion.map(|s| format!("; did you mean '{s}'?")).unwrap_or_default()
}

/// Whether a character steers a terminal or the order of the text around it instead of standing for itself: control characters (C0,
/// delete, C1), line and paragraph separators, marks, overrides and isolates of direction (Unicode UAX #9), the byte order mark and the
/// last two of the basic plane, which XML forbids.
#[must_use]
pub fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{061C}' | '\u{200E}' | '\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
        || matches!(c, '\u{FEFF}' | '\u{FFFE}' | '\u{FFFF}')
}

/// A text of several lines without characters that steer a terminal: each is replaced by `�`, but for line ends and tabs.
#[must_use]
pub fn harmless(text: &str) -> Cow<'_, str> {
    let wrong = |c: char| steers(c) && c != '\n' && c != '\t';
    if !text.contains(wrong) {
        return Cow::Borrowed(text);
    }
    // The line ends of Windows are line ends.
    Cow::Owned(text.replace("\r\n", "\n").replace(wrong, "\u{FFFD}"))
}

/// A text in one line without characters that steer a terminal: line ends and tabs become spaces, others `�`.
#[must_use]
pub fn in_one_line(text: &str) -> Cow<'_, str> {
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.replace(['\n', '\r', '\t'], " ").replace(steers, "\u{FFFD}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_replaced() {
        let hostile = "a\u{1b}]0;title\u{7}b\u{9b}31m\u{202e}c\u{2066}\r\nd\te\u{7f}é相";
        let shown = harmless(hostile);
        assert_eq!(shown, "a�]0;title�b�31m�c�\nd\te�é相");
        assert_eq!(in_one_line(hostile), "a�]0;title�b�31m�c�  d e�é相");
        assert!(in_one_line(hostile).chars().all(|c| !steers(c)));
        assert!(matches!(harmless("plain, ünïcode\n"), Cow::Borrowed(_)));
        assert!(matches!(in_one_line("plain"), Cow::Borrowed(_)));
    }

    #[test]
    fn slips_are_understood_and_nonsense_is_not() {
        let known = ["bayer", "xtrans", "quad-bayer"];
        assert_eq!(nearest("Bayr", known), Some("bayer"));
        assert_eq!(nearest("byaer", known), Some("bayer"));
        assert_eq!(nearest("x-trans", known), Some("xtrans"));
        assert_eq!(nearest("spectrometer", known), None);
        assert_eq!(nearest(&"a".repeat(100_000), known), None);
        assert_eq!(nearest("quad", known), Some("quad-bayer"));
        assert_eq!(nearest("bayer", []), None);
    }
}
