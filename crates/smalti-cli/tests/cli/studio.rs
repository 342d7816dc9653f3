//! The studio as a folder, and with which design it opens. The page itself is tested in `tools/page/studio.test.mjs`.

use crate::Place;

/// The most bytes of an exported page.
const MOST_BYTES: u64 = 6_000_000;

fn bytes_in(folder: &std::path::Path) -> u64 {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries.map(|e| if e.path().is_dir() { bytes_in(&e.path()) } else { e.metadata().unwrap().len() }).sum()
}

#[test]
fn an_exported_page_needs_nothing_but_its_folder() {
    let place = Place::new();
    let out = place.ok("studio rgbw --export deep/site -q");
    assert_eq!(out, "deep/site/index.html\n");
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
fn it_opens_with_a_camera_a_study_or_what_was_designed() {
    let place = Place::new();
    std::fs::create_dir(place.path("best")).unwrap();
    let own = place.ok("show bayer@quad-bayer --toml");
    place.write("best/camera.toml", own.replace("name = \"bayer@quad-bayer\"", "name = \"found\""));
    for (start, name) in [("best", "found"), ("theory", "theory-0"), ("bayer@xtrans", "bayer@xtrans")] {
        place.ok(&format!("studio {start} --export of-{name} -q"));
        let text = String::from_utf8(place.read(&format!("of-{name}/start.toml"))).unwrap();
        assert!(text.lines().any(|line| line == format!("name = \"{name}\"")), "{start}: {text}");
    }
    std::fs::create_dir(place.path("empty")).unwrap();
    place.write("wrong.toml", "name = \"wrong\"\n[sensor]\nrows = \"many\"\n");
    for (words, expected) in [
        (
            &["empty"][..],
            "empty: the folder has no camera.toml; expected one that `smalti design -o empty` wrote",
        ),
        (&["xtrans"], "xtrans is a CFA; expected a camera, a study or a folder"),
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
