//! Marks of MTF50 values that must not be read as a resolution, and their meaning.

use smalti::metrics::esfr::Mtf50Reliability;

/// The mark of a value in a table; empty for a reliable one.
pub(crate) fn mark(reliability: Mtf50Reliability) -> &'static str {
    match reliability {
        Mtf50Reliability::Reliable => "",
        Mtf50Reliability::BeyondNyquist => " *",
        Mtf50Reliability::Plateau => " †",
        Mtf50Reliability::NoEdge => " ‡",
    }
}

/// The meaning of each mark that occurs, as sentences.
pub(crate) fn meanings(all: impl IntoIterator<Item = Mtf50Reliability>) -> Vec<String> {
    let mut found = [false; 3];
    for reliability in all {
        match reliability {
            Mtf50Reliability::Reliable => {}
            Mtf50Reliability::BeyondNyquist => found[0] = true,
            Mtf50Reliability::Plateau => found[1] = true,
            Mtf50Reliability::NoEdge => found[2] = true,
        }
    }
    let meaning = |reliability: Mtf50Reliability, text: &str| format!("{} {text}", mark(reliability).trim());
    let texts = [
        meaning(
            Mtf50Reliability::BeyondNyquist,
            "MTF50 lies beyond the 0.5 cycles per pixel that the pixels sample (Nyquist frequency). Such detail is aliased, not resolved.",
        ),
        meaning(
            Mtf50Reliability::Plateau,
            "The edge response stays near one half over a wide range of frequencies or rises again, so that a small change moves MTF50 far.",
        ),
        meaning(
            Mtf50Reliability::NoEdge,
            "The picture shows no straight edge, as after strong interpolation errors or where it is saturated, and there is no MTF50.",
        ),
    ];
    texts.into_iter().zip(found).filter_map(|(text, found)| found.then_some(text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use Mtf50Reliability::{BeyondNyquist, Plateau, Reliable};

    #[test]
    fn only_marks_that_occur_are_explained() {
        assert!(meanings([Reliable, Reliable]).is_empty());
        let beyond = meanings([Reliable, BeyondNyquist, BeyondNyquist]);
        assert!(beyond.len() == 1 && beyond[0].starts_with("* MTF50"), "{beyond:?}");
        assert_eq!(meanings([Plateau, BeyondNyquist]).len(), 2);
        assert_eq!(mark(Reliable), "");
    }
}
