//! The shape of the library: modules import only from those before them in the direction of light, and nothing opens
//! a file, prints or reads the environment.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};

/// The direction of light. Each module may import from those before it, and from itself.
const ORDER: [&str; 12] = [
    "names", "numeric", "spectrum", "color", "scene", "optics", "sensor", "isp", "l3", "metrics", "camera",
    "design",
];

/// What the library must not touch. A path is forbidden when it begins with one of these, at whole names.
const FORBIDDEN_PATHS: [&[&str]; 10] = [
    &["std", "fs"],
    &["std", "env"],
    &["std", "net"],
    &["std", "process"],
    &["std", "io", "stdin"],
    &["std", "io", "stdout"],
    &["std", "io", "stderr"],
    &["File"],
    &["OpenOptions"],
    &["fs"],
];
const FORBIDDEN_MACROS: [&str; 5] = ["print", "println", "eprint", "eprintln", "dbg"];

#[test]
fn modules_follow_the_light_and_stay_pure() {
    let src = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = sources(&src);
    assert!(files.len() > 10, "no sources under {}", src.display());
    let complaints: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let text = std::fs::read_to_string(file).unwrap();
            let relative = file.strip_prefix(&src).unwrap();
            check(&module_path(relative), &text)
                .into_iter()
                .map(move |(line, what)| format!("src/{}:{line}: {what}", relative.display()))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn every_module_of_the_crate_has_its_place() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let tokens = tokens(&text);
    let modules: Vec<&str> = tokens
        .windows(3)
        .filter(|w| w[0].text == "mod" && w[2].text == ";")
        .map(|w| w[1].text.as_str())
        .collect();
    assert!(modules.contains(&"sensor"), "lib.rs declares {modules:?}");
    for module in modules {
        assert!(ORDER.contains(&module), "module `{module}` of lib.rs is missing in the order of this test");
    }
}

// ---- the checker, on text -------------------------------------------------------------------------------------

/// What is wrong in a file of the module `module`, by line.
fn check(module: &[String], text: &str) -> Vec<(usize, String)> {
    let Some(own) = module.first() else { return Vec::new() };
    let rank = |name: &str| ORDER.iter().position(|m| *m == name);
    let mut found = Vec::new();
    for (line, path, within) in paths(&tokens(text), module) {
        let names: Vec<&str> = path.iter().map(String::as_str).collect();
        if let Some(target) = target(&names, &within) {
            match (rank(own), rank(&target)) {
                _ if matches!(target.as_str(), "*" | "self") => {
                    found.push((line, "imports the crate's root".to_owned()))
                }
                (Some(here), Some(there)) if there > here => found.push((
                    line,
                    format!(
                        "`{own}` imports from `{target}` ({}), which comes after it: {}",
                        path.join("::"),
                        ORDER.join(" → ")
                    ),
                )),
                (None, _) => found.push((line, format!("module `{own}` has no place in the order"))),
                _ => {}
            }
        }
        if names.last() == Some(&"!") && FORBIDDEN_MACROS.contains(&names[0]) {
            found.push((line, format!("prints ({}!)", names[0])));
        }
        if FORBIDDEN_PATHS.iter().any(|f| names.len() >= f.len().max(2) && names.starts_with(f)) {
            found.push((line, format!("touches files or the environment ({})", path.join("::"))));
        }
    }
    found
}

/// The top-level module that a path leads to, when it goes through the crate's root.
fn target(path: &[&str], within: &[String]) -> Option<String> {
    let rest = match path {
        ["crate" | "smalti", rest @ ..] => rest,
        ["self", rest @ ..] | rest => {
            let ups = rest.iter().take_while(|p| **p == "super").count();
            if ups == 0 || ups < within.len() {
                return None;
            }
            &rest[ups..]
        }
    };
    rest.first().map(|p| (*p).to_owned())
}

#[derive(Debug, Clone)]
struct Token {
    line: usize,
    text: String,
}

/// Every path in the code, `use` groups written out one by one and a macro's `!` as its last name, with the module it
/// stands in (inline modules included).
fn paths(tokens: &[Token], module: &[String]) -> Vec<(usize, Vec<String>, Vec<String>)> {
    let mut found = Vec::new();
    let mut within = module.to_vec();
    let mut braces = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let text = tokens[i].text.as_str();
        let next = |n: usize| tokens.get(i + n).map_or("", |t| t.text.as_str());
        match text {
            "mod" if next(2) == "{" => {
                within.push(next(1).to_owned());
                braces.push(true);
                i += 3;
                continue;
            }
            "{" => braces.push(false),
            "}" if braces.pop() == Some(true) => {
                within.pop();
            }
            _ if is_name(text) && (i == 0 || !matches!(tokens[i - 1].text.as_str(), "::" | ".")) => {
                let mut all = Vec::new();
                i = tree(tokens, i, &mut Vec::new(), &mut all);
                found.extend(all.into_iter().map(|(line, path)| (line, path, within.clone())));
                continue;
            }
            _ => {}
        }
        i += 1;
    }
    found
}

/// Reads a path, or a tree of paths in braces, from token `i`; returns the token after it.
fn tree(
    tokens: &[Token],
    mut i: usize,
    prefix: &mut Vec<String>,
    out: &mut Vec<(usize, Vec<String>)>,
) -> usize {
    let text = |i: usize| tokens.get(i).map_or("", |t| t.text.as_str());
    let line = tokens.get(i).map_or(0, |t| t.line);
    let depth = prefix.len();
    loop {
        if is_name(text(i)) || text(i) == "*" {
            prefix.push(text(i).to_owned());
            i += 1;
        } else if text(i) == "{" {
            i += 1;
            while i < tokens.len() && text(i) != "}" {
                let before = i;
                i = tree(tokens, i, prefix, out);
                // `as name` and commas between the branches.
                while i < tokens.len() && !matches!(text(i), "," | "}") {
                    i += 1;
                }
                i += usize::from(text(i) == ",");
                if i == before {
                    break;
                }
            }
            prefix.truncate(depth);
            return i + 1;
        } else {
            break;
        }
        if text(i) == "::" && (is_name(text(i + 1)) || matches!(text(i + 1), "{" | "*")) {
            i += 1;
        } else {
            break;
        }
    }
    if text(i) == "!" && text(i + 1) != "=" {
        prefix.push("!".to_owned());
    }
    if prefix.len() > depth {
        out.push((line, prefix.clone()));
    }
    prefix.truncate(depth);
    i.max(1)
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The code as names and signs, without comments, strings, characters and lifetimes.
fn tokens(text: &str) -> Vec<Token> {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let mut out = Vec::new();
    let (mut i, mut line) = (0, 1);
    // Past a quoted text that begins at the quote `i`.
    let quoted = |mut i: usize, line: &mut usize| {
        i += 1;
        while i < c.len() && at(i) != '"' {
            *line += usize::from(at(i) == '\n');
            if at(i) == '\\' {
                i += 1;
                *line += usize::from(at(i) == '\n');
            }
            i += 1;
        }
        i + 1
    };
    while i < c.len() {
        match at(i) {
            '\n' => {
                line += 1;
                i += 1;
            }
            '/' if at(i + 1) == '/' => {
                while i < c.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (at(i), at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        (x, _) => {
                            line += usize::from(x == '\n');
                            i += 1;
                        }
                    }
                    if depth == 0 || i >= c.len() {
                        break;
                    }
                }
            }
            '"' => i = quoted(i, &mut line),
            // 'a' is a character, 'a a lifetime.
            '\'' if at(i + 1) == '\\' => {
                i += 3;
                while i < c.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            '\'' if at(i + 2) == '\'' => i += 3,
            '\'' => {
                i += 1;
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
            }
            x if x.is_alphanumeric() || x == '_' => {
                let start = i;
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
                let name: String = c[start..i].iter().collect();
                let raw = matches!(name.as_str(), "r" | "br" | "cr");
                let hashes = (i..c.len()).take_while(|&j| at(j) == '#').count();
                if raw && at(i + hashes) == '"' {
                    let end: Vec<char> =
                        std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
                    i += hashes + 1;
                    while i < c.len() && !c[i..].starts_with(&end) {
                        line += usize::from(at(i) == '\n');
                        i += 1;
                    }
                    i += end.len();
                } else if !(matches!(name.as_str(), "b" | "c") && at(i) == '"') {
                    out.push(Token { line, text: name });
                }
            }
            ':' if at(i + 1) == ':' => {
                out.push(Token { line, text: "::".into() });
                i += 2;
            }
            x => {
                if !x.is_whitespace() {
                    out.push(Token { line, text: x.into() });
                }
                i += 1;
            }
        }
    }
    out
}

/// Modules of a source file: `sensor/cfa/mod.rs` is sensor, cfa; `lib.rs` is none.
fn module_path(relative: &Path) -> Vec<String> {
    let names = relative.with_extension("");
    let all = names.iter().map(|n| n.to_string_lossy().into_owned());
    all.filter(|n| n != "mod" && n != "lib").collect()
}

fn sources(dir: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    let of = |p: PathBuf| if p.is_dir() { sources(&p) } else { vec![p] };
    entries.into_iter().flat_map(of).filter(|p| p.extension().is_some_and(|e| e == "rs")).collect()
}

// ---- that the checker sees what it should ----------------------------------------------------------------------

fn in_file(path: &str, text: &str) -> usize {
    check(&module_path(Path::new(path)), text).len()
}

#[test]
fn imports_against_the_light_are_seen() {
    for text in [
        "use crate::isp;",
        "use crate::isp::Pipeline;",
        "pub use crate::{numeric::Planes, isp::{self, Pipeline}};",
        "use crate::{\n    numeric::Planes,\n    metrics as m,\n};",
        "fn f() -> crate::camera::Camera { todo() }",
        "fn f(x: Vec<crate::l3::Table>) {}",
        "use super::super::design::Study;",
        "use super::super::{numeric::Planes, design::Study};",
        "use self::super::super::design::Study;",
        "mod tests { use super::super::super::isp; }",
        "mod a { mod b {} } use super::super::isp;",
        "use smalti::isp::Pipeline;",
        "use crate::*;",
        "use crate::{self as root};",
        "let x = b\"text\"; let y = 'a'; crate::isp::run()",
        "let s = r#\"quote \" inside\"#; crate::isp::run()",
        "macro_rules! m { () => { $crate::isp::run() } }",
    ] {
        assert!(in_file("sensor/pixel.rs", text) > 0, "not seen: {text}");
    }
    assert_eq!(in_file("sensor/mod.rs", "use super::isp;"), 1);
    assert_eq!(in_file("sensor/cfa/mod.rs", "use super::super::isp;"), 1);
    assert_eq!(in_file("numeric/a.rs", "use crate::spectrum::Spectrum; use crate::color::Image;"), 2);
}

#[test]
fn imports_with_the_light_pass() {
    for text in [
        "use crate::{numeric::Planes, spectrum::{Spectrum, WavelengthGrid}};",
        "use crate::sensor::Mosaic;",
        "use super::isp::Thing;",
        "use super::super::optics::OpticalImage;",
        "mod tests { use super::*; use super::super::isp; }",
        "// use crate::isp;",
        "//! [`crate::isp`]\n/// See [`crate::camera`].\nfn f() {}",
        "/* use crate::isp; /* nested */ crate::camera */",
        "let s = \"crate::isp \\\" crate::camera\";",
        "let s = r\"crate::isp\";",
        "pub(crate) fn isp() {} pub(in crate::sensor) fn f() {}",
        "fn f<'a>(metrics: &'a str) { let c = '\"'; let d = '\\''; design(metrics) }",
        "use other::crate_like::isp;",
        "x.super_::isp()",
    ] {
        assert_eq!(check(&module_path(Path::new("sensor/pixel.rs")), text), vec![], "{text}");
    }
    assert_eq!(in_file("lib.rs", "pub use crate::design::Study;"), 0);
}

#[test]
fn files_and_printing_are_seen() {
    for text in [
        "use std::fs;",
        "use std::{collections::HashMap, fs::File};",
        "std::fs::read(path)",
        "fs::read(path)",
        "File::open(path)",
        "std::env::var(name)",
        "println!(\"text\")",
        "eprintln!()",
        "dbg!(x)",
        "std::io::stdout().lock()",
    ] {
        assert!(in_file("optics/psf.rs", text) > 0, "not seen: {text}");
    }
    for text in [
        "write!(f, \"println!\")",
        "use std::fmt;",
        "let fs = 1; fs != 2",
        "env!(\"X\")",
        "let print = 1; print",
    ] {
        assert_eq!(check(&module_path(Path::new("optics/psf.rs")), text), vec![], "{text}");
    }
}
