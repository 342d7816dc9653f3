//! The name a user may have meant.

/// The name with the fewest letters to change, when that is at most a third of them; case does not count.
pub(super) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    // Longer input cannot be a slip of the pen, and the comparison takes time with the product of the lengths.
    if name.len() > 64 {
        return None;
    }
    let typed: Vec<char> = name.to_lowercase().chars().collect();
    let best = known.map(|k| (distance(&typed, &k.to_lowercase().chars().collect::<Vec<_>>()), k)).min()?;
    (best.0 * 3 <= typed.len().max(3)).then(|| best.1.to_owned())
}

/// Insertions, deletions and replacements between two words (Levenshtein 1966).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_understood_and_nonsense_is_not() {
        let known = ["bayer", "xtrans", "quad-bayer"];
        assert_eq!(nearest("Bayr", known.into_iter()).as_deref(), Some("bayer"));
        assert_eq!(nearest("x-trans", known.into_iter()).as_deref(), Some("xtrans"));
        assert_eq!(nearest("spectrometer", known.into_iter()), None);
        assert_eq!(nearest(&"a".repeat(100_000), known.into_iter()), None);
    }
}
