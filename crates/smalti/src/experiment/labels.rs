//! Unique labels for cameras with equal names.

/// Adds a number from 1 to names that are empty or equal except for case: `1-bayer`, `rgbw`, `3-Bayer`.
#[must_use]
pub fn numbered(names: Vec<String>) -> Vec<String> {
    let alike = |a: &str, b: &str| a.to_lowercase() == b.to_lowercase();
    let twice = |all: &[String], name: &str| all.iter().filter(|n| alike(n, name)).count() > 1;
    let mark = |all: bool| {
        let number = |(i, name): (usize, &String)| match all || name.is_empty() || twice(&names, name) {
            true => format!("{}-{name}", i + 1),
            false => name.clone(),
        };
        names.iter().enumerate().map(number).collect::<Vec<_>>()
    };
    let some = mark(false);
    // A numbered name may equal another name; then all are numbered.
    if some.iter().any(|name| twice(&some, name)) { mark(true) } else { some }
}
