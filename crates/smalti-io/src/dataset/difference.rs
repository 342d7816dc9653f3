//! Differences between two JSON values, for error messages.

use std::fmt;

use serde_json::Value;

/// Maximum number of listed differences.
const SHOWN: usize = 20;
/// Maximum length of a shown value, characters.
const WIDTH: usize = 60;

/// A key whose values differ. The values are JSON text, truncated to 60 characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Path of the key, such as `axes[0].from_um`.
    pub key: String,
    /// The old value, if any.
    pub was: Option<String>,
    /// The new value, if any.
    pub now: Option<String>,
}

/// Keys whose values differ: the first twenty, and the number of others.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Differences {
    /// The first differences, in the order of the old value.
    pub shown: Vec<Difference>,
    /// Number of differences that are not listed.
    pub more: usize,
}

impl Differences {
    /// Compares an old value with a new one.
    #[must_use]
    pub fn of(was: &Value, now: &Value) -> Self {
        let mut out = Self::default();
        out.walk("", Some(was), Some(now));
        out
    }

    /// Whether the values are equal.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.shown.is_empty()
    }

    fn walk(&mut self, key: &str, was: Option<&Value>, now: Option<&Value>) {
        let inner = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
        match (was, now) {
            (Some(Value::Object(was)), Some(Value::Object(now))) => {
                for (name, value) in was {
                    self.walk(&inner(name), Some(value), now.get(name));
                }
                for (name, value) in now.iter().filter(|(name, _)| !was.contains_key(*name)) {
                    self.walk(&inner(name), None, Some(value));
                }
            }
            (Some(Value::Array(was)), Some(Value::Array(now))) => {
                for i in 0..was.len().max(now.len()) {
                    self.walk(&format!("{key}[{i}]"), was.get(i), now.get(i));
                }
            }
            _ if was == now => {}
            _ if self.shown.len() == SHOWN => self.more += 1,
            _ => self.shown.push(Difference { key: key.to_owned(), was: was.map(line), now: now.map(line) }),
        }
    }
}

/// A value as JSON, truncated to [`WIDTH`].
fn line(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(WIDTH) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or_default()),
        None => text,
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [was, now] = [&self.was, &self.now].map(|v| v.as_deref().unwrap_or("(absent)"));
        write!(f, "{}: {was} → {now}", self.key)
    }
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, difference) in self.shown.iter().enumerate() {
            write!(f, "{}  {difference}", if i == 0 { "" } else { "\n" })?;
        }
        if self.more > 0 { write!(f, "\n  … and {} more", self.more) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn differences_are_named_by_their_keys() {
        let was = json!({"seed": 1, "a": {"b": [1, 2, {"c": "x"}], "gone": null}, "same": [1.5]});
        let now = json!({"same": [1.5], "seed": 2, "a": {"b": [1, 2.0, {"c": "y"}, 4], "new": true}});
        let text = Differences::of(&was, &now).to_string();
        let expected = "  seed: 1 → 2\n  a.b[1]: 2 → 2.0\n  a.b[2].c: \"x\" → \"y\"\n  a.b[3]: (absent) → 4\n  \
                        a.gone: null → (absent)\n  a.new: (absent) → true";
        assert_eq!(text, expected);
        assert!(Differences::of(&was, &was).is_empty());
    }

    #[test]
    fn long_values_and_long_lists_are_cut() {
        let text = Differences::of(&json!({"k": "é".repeat(100)}), &json!({})).to_string();
        assert_eq!(text, format!("  k: \"{}… → (absent)", "é".repeat(59)));
        let differences = Differences::of(&json!((0..50).collect::<Vec<_>>()), &json!([]));
        assert_eq!((differences.shown.len(), differences.more), (20, 30));
        assert!(differences.to_string().ends_with("  [19]: 19 → (absent)\n  … and 30 more"));
    }
}
