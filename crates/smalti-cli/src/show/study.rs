//! A study: its file and the number of its trials.

use std::path::Path;

use serde_json::json;
use smalti_io::{studies, text};

use super::datasheet::{Datasheet, Part};

/// The summary and the TOML of a camera or study.
pub(super) fn file(name: &str, built_in: &[smalti_io::BuiltinFile]) -> anyhow::Result<(String, String)> {
    match built_in.iter().find(|f| f.name == name) {
        Some(file) => Ok((file.summary.into(), file.toml.into())),
        None => Ok((String::new(), text::read_to_string(Path::new(name))?)),
    }
}

pub(super) fn datasheet(name: &str) -> anyhow::Result<Datasheet> {
    let (trials, about) = studies::load(name).map_err(anyhow::Error::from)?;
    let (summary, toml) = file(name, studies::names())?;
    let study = trials.study();
    let title = format!("{}: a study of {} trials", study.name, trials.len());
    let next = format!("smalti sweep {name} --dry-run estimates its duration.");
    Ok(Datasheet {
        title,
        about: vec![if about.is_empty() { summary.clone() } else { about.clone() }, next],
        parts: vec![Part::Lines(toml.clone())],
        json: json!({
            "kind": "study", "name": study.name, "summary": summary, "about": about, "trials": trials.len(), "toml": toml,
        }),
        toml: Some(toml),
    })
}
