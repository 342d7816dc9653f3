//! The name a user may have meant.

/// The known name that begins with `name` (two letters or more), else that with the fewest letters to insert, delete, replace or exchange with their neighbour, when these are
/// at most a third of the letters of `name`; case does not count. The first of equals.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer input cannot be a slip of the pen, and the comparison takes time with the product of the lengths.
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

/// The end of a message: `; did you mean 'bayer'?`, or nothing.
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
