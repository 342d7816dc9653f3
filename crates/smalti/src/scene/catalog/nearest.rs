//! The known word that is nearest to a mistyped one.

/// The candidate that begins with the word, else the one with the least number of inserted, deleted and replaced
/// characters; the first of equals. Empty when there are none.
pub(super) fn nearest(word: &str, candidates: &[&'static str]) -> &'static str {
    // Names are short; of a long text only the beginning matters.
    let word: Vec<char> = word.chars().take(64).collect();
    let shortened = |c: &&str| word.len() > 1 && word.iter().copied().eq(c.chars().take(word.len()));
    let candidates = || candidates.iter().copied();
    candidates().find(shortened).or_else(|| candidates().min_by_key(|c| distance(&word, c))).unwrap_or("")
}

/// Levenshtein distance.
fn distance(a: &[char], b: &str) -> usize {
    let mut row: Vec<usize> = (0..=a.len()).collect();
    for (i, cb) in b.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &ca) in a.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[a.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_are_forgiven() {
        let names = ["macbeth", "uniform", "zone-plate"];
        assert_eq!(nearest("zoneplate", &names), "zone-plate");
        assert_eq!(nearest("macbet", &names), "macbeth");
        assert_eq!(nearest("unif", &["zone", "uniform"]), "uniform");
        assert_eq!(nearest("", &[]), "");
        assert_eq!(distance(&['k', 'i', 't', 't', 'e', 'n'], "sitting"), 3);
    }
}
