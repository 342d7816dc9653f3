//! Tab completion: the shell calls the program, which completes built-in names as well as files.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::{Arg, Command};
use clap_complete::engine::{ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter};
use clap_complete::env::{CompleteEnv, EnvCompleter, Shells};
use smalti::scene::catalog::{self, ParamInfo};
use smalti::sensor::cfa;
use smalti::spectrum::Illuminant;
use smalti_io::{cameras, designs, ratings, scenes, studies};

use crate::keys::keys;
use crate::resolve::has_extension;

/// The environment variable by which the script of a shell requests completions.
const VARIABLE: &str = "SMALTI_COMPLETE";
/// Extensions of scene files.
const SCENES: &[&str] = &smalti_io::scene_file::EXTENSIONS;

/// Completes for a shell, if one requests it.
pub(crate) fn answer(command: fn() -> Command, args: &[OsString]) -> bool {
    let shell = CompleteEnv::with_factory(move || with_names(command())).var(VARIABLE);
    match shell.try_complete(args.iter().cloned(), std::env::current_dir().ok().as_deref()) {
        Ok(answered) => answered,
        Err(e) => {
            let _ = e.print();
            true
        }
    }
}

/// The script that sets up a shell.
pub(crate) fn script(shell: clap_complete::Shell) -> anyhow::Result<String> {
    let shells = Shells::builtins();
    let name = shell.to_string();
    let Some(shell) = shells.completer(&name) else {
        anyhow::bail!("completion is not available for the shell {name}")
    };
    let mut script = Vec::new();
    EnvCompleter::write_registration(shell, VARIABLE, "smalti", "smalti", "smalti", &mut script)?;
    Ok(String::from_utf8(script)?)
}

/// Adds completers to all arguments by their names, in all commands.
fn with_names(command: Command) -> Command {
    let command = command.mut_args(|arg| match arg.get_id().as_str() {
        "camera" | "cameras" => arg.add(ArgValueCompleter::new(CameraOrFile)),
        "cfa" => with(arg, mosaic_names, &["toml"]),
        "target" => with(arg, target_names, &["toml"]),
        "scene" | "scenes" => {
            let or_file = NameOrFile { names: scene_names, extensions: SCENES.to_vec() };
            arg.add(ArgValueCompleter::new(SceneOrFile(or_file)))
        }
        "overrides" => arg.add(ArgValueCompleter::new(camera_keys)),
        "illuminant" | "illuminants" | "target_illuminant" => with(arg, light_names, &["csv"]),
        "study" => with(arg, study_names, &["toml"]),
        "start" => with(arg, || camera_names().into_iter().chain(study_names()).collect(), &["toml"]),
        "design" => with(arg, design_names, &["toml"]),
        "experiment" => with(arg, experiment_names, &["toml"]),
        // The argument of `show`, which accepts every kind.
        "name" => with(arg, all_names, &[&["toml", "csv"], SCENES].concat()),
        _ => arg,
    });
    command.mut_subcommands(with_names)
}

/// Completes an argument with names and files.
fn with(arg: Arg, names: fn() -> Vec<CompletionCandidate>, extensions: &[&'static str]) -> Arg {
    arg.add(ArgValueCompleter::new(NameOrFile { names, extensions: extensions.to_vec() }))
}

struct NameOrFile {
    names: fn() -> Vec<CompletionCandidate>,
    extensions: Vec<&'static str>,
}

impl ValueCompleter for NameOrFile {
    fn complete(&self, current: &OsStr) -> Vec<CompletionCandidate> {
        let typed = current.to_string_lossy();
        let begins = |c: &CompletionCandidate| c.get_value().to_string_lossy().starts_with(typed.as_ref());
        let extensions = self.extensions.clone();
        let fits = move |path: &Path| path.is_file() && has_extension(path, &extensions);
        let files = PathCompleter::any().filter(fits).complete(current);
        (self.names)().into_iter().filter(begins).chain(files).collect()
    }
}

/// Completes cameras, and mosaics after the `@` of a camera.
struct CameraOrFile;

impl ValueCompleter for CameraOrFile {
    fn complete(&self, current: &OsStr) -> Vec<CompletionCandidate> {
        let typed = current.to_string_lossy();
        let Some((camera, begun)) = typed.split_once('@') else {
            return NameOrFile { names: camera_names, extensions: vec!["toml"] }.complete(current);
        };
        let mosaics = cfa::names().iter().filter(|c| c.name.starts_with(begun));
        mosaics.map(|c| named(&format!("{camera}@{}", c.name), c.summary)).collect()
    }
}

/// Completes scenes, and parameters after the name of a scene.
struct SceneOrFile(NameOrFile);

impl ValueCompleter for SceneOrFile {
    fn complete(&self, current: &OsStr) -> Vec<CompletionCandidate> {
        // Some shells pass a word with the quotes that `?` and `&` need.
        let typed: String =
            current.to_string_lossy().chars().filter(|c| !['\'', '"', '\\'].contains(c)).collect();
        match typed.split_once('?') {
            Some((name, typed)) => scene_parameters(name, typed),
            None => self.0.complete(current),
        }
    }
}

/// The parameters of a scene that are not typed yet.
fn scene_parameters(name: &str, typed: &str) -> Vec<CompletionCandidate> {
    let Some(scene) = catalog::names().iter().find(|s| s.name == name) else { return Vec::new() };
    let (before, begun) = typed.rsplit_once('&').map_or(("", typed), |(b, t)| (&typed[..=b.len()], t));
    let has = |p: &ParamInfo| before.split('&').any(|given| given.split('=').next() == Some(p.name));
    let all = scene.parameters.iter().chain(catalog::common_parameters());
    let fits = all.filter(|p| p.name.starts_with(begun) && !has(p));
    fits.map(|p| named(&format!("{name}?{before}{}=", p.name), p.doc)).collect()
}

/// Keys of a camera, for `--set KEY=VALUE`.
fn camera_keys(current: &OsStr) -> Vec<CompletionCandidate> {
    let typed = current.to_string_lossy();
    let keys = keys(&cameras::schema());
    let fits = keys.iter().filter(|key| key.name.starts_with(typed.as_ref()));
    fits.map(|key| named(&format!("{}=", key.name), &key.summary)).collect()
}

fn named(name: &str, what: &str) -> CompletionCandidate {
    CompletionCandidate::new(name).help(Some(what.to_owned().into()))
}

fn camera_names() -> Vec<CompletionCandidate> {
    cameras::names().iter().map(|f| named(f.name, f.summary)).collect()
}

fn mosaic_names() -> Vec<CompletionCandidate> {
    cfa::names().iter().map(|c| named(c.name, c.summary)).collect()
}

fn target_names() -> Vec<CompletionCandidate> {
    std::iter::once(named("xyz", "CIE 1931 X, Y, Z")).chain(camera_names()).collect()
}

fn study_names() -> Vec<CompletionCandidate> {
    studies::names().iter().map(|f| named(f.name, f.summary)).collect()
}

fn design_names() -> Vec<CompletionCandidate> {
    designs::names().iter().map(|f| named(f.name, f.summary)).collect()
}

fn experiment_names() -> Vec<CompletionCandidate> {
    ratings::names().iter().map(|f| named(f.name, f.summary)).collect()
}

fn scene_names() -> Vec<CompletionCandidate> {
    scenes::names().map(|(name, summary)| named(name, summary)).collect()
}

fn light_names() -> Vec<CompletionCandidate> {
    Illuminant::names().iter().map(|name| named(name, "illuminant")).collect()
}

/// Every name once; a name of several kinds has the help of the first.
fn all_names() -> Vec<CompletionCandidate> {
    let filters = cfa::builtin_filters().iter().map(|f| named(f.name, f.summary));
    let mut all: Vec<CompletionCandidate> = camera_names();
    for candidate in mosaic_names()
        .into_iter()
        .chain(scene_names())
        .chain(study_names())
        .chain(light_names())
        .chain(filters)
    {
        if !all.iter().any(|c| c.get_value() == candidate.get_value()) {
            all.push(candidate);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// Every argument that a name of something built in can stand for.
    #[test]
    fn arguments_with_names_are_completed() {
        let command = with_names(crate::cli::Cli::command());
        let mut found = Vec::new();
        let mut open: Vec<(String, &Command)> =
            command.get_subcommands().map(|s| (s.get_name().to_owned(), s)).collect();
        while let Some((name, sub)) = open.pop() {
            for arg in sub.get_arguments().filter(|a| a.get::<ArgValueCompleter>().is_some()) {
                found.push(format!("{name} {}", arg.get_id()));
            }
            open.extend(sub.get_subcommands().map(|s| (format!("{name} {}", s.get_name()), s)));
        }
        for expected in [
            "compare cameras",
            "compare scenes",
            "compare illuminant",
            "train camera",
            "train scenes",
            "train target",
            "train target_illuminant",
            "train illuminants",
            "simulate camera",
            "simulate scene",
            "simulate illuminant",
            "evaluate cameras",
            "evaluate illuminant",
            "sweep study",
            "studio start",
            "convert scene",
            "show name",
            "show illuminant",
            "simulate cfa",
            "compare cfa",
            "simulate overrides",
            "compare overrides",
            "rate init cameras",
            "rate init scenes",
            "rate init experiment",
        ] {
            assert!(found.iter().any(|f| f == expected), "{expected}: {found:?}");
        }
    }

    #[test]
    fn a_name_is_offered_once() {
        let all = all_names();
        let mut values: Vec<_> = all.iter().map(|c| c.get_value()).collect();
        values.sort_unstable();
        values.dedup();
        assert_eq!(values.len(), all.len());
    }

    fn values(of: &[CompletionCandidate]) -> Vec<String> {
        of.iter().map(|c| c.get_value().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn parameters_of_scenes_are_completed_one_after_another() {
        let of = SceneOrFile(NameOrFile { names: scene_names, extensions: SCENES.to_vec() });
        let offered = |typed: &str| values(&of.complete(OsStr::new(typed)));
        for typed in ["zone-plate?freq", "'zone-plate?freq", "\"zone-plate?freq", "zone-plate\\?freq"] {
            assert_eq!(offered(typed), ["zone-plate?frequency="]);
        }
        let second = offered("zone-plate?frequency=0.3&");
        assert!(second.iter().all(|v| v.starts_with("zone-plate?frequency=0.3&") && v.ends_with('=')));
        assert!(!second.is_empty() && !second.iter().any(|v| v.ends_with("&frequency=")));
        assert!(offered("no-such-scene?").is_empty());
        assert!(offered("zone-p").contains(&"zone-plate".to_owned()));
    }

    #[test]
    fn mosaics_are_completed_after_a_camera() {
        let offered = |typed: &str| values(&CameraOrFile.complete(OsStr::new(typed)));
        assert_eq!(offered("phone@quad"), ["phone@quad-bayer"]);
        assert_eq!(offered("own.toml@rgbw-so"), ["own.toml@rgbw-sony"]);
        assert_eq!(offered("bayer@").len(), cfa::names().len());
        assert!(offered("medic").contains(&"medical".to_owned()));
    }

    #[test]
    fn keys_of_cameras_are_completed() {
        assert_eq!(values(&camera_keys(OsStr::new("sensor.pixel.pit"))), ["sensor.pixel.pitch_um="]);
    }
}
