//! The shape of the workspace. Crates and the library's rooms import in one direction, no files import from each other
//! in a circle, and the library opens no file, prints nothing and has no clock.
//!
//! A file imports from the file that declares an item, whatever path leads there: `pub use` only hands a name on. A
//! `mod.rs` may therefore re-export its children, and they may use each other's items through it; the declaration
//! `mod child;` is no import. An item that `mod.rs` declares itself and a child uses is one.
#![allow(clippy::unwrap_used, clippy::panic)]

mod graph;
mod sources;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use graph::{Target, circles, describe};
use sources::{Modules, module_path};

/// The crates in layers. A crate may depend on crates of earlier layers only.
const LAYERS: [&[&str]; 5] = [
    &["smalti"],
    &["smalti-io", "smalti-report"],
    &["smalti-wasm"],
    &["smalti-serve"],
    &["smalti-cli", "smalti-py"],
];

/// The direction of light. Each room of the library may import from those before it, and from itself.
const ROOMS: [&str; 14] = [
    "names",
    "numeric",
    "spectrum",
    "color",
    "scene",
    "optics",
    "sensor",
    "isp",
    "l3",
    "metrics",
    "camera",
    "design",
    "rating",
    "experiment",
];

/// What the library must not touch: files, the environment, other processes, clocks, threads of its own.
const FORBIDDEN_PATHS: [&str; 9] = [
    "std::fs",
    "std::env",
    "std::net",
    "std::process",
    "std::thread",
    "std::io::stdin",
    "std::io::stdout",
    "std::io::stderr",
    "std::time",
];
const FORBIDDEN_MACROS: [&str; 5] = ["print", "println", "eprint", "eprintln", "dbg"];

/// Dependencies within a layer, which must be optional: the Python package offers the command and works without it.
const SIDEWAYS: [(&str, &str); 1] = [("smalti-py", "smalti-cli")];

/// Crates with `unsafe` code, where every block states its reason. All other crates forbid it.
const UNSAFE_CRATES: [&str; 4] = ["smalti", "smalti-io", "smalti-py", "smalti-wasm"];

// ---- the workspace ---------------------------------------------------------------------------------------------

#[test]
fn unsafe_code_is_where_it_is_known_to_be() {
    for (name, folder) in crates() {
        let root = std::fs::read_to_string(folder.join("src/lib.rs")).unwrap();
        let forbids = root.lines().any(|line| line == "#![forbid(unsafe_code)]");
        assert_ne!(forbids, UNSAFE_CRATES.contains(&name.as_str()), "{name}");
        let has_main = folder.join("src/main.rs");
        if let Ok(main) = std::fs::read_to_string(has_main) {
            assert!(main.lines().any(|line| line == "#![forbid(unsafe_code)]"), "{name}: main.rs");
        }
    }
    // An unsafe block without its reason is no warning but an error of the lint.
    let workspace = crates().values().next().unwrap().join("../../Cargo.toml");
    let manifest: toml::Table = toml::from_str(&std::fs::read_to_string(workspace).unwrap()).unwrap();
    let lint = &manifest["workspace"]["lints"]["clippy"]["undocumented_unsafe_blocks"];
    assert_eq!(lint.as_str(), Some("deny"));
}

#[test]
fn crates_depend_in_one_direction() {
    let complaints: Vec<String> = crates()
        .iter()
        .flat_map(|(name, folder)| {
            let layer = |n: &str| LAYERS.iter().position(|l| l.contains(&n));
            let own = layer(name).unwrap_or_else(|| panic!("the crate {name} has no layer in this test"));
            let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
            let manifest: toml::Table = toml::from_str(&manifest).unwrap();
            let optional =
                |d: &str| manifest["dependencies"].get(d).is_some_and(|d| d.get("optional").is_some());
            let sideways = |d: &&String| SIDEWAYS.contains(&(name.as_str(), d.as_str())) && optional(d);
            dependencies(&manifest)
                .into_iter()
                .filter(|d| layer(d).is_some_and(|l| l >= own) && !sideways(&d))
                .collect::<Vec<_>>()
                .into_iter()
                .map(move |d| format!("{name} depends on {d}, which is not in an earlier layer"))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn no_files_import_from_each_other_in_a_circle() {
    let mut complaints = Vec::new();
    for (name, folder) in crates() {
        for root in ["lib.rs", "main.rs"] {
            let src = folder.join("src");
            if !src.join(root).is_file() {
                continue;
            }
            let imports = Modules::read(&src, root).imports();
            for circle in circles(&imports) {
                complaints.push(format!("{name}, {} files:\n{}", circle.len(), describe(&imports, &circle)));
            }
        }
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n\n"));
}

/// Every crate of the workspace with its folder.
fn crates() -> BTreeMap<String, PathBuf> {
    let all = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let folders = std::fs::read_dir(all).unwrap().map(|e| e.unwrap().path());
    let named = folders.filter(|f| f.join("Cargo.toml").is_file());
    let crates: BTreeMap<String, PathBuf> =
        named.map(|f| (f.file_name().unwrap().to_string_lossy().into_owned(), f)).collect();
    assert!(crates.len() >= 5, "crates under {}: {crates:?}", all.display());
    crates
}

/// The names in every table of dependencies, those for one platform included; those for tests are left out.
fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (key, value) in manifest {
        let Some(table) = value.as_table() else { continue };
        match key.as_str() {
            "dependencies" | "build-dependencies" => names.extend(table.keys().cloned()),
            "target" => names.extend(table.values().filter_map(toml::Value::as_table).flat_map(dependencies)),
            _ => {}
        }
    }
    names
}

// ---- the library -----------------------------------------------------------------------------------------------

#[test]
fn rooms_follow_the_light_and_stay_pure() {
    let library = Modules::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "lib.rs");
    assert!(library.by_path.len() > 100, "modules read: {}", library.by_path.len());
    let missing: Vec<&String> =
        library.by_path.keys().filter_map(|p| p.first()).filter(|r| !ROOMS.contains(&r.as_str())).collect();
    assert!(missing.is_empty(), "rooms without a place in the order of this test: {missing:?}");
    let complaints = complaints(&library);
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// What is wrong in a library's code: imports against the light, files, printing.
fn complaints(library: &Modules) -> Vec<String> {
    let rank = |path: &[String]| path.first().and_then(|room| ROOMS.iter().position(|r| r == room));
    let mut found = BTreeSet::new();
    for (file, names, target) in library.targets() {
        let written = names.join("::");
        let own = rank(&module_path(file));
        let place = format!("src/{}: {written}", file.display());
        match target {
            Target::Item(there) | Target::Module(there) if own.is_some() => {
                if there.is_empty() {
                    found.insert(format!("{place} imports from the root of the crate"));
                } else if rank(&there) > own {
                    found.insert(format!("{place} comes later in the order {}", ROOMS.join(" → ")));
                }
            }
            Target::External(path) => {
                let path = path.join("::");
                let within = |f: &str| path == f || path.strip_prefix(f).is_some_and(|r| r.starts_with("::"));
                if FORBIDDEN_PATHS.iter().any(|f| within(f)) || path == "std" {
                    found.insert(format!("{place} touches {path}"));
                }
            }
            _ => {}
        }
    }
    for module in library.by_path.values() {
        for macro_call in module.mentions.iter().filter(|n| n.last().is_some_and(|l| l == "!")) {
            let name = &macro_call[macro_call.len() - 2];
            if FORBIDDEN_MACROS.contains(&name.as_str()) {
                found.insert(format!("src/{}: prints ({name}!)", module.file.display()));
            }
        }
    }
    found.into_iter().collect()
}

// ---- that the checker sees what it should ----------------------------------------------------------------------

/// A small library with the file `file` of this text in it.
fn library(file: &str, text: &str) -> Modules {
    let mut library = Modules::default();
    for (file, text) in [
        ("lib.rs", "pub mod isp; pub use isp::Pipeline;"),
        ("numeric.rs", "pub struct Planes;"),
        ("optics.rs", "pub struct OpticalImage;"),
        ("sensor/mod.rs", "mod adc; pub use adc::Adc;"),
        ("sensor/adc.rs", "pub struct Adc;"),
        ("isp.rs", "pub struct Pipeline; pub fn run() {}"),
        ("camera.rs", "pub struct Camera;"),
        (file, text),
    ] {
        library.add_text(file, text);
    }
    library
}

#[test]
fn imports_against_the_light_are_seen() {
    for text in [
        "use crate::isp;",
        "use crate::isp::Pipeline;",
        "pub use crate::{numeric::Planes, isp::{self, Pipeline}};",
        "use crate::{numeric::Planes, camera as m};",
        "fn f() -> crate::camera::Camera { todo() }",
        "fn f(x: Vec<crate::camera::Camera>) {}",
        "use super::super::isp::Pipeline;",
        "use super::super::{numeric::Planes, isp::Pipeline};",
        "use self::super::super::isp::Pipeline;",
        "mod inner { use super::super::super::isp; }",
        "use crate::Pipeline;",
        "use crate::*; fn f(p: Pipeline) {}",
        "fn f() { crate::isp::run() }",
        "fn f() { let text = format!(\"{}\", crate::isp::run()); }",
        "macro_rules! m { () => { $crate::isp::run() } }",
    ] {
        assert!(!complaints(&library("sensor/pixel.rs", text)).is_empty(), "not seen: {text}");
    }
    assert_eq!(complaints(&library("optics.rs", "use super::isp;")).len(), 1);
    assert_eq!(
        complaints(&library("numeric.rs", "use crate::optics::OpticalImage; use crate::camera;")).len(),
        2
    );
}

#[test]
fn imports_with_the_light_pass() {
    for text in [
        "use crate::{numeric::Planes, optics::OpticalImage};",
        "use super::Adc;",
        "use super::super::optics::OpticalImage;",
        "#[cfg(test)] mod tests { use super::*; use crate::isp; }",
        "/// See [`crate::camera`].\nfn f() { let text = \"crate::isp\"; }",
        "pub(crate) fn isp() {} pub(in crate::sensor) fn f() {}",
        "fn f(x: X) { x.camera(); let isp = 1; g(isp) }",
    ] {
        assert_eq!(complaints(&library("sensor/pixel.rs", text)), Vec::<String>::new(), "{text}");
    }
}

#[test]
fn files_clocks_and_printing_are_seen() {
    for text in [
        "use std::fs;",
        "use std::{collections::HashMap, fs::File};",
        "use std as s; fn f() { s::fs::read(path) }",
        "fn f() { std::fs::read(path) }",
        "fn f() { std::env::var(name) }",
        "fn f() { println!(\"text\") }",
        "fn f() { let x = vec![dbg!(x)]; }",
        "fn f() { std::io::stdout().lock() }",
        "use std::time::Instant;",
        "fn f() { std::thread::spawn(g) }",
    ] {
        assert!(!complaints(&library("optics.rs", text)).is_empty(), "not seen: {text}");
    }
    let pure = "use std::fmt; fn f() { write!(f, \"println!\"); let print = 1; env!(\"X\") }";
    assert_eq!(complaints(&library("optics.rs", pure)), Vec::<String>::new());
}

#[test]
fn circles_of_files_are_seen_through_re_exports() {
    let circles_with = |parent: &str, child: &str, sibling: &str| {
        let mut crate_ = Modules::default();
        for (file, text) in
            [("lib.rs", "pub mod a;"), ("a/mod.rs", parent), ("a/b.rs", child), ("a/c.rs", sibling)]
        {
            crate_.add_text(file, text);
        }
        circles(&crate_.imports())
    };
    let face = "mod b; mod c; pub use b::B; pub use c::C;";
    // Siblings that use each other's items through their parent's face.
    assert_eq!(circles_with(face, "use super::C; pub struct B(C);", "pub struct C;").len(), 0);
    let found = circles_with(face, "use super::C; pub struct B(C);", "pub struct C(crate::a::B);");
    assert_eq!(found, [BTreeSet::from(["a/b.rs".into(), "a/c.rs".into()])]);
    // A parent with items of its own, which a child uses and which use the child.
    let parent = "mod b; mod c; pub struct A(b::B);";
    assert_eq!(circles_with(parent, "pub struct B;", "use super::A;").len(), 0);
    assert_eq!(circles_with(parent, "use super::*; pub struct B(A);", "").len(), 1);
    assert_eq!(circles_with(parent, "use super::c::C; pub struct B;", "pub struct C(super::A);").len(), 1);
}
