//! The pages for readers are true to the tree: relative links resolve, and every path that ARCHITECTURE.md names exists.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

/// ARCHITECTURE.md writes paths from the root of the repository, from `crates/` or from the source folder of the library.
const BASES: [&str; 3] = ["", "crates", "crates/smalti/src"];
const QUESTIONS_HEADING: &str = "## Questions of a newcomer";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn relative_links_resolve() {
    let mut pages = Vec::new();
    files(&root(), ".md", &mut pages);
    assert!(pages.len() > 30, "only {} pages found", pages.len());
    let mut checked = 0;
    let mut broken = Vec::new();
    for page in &pages {
        for link in relative_links(&fs::read_to_string(page).unwrap()) {
            checked += 1;
            if let Err(why) = resolve(page, &link) {
                broken.push(format!("{}: {link}: {why}", page.display()));
            }
        }
    }
    assert!(checked > 100, "only {checked} links found");
    assert!(broken.is_empty(), "\n{}", broken.join("\n"));
}

#[test]
fn every_path_of_the_architecture_exists() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let paths = paths(&text);
    assert!(paths.len() > 40, "only {} paths found", paths.len());
    let missing: Vec<String> = paths.iter().filter_map(|path| missing(path)).collect();
    assert!(missing.is_empty(), "\n{}", missing.join("\n"));
}

#[test]
fn the_architecture_answers_ten_questions_with_paths() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let questions = questions(&text);
    assert!(questions.len() >= 10, "only {} questions", questions.len());
    for (question, answer) in questions {
        assert!(question.ends_with('?'), "{question}");
        assert!(!paths(&answer).is_empty(), "{question} is answered without a path: {answer}");
    }
}

#[test]
fn every_test_that_a_page_names_exists() {
    let mut sources = Vec::new();
    files(&root().join("crates"), ".rs", &mut sources);
    let words: Vec<String> =
        sources.iter().flat_map(|path| functions(&fs::read_to_string(path).unwrap())).collect();
    for (page, least) in [("docs/validation.md", 60), ("docs/reliability.md", 20)] {
        let named = tests_named(&fs::read_to_string(root().join(page)).unwrap());
        assert!(named.len() > least, "only {} tests found in {page}", named.len());
        let missing: Vec<_> = named.iter().filter(|name| !words.contains(name)).collect();
        assert!(missing.is_empty(), "{page} names tests that do not exist: {missing:?}");
    }
}

#[test]
fn wrong_links_paths_and_items_are_found() {
    let page = root().join("README.md");
    assert!(resolve(&page, "docs/nowhere.md").is_err());
    assert!(resolve(&page, "docs/index.md#nowhere").is_err());
    assert!(resolve(&page, "CONTRIBUTING.md#before-you-send-a-change").is_ok());
    assert_eq!(relative_links("[a](b.md), ![c](d.png) [e](https://x.y/z) `[f](g.md)`"), ["b.md", "d.png"]);
    assert_eq!(relative_links("```\n[a](b.md)\n```\n\n    [c](d.md)\n"), [""; 0]);
    assert_eq!(
        paths("`numeric/philox.rs`, `cargo test a/b`, `scene/`, `smalti::scene`, `photons/s`"),
        ["numeric/philox.rs", "scene/"]
    );
    assert_eq!(
        tests_named("`smalti-io: cubes::spy_reads_our_envi`, `design::PixelLight`, `lib::optics`"),
        ["spy_reads_our_envi"]
    );
    assert!(missing("numeric/nowhere.rs").is_some());
    assert!(missing("numeric/philox.rs::nowhere").is_some());
    assert!(missing("smalti/tests/it/documentation.rs::missing").is_none());
}

/// Files below a folder with an ending, without those that are built or downloaded.
fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            if !name.starts_with('.') && !["target", "node_modules", "out", "corpus"].contains(&name) {
                files(&path, ending, found);
            }
        } else if name.ends_with(ending) {
            found.push(path);
        }
    }
}

/// The lines of a page that are prose: outside code blocks, fenced or indented, and with code spans taken out.
fn prose(text: &str) -> Vec<String> {
    let mut fenced = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced && !line.starts_with("    ") {
            lines.push(line.split('`').step_by(2).collect());
        }
    }
    lines
}

fn relative_links(text: &str) -> Vec<String> {
    let outside = |link: &&str| !link.contains("://") && !link.starts_with("mailto:");
    let of_line = |line: &String| -> Vec<String> {
        let targets =
            line.split("](").skip(1).filter_map(|part| part.split_once(')')).map(|(target, _)| target);
        targets.filter(outside).map(str::to_owned).collect()
    };
    prose(text).iter().flat_map(of_line).collect()
}

fn resolve(page: &Path, link: &str) -> Result<(), &'static str> {
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = if file.is_empty() { page.to_owned() } else { page.parent().unwrap().join(file) };
    if !target.exists() {
        return Err("there is no such file");
    }
    let anchors =
        |text: String| text.lines().filter(|l| l.starts_with('#')).map(anchor_of).collect::<Vec<_>>();
    if anchor.is_empty() || anchors(fs::read_to_string(&target).unwrap()).iter().any(|a| a == anchor) {
        Ok(())
    } else {
        Err("the page has no such heading")
    }
}

/// The anchor that GitHub and mdBook give to a heading.
fn anchor_of(heading: &str) -> String {
    let title = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Code spans that are paths: a folder with its slash, or a file with one of the extensions of this repository.
fn paths(text: &str) -> Vec<String> {
    const EXTENSIONS: [&str; 8] = [".rs", ".md", ".toml", ".mjs", ".js", ".py", ".bib", "justfile"];
    let is_path = |span: &&str| {
        let file = span.split("::").next().unwrap();
        !span.contains(' ') && (file.ends_with('/') || EXTENSIONS.iter().any(|e| file.ends_with(e)))
    };
    let spans = text.split("```").step_by(2).flat_map(|part| part.split('`').skip(1).step_by(2));
    spans.filter(is_path).map(str::to_owned).collect()
}

/// What is wrong with a path, or with `file.rs::item`.
fn missing(path: &str) -> Option<String> {
    let (file, item) = path.split_once("::").unwrap_or((path, ""));
    let Some(found) = BASES.iter().map(|base| root().join(base).join(file)).find(|p| p.exists()) else {
        return Some(format!("`{file}` does not exist"));
    };
    if item.is_empty() {
        return None;
    }
    let text = fs::read_to_string(found).unwrap();
    let words: Vec<&str> =
        text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).collect();
    let defines = ["fn", "struct", "enum", "trait", "const", "static", "type", "mod"];
    let defined = words.windows(2).any(|w| defines.contains(&w[0]) && w[1] == item);
    (!defined).then(|| format!("`{file}` defines no `{item}`"))
}

fn functions(text: &str) -> Vec<String> {
    let heads = text.split("fn ").skip(1).filter_map(|part| part.split(['(', '<']).next());
    heads.map(str::to_owned).collect()
}

/// The last name of each code span that is a path to a test: `file::test`, with a name of three words or more.
fn tests_named(text: &str) -> Vec<String> {
    let is_name = |name: &&str| {
        name.matches('_').count() >= 2
            && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    let spans = text.split('`').skip(1).step_by(2).filter(|span| span.contains("::"));
    spans.filter_map(|span| span.rsplit("::").next()).filter(is_name).map(str::to_owned).collect()
}

/// Questions in bold at the beginning of a list item, each with the text up to the next.
fn questions(text: &str) -> Vec<(String, String)> {
    let section = text.split(QUESTIONS_HEADING).nth(1).unwrap_or("").split("\n## ").next().unwrap();
    let items = section.split("\n- **").skip(1).filter_map(|item| item.split_once("**"));
    items.map(|(question, answer)| (question.to_owned(), answer.to_owned())).collect()
}
