//! What it takes to compute the results again.

use smalti_io::studies;
use smalti_report::page::{Markup, copyable, el};

use super::Sources;
use crate::study_report::results::{Results, plain};

/// Largest study that is written out, bytes.
const MOST: usize = 200_000;

/// A section with a command for each study.
pub(super) fn section(sources: &Sources<'_>) -> anyhow::Result<Markup> {
    let mut out: Markup = el("p")
        .child("The same version gives the same results to the bit, whatever the threads, shards and interruptions.")
        .into();
    for (results, _) in sources.all {
        let manifest = results.dataset.manifest();
        let facts = [
            ("study", results.name()),
            ("seed", results.study().seed.to_string()),
            ("Smalti", plain(&manifest.smalti)),
            ("designs", manifest.plan.designs.to_string()),
            ("BLAKE3 of the plan", manifest.hash().to_owned()),
        ];
        let facts = facts.into_iter().map(|(k, v)| Markup::from(el("dt").child(k)).and(el("dd").child(v)));
        out = out.and(el("dl").class("facts").children(facts));
        out = match command(results)? {
            Some(command) => out.and(copyable(&command, "command")),
            None => out.and(el("p").child(
                "The study is not whole on this page: it is too large, or names files of scenes. Give its TOML file to smalti sweep; without \
                 files of scenes, the manifest.json of the results does as well.",
            )),
        };
    }
    Ok(out)
}

/// One command for the results and their report; `None` where the study cannot be written out.
fn command(results: &Results) -> anyhow::Result<Option<String>> {
    let name = &results.study().name;
    let built_in = studies::names().iter().any(|s| s.name == name)
        && studies::load(name).is_ok_and(|(designs, _)| designs.study() == results.study());
    if built_in {
        return Ok(Some(format!("smalti sweep {name} -o again && smalti report again")));
    }
    if results.study().scenes.iter().any(|s| s.hash.is_some()) {
        return Ok(None);
    }
    let study = ascii(&serde_json::to_string_pretty(&results.dataset.manifest().plan.study)?);
    // No line of JSON is the word that ends it.
    let command = format!(
        "cat > study.json <<'EOF'\n{study}\nEOF\nsmalti sweep study.json -o again && smalti report again"
    );
    Ok((command.len() <= MOST).then_some(command))
}

/// JSON of ASCII characters alone: what is copied is what was written, whatever a page or terminal makes of other signs.
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

/// A word of a command for a POSIX shell.
pub(crate) fn quoted(word: &str) -> String {
    let safe = |c: char| c.is_ascii_alphanumeric() || "_./-+,:@%".contains(c);
    if !word.is_empty() && !word.starts_with('-') && word.chars().all(safe) {
        return word.to_owned();
    }
    let dashed = if word.starts_with('-') { format!("./{word}") } else { word.to_owned() };
    format!("'{}'", dashed.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_commands_are_quoted() {
        assert_eq!(quoted("out/a-1"), "out/a-1");
        assert_eq!(quoted("a b; rm -r '*'"), "'a b; rm -r '\\''*'\\'''");
        assert_eq!(quoted("-o"), "'./-o'");
    }

    #[test]
    fn json_in_commands_is_ascii_and_the_same() {
        let value = serde_json::json!({"name": "Größe \u{202e} 🟥"});
        let text = ascii(&value.to_string());
        assert!(text.is_ascii());
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).ok(), Some(value));
    }
}
