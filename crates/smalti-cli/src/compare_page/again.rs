//! What it takes to make the page again.

use smalti::camera::Camera;
use smalti_report::page::{Markup, copyable, el};

use crate::study_report::quoted;

/// One command for the same again, the facts, and every key of every camera; `typed` are the cameras as they were named.
pub(super) fn section(
    words: &[String],
    typed: &[String],
    facts: &[(&str, String)],
    cameras: &[(String, &Camera)],
) -> anyhow::Result<Markup> {
    let facts = facts.iter().map(|(k, v)| Markup::from(el("dt").child(*k)).and(el("dd").child(v)));
    let mut out: Markup = el("p")
        .child("The same version gives the same figures to the bit, on any number of threads. The command writes the files of cameras anew; other files that it names must be as they were.")
        .into();
    out = out
        .and(el("dl").class("facts").children(facts))
        .and(copyable(&with_files(words, typed, cameras)?, "command"))
        .and(el("p").child("Each camera as it was resolved, every key with its value; as a TOML file it is a camera for any command."));
    for (label, camera) in cameras {
        let text = toml::to_string(camera.description())?;
        let summary = el("summary").child(format!("{label}: the whole description"));
        out = out.and(el("details").child(summary).child(copyable(&text, "description")));
    }
    Ok(out)
}

/// The words as one would type them, after what writes each camera that is no built-in one to a file of its own.
fn with_files(words: &[String], typed: &[String], cameras: &[(String, &Camera)]) -> anyhow::Result<String> {
    let (mut words, mut files) = (words.to_vec(), String::new());
    let of_files = typed
        .iter()
        .zip(cameras)
        .filter(|(name, _)| smalti_io::cameras::names().iter().all(|c| c.name != **name));
    for (i, (name, (_, camera))) in of_files.enumerate() {
        let file = format!("again-{}.toml", i + 1);
        let text = toml::to_string(camera.description())?;
        let mut end = "EOF".to_owned();
        while text.lines().any(|line| line == end) {
            end.push('_');
        }
        files += &format!("cat > {file} <<'{end}'\n{text}{end}\n");
        words.iter_mut().filter(|word| *word == name).for_each(|word| word.clone_from(&file));
    }
    Ok(files + &command(&words))
}

/// The words as one would type them.
fn command(words: &[String]) -> String {
    words.iter().fold("smalti".to_owned(), |line, word| format!("{line} {}", typed(word)))
}

/// A word for a POSIX shell; options stay options.
fn typed(word: &str) -> String {
    let name = word.trim_start_matches('-');
    let dashes = &word[..word.len() - name.len()];
    match (dashes, name.split_once('=')) {
        ("", _) => quoted(word),
        (_, Some((option, value))) if !value.is_empty() => {
            format!("{dashes}{}={}", quoted(option), quoted_value(value))
        }
        (_, _) if name.is_empty() => word.to_owned(),
        _ => format!("{dashes}{}", quoted(name)),
    }
}

/// Of `--key=value`: a value that begins with a hyphen is none of a file.
fn quoted_value(value: &str) -> String {
    if value.starts_with('-') { format!("'{}'", value.replace('\'', "'\\''")) } else { quoted(value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_what_was_typed() {
        let words = [
            "compare",
            "bayer",
            "a b.toml",
            "--luminance",
            "1,80",
            "--set",
            "x=[1,2]",
            "--output=it's",
            "-o",
            "$(rm)",
            "--gain=-1",
            "-",
        ];
        assert_eq!(
            command(&words.map(str::to_owned)),
            "smalti compare bayer 'a b.toml' --luminance 1,80 --set 'x=[1,2]' --output='it'\\''s' -o '$(rm)' --gain='-1' -"
        );
    }
}
