//! How the results are computed again.

use super::sources::Sources;
use crate::page::{Markup, copyable, el};
use crate::study::results::Results;
use crate::words::plain;

/// The largest study in a command, bytes.
const MAX_COMMAND_BYTES: usize = 200_000;

/// A section with a command for each study.
pub(super) fn section(sources: &Sources<'_>) -> Markup {
    let mut out: Markup = el("p")
        .child("The same version of Smalti gives the same results bit for bit, with any number of threads, shards and interruptions.")
        .into();
    for (results, _) in sources.all {
        let data = &results.data;
        let facts = [
            ("study", results.name()),
            ("seed", results.study().seed.to_string()),
            ("Smalti", plain(&data.smalti_version)),
            ("trials", data.trials.len().to_string()),
            ("BLAKE3 of the plan", data.plan_blake3.clone()),
        ];
        let facts = facts.into_iter().map(|(k, v)| Markup::from(el("dt").child(k)).and(el("dd").child(v)));
        out = out.and(el("dl").class("facts").children(facts));
        out = match command(results) {
            Some(command) => out.and(copyable(&command, "command")),
            None => out.and(el("p").child(
                "This page does not contain the whole study, since it is too large or names files of scenes. Run smalti sweep with its TOML file. \
                 A study without files of scenes can also be run from the manifest.json of its results.",
            )),
        };
    }
    out
}

/// One command for the results and their report; `None` where the study cannot be part of a command.
fn command(results: &Results) -> Option<String> {
    let name = &results.study().name;
    if results.data.is_built_in {
        return Some(format!("smalti sweep {name} -o again && smalti report again"));
    }
    if results.study().scenes.iter().any(|s| s.hash.is_some()) {
        return None;
    }
    let study = ascii(&results.data.study_json);
    // No line of JSON is `EOF`.
    let command = format!(
        "cat > study.json <<'EOF'\n{study}\nEOF\nsmalti sweep study.json -o again && smalti report again"
    );
    (command.len() <= MAX_COMMAND_BYTES).then_some(command)
}

/// JSON of ASCII characters alone, so that a copy does not depend on how a page or terminal treats other characters.
fn ascii(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            out.push(c);
        } else {
            let mut units = [0; 2];
            c.encode_utf16(&mut units).iter().for_each(|u| out.push_str(&format!("\\u{u:04x}")));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_in_commands_is_ascii_and_the_same() {
        let value = serde_json::json!({"name": "Größe \u{202e} 🟥"});
        let text = ascii(&value.to_string());
        assert!(text.is_ascii());
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).ok(), Some(value));
    }
}
