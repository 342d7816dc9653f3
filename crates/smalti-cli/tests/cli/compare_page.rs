//! What `tools/page` does not see of the pages of `compare` and `evaluate`.

use crate::Place;
use crate::compare::{LEAVES, ok};

/// A name that would be a script, and one that would end an attribute.
const HOSTILE: &str = "name = '</script><script>alert(1)</script>\" onload=\"x'\n";

fn page(place: &Place, name: &str) -> String {
    let html = String::from_utf8(place.read(name)).unwrap();
    let policy = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src &#39;none&#39;; script-src &#39;sha256-";
    assert!(
        html.contains(policy) || html.contains(&policy.replace("&#39;", "'")),
        "no policy in {}",
        &html[..600]
    );
    // Names of SVG are no addresses.
    let text = html.replace("http://www.w3.org/2000/svg", "");
    for address in ["http:", "https:", "src=\"/", "url(", "@import"] {
        assert!(!text.contains(address), "{address}");
    }
    assert!(!html.contains(" style="), "the policy allows no style in an element");
    html
}

#[test]
fn a_comparison_has_a_small_page_and_names_are_text() {
    let place = Place::new();
    place.write("host.toml", HOSTILE);
    let text = ok(
        &place,
        &format!("compare host.toml bayer --scene {LEAVES} --luminance 5,80 --processing bilinear -o o"),
    );
    assert!(text.contains("see o/report.html"), "{text}");
    let html = page(&place, "o/report.html");
    assert!(html.len() < 600_000, "{}", html.len());
    // The program of the page, and its data: the name is in neither as it is.
    assert_eq!(html.matches("<script").count(), 2);
    assert!(
        html.contains("&lt;script&gt;alert(1)") && !html.contains("<script>alert"),
        "the name is not escaped"
    );
    // Two lights, a reference and two cameras, and two maps of each camera.
    assert_eq!(html.matches("class=\"shot\"").count(), 6);
    assert_eq!(html.matches("class=\"map\"").count(), 8);
    let means = |name: &str| html.matches(name).count();
    assert_eq!(means("ΔE2000 difference: dead-leaves"), means("S-CIELAB difference: dead-leaves"));
    // The best of two is marked in each light and column of means.
    let scores = html
        .split("<caption>Scores: means over one scene and 3 seeds")
        .nth(1)
        .unwrap()
        .split("</table>")
        .next()
        .unwrap();
    assert!(scores.matches("class=\"best\"").count() >= 12, "{scores}");
    assert!(!html.contains("id=\"kernels\""), "nothing was learned");
    assert!(
        html.contains("smalti compare again-1.toml bayer --scene &#39;dead-leaves")
            || html.contains("smalti compare again-1.toml bayer --scene 'dead-leaves")
    );
    assert_eq!(place.json("o/results.json")["files"].as_array().unwrap().last().unwrap(), "report.html");
}

#[test]
fn a_page_shows_what_was_learned_and_is_the_same_again() {
    let place = Place::new();
    let words = format!("compare bayer --scene {LEAVES} --luminance 80 -o o");
    ok(&place, &words);
    let html = page(&place, "o/report.html");
    assert!(html.contains("id=\"kernels\"") && html.contains("pooled over texture"));
    let data = html.split("<script type=\"application/json\" id=\"compare\">").nth(1).unwrap();
    let data: serde_json::Value = serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
    let learned = &data["learned"][0];
    let textures = learned["textures"].as_array().unwrap().len();
    let clipped = learned["clipped"].as_array().unwrap();
    assert!(clipped.len() > 1 && clipped[0]["channels"].as_array().unwrap().is_empty());
    for part in clipped {
        let classes = 4 * part["levels"].as_array().unwrap().len() * textures;
        assert_eq!(part["count"]["n"], classes);
        assert_eq!(part["weight"]["n"], classes * 3 * 25);
    }
    ok(&place, &words);
    assert!(page(&place, "o/report.html") == html, "the page depends on the run");
}

#[test]
fn an_evaluation_has_a_page_whose_cameras_can_be_used() {
    let place = Place::new();
    place.write("host.toml", HOSTILE);
    place.ok("evaluate host.toml --luminance 75 -o o --set sensor.pixel.pitch_um=3");
    let html = page(&place, "o/report.html");
    assert!(html.len() < 600_000, "{}", html.len());
    assert_eq!(html.matches("class=\"shot\"").count(), 3);
    assert!(html.matches("<td class=\"number\">").count() > 24);
    // The description is a camera, and scores the same.
    let copied = |after: &str| {
        let text = html.split(after).nth(1).unwrap().split("<pre tabindex=\"0\">").nth(1).unwrap();
        let text = text.split("</pre>").next().unwrap();
        [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")]
            .iter()
            .fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
    };
    place.write("again.toml", copied("the whole description</summary>"));
    place.ok("evaluate again.toml --luminance 75 -o again");
    let results = place.json("o/results.json");
    assert_eq!(place.json("again/results.json"), results);
    // One command does it all, where the camera's file is not there.
    let command = copied("Reproduction</h2>");
    assert!(command.starts_with("cat > again-1.toml <<'EOF'\n"), "{command}");
    std::fs::remove_file(place.path("host.toml")).unwrap();
    std::fs::remove_dir_all(place.path("o")).unwrap();
    let folder = std::path::Path::new(env!("CARGO_BIN_EXE_smalti")).parent().unwrap();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &command]).env("PATH", path).env("SMALTI_CACHE_DIR", place.path("cache"));
    let run = crate::Run::of(shell.current_dir(place.path("")));
    assert_eq!((run.code, place.json("o/results.json")), (0, results), "{}", run.err);
}
