//! The studio as a folder, and with which design it opens. The page itself is tested in `tools/page/studio.test.mjs`.

use std::sync::OnceLock;

use serde_json::Value;

use crate::{Place, Run};

/// The most bytes of an exported page.
const MOST_BYTES: u64 = 6_000_000;

fn bytes_in(folder: &std::path::Path) -> u64 {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries.map(|e| if e.path().is_dir() { bytes_in(&e.path()) } else { e.metadata().unwrap().len() }).sum()
}

/// Exports a page, with one cache for all tests here: what the page knows of the light behind the lens of the slides takes seconds to gather.
fn export(place: &Place, words: &str) -> Run {
    static CACHE: OnceLock<tempfile::TempDir> = OnceLock::new();
    let exported = |cache: &std::path::Path, place: &Place, words: &str| {
        let mut command = place.command();
        Run::of(command.env("SMALTI_CACHE_DIR", cache).arg("studio").args(words.split_whitespace()))
    };
    let cache = CACHE.get_or_init(|| {
        let cache = tempfile::tempdir().unwrap();
        assert_eq!(exported(cache.path(), &Place::new(), "bayer --export page").code, 0);
        cache
    });
    exported(cache.path(), place, words)
}

#[test]
fn an_exported_page_needs_nothing_but_its_folder() {
    let place = Place::new();
    let run = export(&place, "rgbw --export deep/site -q");
    assert_eq!((run.code, run.out.as_str(), run.err.as_str()), (0, "deep/site/index.html\n", ""));
    assert!(bytes_in(&place.path("deep/site")) <= MOST_BYTES);
    // Nothing temporary stays beside it.
    assert_eq!(place.names("deep"), ["site"]);
    let page = String::from_utf8(place.read("deep/site/index.html")).unwrap();
    assert!(page.contains("http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'"));
    for attribute in ["src=\"", "href=\""] {
        for address in page.split(attribute).skip(1).map(|rest| rest.split('"').next().unwrap()) {
            let is_own = address == "data:," || place.path("deep/site").join(address).is_file();
            assert!(is_own && !address.starts_with('/'), "{address}");
        }
    }
    // The camera with which it opens is complete.
    assert!(place.ok("show deep/site/start.toml --as camera").contains("rgbw"));
    let again = place.run(&["studio", "bayer", "--export", "deep/site"]);
    assert_eq!(again.code, 1);
    assert!(
        again.err.contains("deep/site: the folder is not empty; expected a new or an empty one"),
        "{}",
        again.err
    );
}

#[test]
fn the_largest_page_is_small_and_needs_a_web_server() {
    let place = Place::new();
    // The largest page of a built-in camera, and that of one with crosstalk, whose statistics have a larger patch elsewhere. No browser runs them from a file.
    for camera in ["cmv12000", "phone"] {
        let run = export(&place, &format!("{camera} --export {camera}"));
        assert_eq!(run.code, 0, "{}", run.err);
        let bytes = bytes_in(&place.path(camera));
        assert!(bytes <= MOST_BYTES, "{camera}: {bytes} bytes");
        let serve = format!("`python3 -m http.server --directory {camera}`");
        assert!(run.err.contains(&serve), "{}", run.err);
    }
}

/// Four designs.
const STUDY: &str = r#"
name = "small"
camera = "bayer"
colors = [3]
[sample]
filters = 4
mosaics = 1
[filters.gaussian_grid]
[mosaics.tile]
rows = 2
cols = 2
"#;

#[test]
fn it_opens_with_what_a_sweep_or_a_comparison_wrote() {
    let place = Place::new();
    place.write("study.toml", STUDY);
    assert_eq!(place.run(&["sweep", "study.toml", "-o", "swept", "-q"]).code, 0);
    // The best design, as the report has it.
    let run = export(&place, "swept --export of-swept");
    assert_eq!(run.code, 0, "{}", run.err);
    let report = place.document("report swept --json -q");
    let best = &report["studies"][0]["sections"][0]["colors"][0]["best"][0]["trial"];
    assert!(
        run.err.contains(&format!("note: swept: trial {best}, the best of the fewest colours")),
        "{}",
        run.err
    );
    let name = |text: &str| text.lines().find(|line| line.starts_with("name = ")).unwrap().to_owned();
    let text = |file: &str| String::from_utf8(place.read(file)).unwrap();
    assert_eq!(name(&text("of-swept/start.toml")), name(&place.ok(&format!("report swept --camera {best}"))));
    // The first camera, and the second one pinned.
    let cameras: Vec<serde_json::Value> = ["rgbw", "bayer", "phone"]
        .map(|camera| place.document(&format!("show {camera} --json"))["description"].clone())
        .to_vec();
    std::fs::create_dir(place.path("compared")).unwrap();
    place.write("compared/results.json", serde_json::json!({"cameras": cameras}).to_string());
    let run = export(&place, "compared --export of-compared");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.err.contains("the first two cameras are shown; 1 more can be opened"), "{}", run.err);
    assert_eq!(name(&text("of-compared/start.toml")), "name = \"rgbw\"");
    assert_eq!(name(&text("of-compared/pinned.toml")), "name = \"bayer\"");
    let server = place.json("of-compared/server.json");
    assert_eq!(server["pinned"], "pinned.toml");
    assert_eq!(server["native"], serde_json::Value::Null, "a folder has no server");
}

#[test]
fn it_opens_with_a_camera_a_study_or_what_was_designed() {
    let place = Place::new();
    std::fs::create_dir(place.path("best")).unwrap();
    let own = place.ok("show bayer@quad-bayer --toml");
    place.write("best/camera.toml", own.replace("name = \"bayer@quad-bayer\"", "name = \"found\""));
    // The family of the search comes with its design.
    place.write("best/results.json", r#"{"name": "found", "family": {"pigments": {"max_pigments": 2}}}"#);
    for (start, name, family) in [
        ("best", "found", serde_json::json!("pigments")),
        ("theory", "theory-0", Value::Null),
        ("bayer@xtrans", "bayer@xtrans", Value::Null),
    ] {
        let run = export(&place, &format!("{start} --export of-{name} -q"));
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{start}");
        assert_eq!(place.json(&format!("of-{name}/server.json"))["family"], family);
        let text = String::from_utf8(place.read(&format!("of-{name}/start.toml"))).unwrap();
        assert!(text.lines().any(|line| line == format!("name = \"{name}\"")), "{start}: {text}");
    }
    std::fs::create_dir(place.path("empty")).unwrap();
    std::fs::create_dir(place.path("compared")).unwrap();
    place.write("compared/results.json", "{\"cameras\": 3}");
    place.write("wrong.toml", "name = \"wrong\"\n[sensor]\nrows = \"many\"\n");
    for (words, expected) in [
        (
            &["empty"][..],
            "empty: the folder has no camera.toml, manifest.json or results.json; expected one that `smalti design`, `sweep` or `compare` wrote",
        ),
        (&["xtrans"], "xtrans is a CFA; expected a camera, a study or a folder"),
        (&["compared"], "compared/results.json: no cameras of a comparison"),
        (&["bayr"], "did you mean bayer"),
        (&["wrong.toml"], "wrong.toml:3"),
    ] {
        let run = place.run(&[&["studio"], words, &["--export", "no"]].concat());
        assert_eq!(run.code, 1, "{words:?}");
        assert!(run.err.contains(expected), "{words:?}: {}", run.err);
        assert!(!place.path("no").exists());
    }
    let both = place.run(&["studio", "--export", "no", "--port", "8080"]);
    assert_eq!(both.code, 2);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let run = place.run(&["studio", "--no-open", "--port", &port]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains(&format!("port {port} of 127.0.0.1 cannot be opened")), "{}", run.err);
}

/// Other accounts can read the command line of a browser: it has the path of a private file, which leads to the page, and not the token.
#[cfg(target_os = "linux")]
#[test]
fn a_browser_is_led_to_the_page_by_a_private_file() {
    use std::fs::{self, Permissions};
    use std::io::{BufRead as _, BufReader};
    use std::os::unix::fs::PermissionsExt as _;
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let place = Place::new();
    fs::create_dir(place.path("bin")).unwrap();
    place.write(
        "bin/xdg-open",
        "#!/bin/sh\nprintf '%s' \"$*\" > \"$CALLED.new\"\nmv \"$CALLED.new\" \"$CALLED\"\n",
    );
    fs::set_permissions(place.path("bin/xdg-open"), Permissions::from_mode(0o755)).unwrap();
    fs::create_dir(place.path("tmp")).unwrap();
    let path = format!("{}:{}", place.path("bin").display(), std::env::var("PATH").unwrap());
    let mut child = place
        .command()
        .args(["studio", "bayer", "-q"])
        .env("PATH", path)
        .env("TMPDIR", place.path("tmp"))
        .env("CALLED", place.path("called"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut address = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let begun = Instant::now();
    while !place.path("called").exists() && begun.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let called = fs::read_to_string(place.path("called")).unwrap_or_default();
    let (text, about) = (fs::read_to_string(&called), fs::metadata(&called));
    child.kill().unwrap();
    child.wait().unwrap();
    let address = address.trim();
    let token = address.trim_end_matches('/').rsplit('/').next().unwrap();
    assert_eq!(token.len(), 32, "{address}");
    assert!(called.starts_with(place.path("tmp").to_str().unwrap()) && !called.contains(token), "{called}");
    assert!(text.unwrap().contains(&format!("url={address}\"")));
    assert_eq!(about.unwrap().permissions().mode() & 0o777, 0o600);
}
