//! Suggestions for mistyped names.

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

#[cfg(test)]
mod tests {
    use super::*;

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
