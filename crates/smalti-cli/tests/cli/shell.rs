//! What a shell makes of the program: completion, manual pages, no control codes where nobody looks.

use std::process::Command;

use crate::{Place, Run};

/// What is offered for the last of some words, as a shell asks.
fn offered(place: &Place, words: &[&str]) -> Vec<String> {
    let mut command = place.command();
    command.env("SMALTI_COMPLETE", "bash").env("_CLAP_IFS", "\n").env("_CLAP_COMPLETE_TYPE", "9");
    command.env("_CLAP_COMPLETE_INDEX", words.len().to_string()).args(["--", "smalti"]).args(words);
    let run = Run::of(&mut command);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{words:?}");
    run.out.lines().map(str::to_owned).collect()
}

#[test]
fn names_are_offered_beside_files() {
    let place = Place::new();
    for file in ["mine.toml", "photo.png", "light.csv", "notes.txt"] {
        place.write(file, "");
    }
    std::fs::create_dir(place.path("folder")).unwrap();
    for (words, has, has_not) in [
        (&["compare", ""][..], &["bayer", "rgbw", "mine.toml", "folder/", "--scene"][..], "photo.png"),
        (&["evaluate", "bayer", "r"], &["rgbw", "rgbx"], "bayer"),
        (&["simulate", "bayer", "--scene", ""], &["macbeth", "zone-plate", "photo.png"], "mine.toml"),
        (&["simulate", "--scene", "z"], &["zone-plate"], "macbeth"),
        (&["compare", "bayer", "--illuminant", ""], &["D65", "LED", "light.csv"], "bayer"),
        (&["train", "bayer", "--illuminants", "D65,"], &["D65,A", "D65,LED"], "bayer"),
        (&["train", "bayer", "--target", ""], &["xyz", "rgbw"], "macbeth"),
        (&["sweep", ""], &["table2", "mine.toml"], "bayer"),
        (&["show", ""], &["xtrans", "bayer", "macbeth", "LED", "silicon", "photo.png"], "notes.txt"),
        (&["show", "--graphics", ""], &["kitty", "sixel", "blocks", "text", "auto"], "bayer"),
        (&["sh"], &["show"], "compare"),
        (&[""], &["compare", "show", "sweep"], "man"),
    ] {
        let offered = offered(&place, words);
        let all = has.iter().all(|h| offered.iter().any(|o| o == h));
        assert!(all && offered.iter().all(|o| o != has_not), "{words:?}: {offered:?}");
    }
}

#[test]
fn scripts_ask_the_program() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = place.ok(&format!("completions {shell}"));
        assert!(script.contains("SMALTI_COMPLETE") && script.contains("smalti"), "{shell}:\n{script}");
    }
    let bash = Command::new("bash").arg("--version").output();
    if !bash.is_ok_and(|o| o.status.success()) {
        return eprintln!("skipped: no bash");
    }
    // The key pressed after `smalti compare ba`.
    let script = "source <(smalti completions bash); COMP_WORDS=(smalti compare ba); COMP_CWORD=2; COMP_TYPE=9; \
                  $(complete -p smalti | sed 's/.*-F \\([^ ]*\\) .*/\\1/') smalti ba compare; echo \"${COMPREPLY[@]}\"";
    let folder = std::path::Path::new(env!("CARGO_BIN_EXE_smalti")).parent().unwrap();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
    let output = Command::new("bash")
        .args(["-c", script])
        .env("PATH", path)
        .current_dir(place.path(""))
        .output()
        .unwrap();
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        "bayer\n",
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn every_command_has_a_manual_page() {
    let place = Place::new();
    let told = place.ok("man pages");
    let help = place.ok("--help");
    let commands = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    let names: Vec<&str> =
        commands.filter_map(|l| l.strip_prefix("  ")?.split_once(' ').map(|(n, _)| n)).collect();
    let names: Vec<&str> = names.into_iter().filter(|n| !n.is_empty() && *n != "help").collect();
    assert!(names.len() > 10 && names.contains(&"show") && !names.contains(&"man"), "{names:?}");
    let steps = ["rate-init", "rate-serve", "rate-analyse"];
    let mut pages: Vec<String> = names.iter().chain(&steps).map(|n| format!("smalti-{n}.1")).collect();
    pages.push("smalti.1".into());
    pages.sort();
    assert_eq!(place.names("pages"), pages);
    assert_eq!(told.lines().count(), pages.len());
    for page in &pages {
        let text = String::from_utf8(place.read(&format!("pages/{page}"))).unwrap();
        for section in [".SH NAME", ".SH SYNOPSIS", ".SH DESCRIPTION", ".SH EXAMPLES"] {
            assert!(text.contains(section), "{page} has no {section}");
        }
    }
    lint(&place, &pages);
    // Equal versions give equal pages.
    place.ok("man again");
    pages
        .iter()
        .for_each(|p| assert!(place.read(&format!("pages/{p}")) == place.read(&format!("again/{p}"))));
}

/// The judges of manual pages; nothing is judged where neither is there.
fn lint(place: &Place, pages: &[String]) {
    let judges: [(&str, &[&str]); 2] =
        [("mandoc", &["-T", "lint", "-W", "error"]), ("groff", &["-man", "-Tutf8", "-Kutf8", "-ww", "-z"])];
    let is_there = |name: &str| Command::new(name).arg("--version").output().is_ok();
    let judges: Vec<_> = judges.into_iter().filter(|(name, _)| is_there(name)).collect();
    if judges.is_empty() {
        return eprintln!("skipped: neither mandoc nor groff");
    }
    for (judge, arguments) in judges {
        for page in pages {
            let output =
                Command::new(judge).args(arguments).arg(place.path("pages").join(page)).output().unwrap();
            let said = [output.stdout, output.stderr].concat();
            assert!(
                output.status.success() && said.is_empty(),
                "{judge}: {}",
                String::from_utf8_lossy(&said)
            );
        }
    }
}

/// A full device is a failure, also of help.
#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_a_failure() {
    let place = Place::new();
    for words in ["--help", "--version", "list cfas", "list cfas --json", "show rgbw", "completions bash"] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = place.command().args(words.split(' ')).stdout(full).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{words}: {said}");
        assert_eq!(said.matches("No space left on device").count(), 1, "{words}: {said}");
    }
}

#[test]
fn nothing_but_text_when_piped() {
    let place = Place::new();
    let commands = [
        "list cfas",
        "--help",
        "show rgbw",
        "evaluate bayer --no-cache",
        "convert macbeth?patch=4 -o a.npy",
        "simulate bayer --scene uniform?size=8 --set sensor.rows=30 --set sensor.cols=40 -o a",
    ];
    for words in commands {
        for (name, value) in [("TERM", "xterm-kitty"), ("TERM", "dumb"), ("NO_COLOR", "1"), ("CLICOLOR", "1")]
        {
            let mut command = place.command();
            let run = Run::of(command.args(words.split(' ')).env("COLORTERM", "truecolor").env(name, value));
            assert!(
                !run.out.contains('\x1b') && run.err.is_empty(),
                "{words} with {name}={value}: {}",
                run.err
            );
        }
    }
    // Nor in errors.
    let mut command = place.command();
    let run = Run::of(command.args(["show", "--grafics", "x"]).env("TERM", "xterm-kitty"));
    assert!(run.code == 2 && !run.err.contains('\x1b'), "{}", run.err);
}
