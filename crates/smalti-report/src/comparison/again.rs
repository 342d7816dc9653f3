//! How the page is made again.

use smalti::camera::Camera;

use super::results::CommandLine;
use crate::ReportError;
use crate::page::{Markup, copyable, el};
use crate::words::command;

/// The facts, one command that computes the results again, and the description of every camera.
pub(super) fn section(
    command: &CommandLine,
    (noise, light): (String, String),
    scenes: Option<String>,
    (cameras, labels): (&[Camera], &[String]),
) -> Result<Markup, ReportError> {
    let version = env!("CARGO_PKG_VERSION").to_owned();
    let facts = [("Smalti", version), ("noise", noise), ("light", light)];
    let facts = facts.into_iter().chain(scenes.map(|names| ("scenes", names)));
    let facts = facts.map(|(k, v)| Markup::from(el("dt").child(k)).and(el("dd").child(v)));
    let about = el("p").child("The same version of Smalti gives the same figures bit for bit, on any number of threads. The command first writes the files of cameras. Other files that it names must be unchanged.");
    let mut out = Markup::from(about)
        .and(el("dl").class("facts").children(facts))
        .and(copyable(&with_files(command, cameras)?, "command"))
        .and(el("p").child("The descriptions of the cameras contain every key with its value. Saved as a TOML file, a description is a camera for any command."));
    for (label, camera) in labels.iter().zip(cameras) {
        let text = toml::to_string(camera.description())?;
        let summary = el("summary").child(format!("{label}: the whole description"));
        out = out.and(el("details").child(summary).child(copyable(&text, "description")));
    }
    Ok(out)
}

/// The command for a shell, after commands that write each camera that is not built in to a file of its own.
fn with_files(line: &CommandLine, cameras: &[Camera]) -> Result<String, ReportError> {
    let (mut words, mut files) = (line.words.clone(), String::new());
    let of_files = line.cameras.iter().zip(cameras).filter(|(argument, _)| !argument.is_built_in);
    for (i, (argument, camera)) in of_files.enumerate() {
        let file = format!("again-{}.toml", i + 1);
        let text = toml::to_string(camera.description())?;
        let mut end = "EOF".to_owned();
        while text.lines().any(|line| line == end) {
            end.push('_');
        }
        files += &format!("cat > {file} <<'{end}'\n{text}{end}\n");
        words.iter_mut().filter(|word| **word == argument.word).for_each(|word| word.clone_from(&file));
    }
    Ok(files + &command(&words))
}
