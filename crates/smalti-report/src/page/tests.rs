use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::markup::json as json_text;
use super::*;
use crate::Plot;

/// The text of an element, found by what stands before and behind it.
fn between<'a>(html: &'a str, before: &str, behind: &str) -> &'a str {
    let from = html.find(before).unwrap() + before.len();
    let length = html[from..].find(behind).unwrap();
    &html[from..from + length]
}

#[test]
fn hashes_are_those_of_what_stands_in_the_page() {
    // The empty text: FIPS 180-4 as everyone publishes it.
    assert_eq!(shell::source(""), "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='");
    let html = Page::new("x").with(SWEEP).data("d", json!({"a": "</script>"})).html();
    let policy =
        between(&html, "http-equiv=\"Content-Security-Policy\" content=\"", "\"").replace("&#39;", "'");
    for (open, close, directive) in
        [("<style>", "</style>", "style-src"), ("<script>", "</script>", "script-src")]
    {
        let source = shell::source(between(&html, open, close));
        assert!(policy.contains(&format!("{directive} {source};")), "{policy}");
    }
    assert!(
        policy.starts_with("default-src 'none';") && !policy.contains("unsafe") && !policy.contains("http")
    );
    assert_eq!(html.matches("<script>").count(), 1, "one program");
    assert_eq!(html.matches("<style>").count(), 1, "one sheet of styles");
}

#[test]
fn pieces_end_no_element_and_load_nothing() {
    for piece in std::iter::once(&SHELL).chain(SWEEP) {
        assert!(!piece.js.to_ascii_lowercase().contains("</script") && !piece.js.contains("<!--"));
        assert!(!piece.css.to_ascii_lowercase().contains("</style") && !piece.css.contains("url("));
        for word in [
            "innerHTML",
            "outerHTML",
            "insertAdjacentHTML",
            "document.write",
            "eval(",
            "fetch(",
            "XMLHttp",
            "WebSocket",
        ] {
            assert!(!piece.js.contains(word), "{word}");
        }
        // A name of XML, and where uPlot says it comes from.
        let known = |at: usize| {
            ["http://www.w3.org/2000/svg\"", "https://github.com/leeoniya/uPlot ("]
                .iter()
                .any(|name| piece.js[at..].starts_with(name))
        };
        let named: Vec<usize> =
            piece.js.match_indices("http").map(|(at, _)| at).filter(|at| !known(*at)).collect();
        assert_eq!(named, [0; 0], "{}", piece.js.len());
    }
}

#[test]
fn uplot_comes_with_its_licence_in_one_version() {
    let version = between(UPLOT.js, "github.com/leeoniya/uPlot (v", ")");
    assert!(UPLOT.credit.contains(&format!("uPlot {version}, ")), "{version}");
    assert!(include_str!("../../vendor/uplot/README.md").contains(&format!("uPlot {version} by ")));
    let html = Page::new("x").with(SWEEP).html();
    assert!(html.contains("The MIT License (MIT)") && html.contains("Copyright (c) 2022 Leon Sorokin"));
    assert!(html.contains(&format!("<footer><p>{}</p></footer>", UPLOT.credit)));
    assert!(!Page::new("x").with(COMPARE).html().contains("uPlot"));
}

#[test]
fn figures_stand_without_styles_of_their_own() {
    let figure = Plot::new("x", "y").title("<b>").draw().unwrap();
    let html = figure_html(&figure);
    assert!(html.contains("role=\"img\"") && html.contains("<title>&lt;b&gt;</title>"));
    assert!(!html.contains(" style="), "the policy refuses them");
}

fn figure_html(figure: &crate::Figure) -> String {
    super::figure(figure).as_str().to_owned()
}

#[test]
fn tables_have_headings_and_escaped_cells() {
    let table = Table::new("a<b").text("name").number("ΔE").row(["<i>", "1"], true);
    let html = Markup::from(table);
    let html = html.as_str();
    assert!(html.contains("<caption>a&lt;b</caption>"));
    assert!(
        html.contains(
            "<tr class=\"marked\"><th scope=\"row\">&lt;i&gt;</th><td class=\"number\">1</td></tr>"
        ),
        "{html}"
    );
}

#[test]
fn columns_take_the_fewest_bytes() {
    let size = |v: &[f64]| packed(v).to_string().len();
    let few: Vec<f64> = (0..5000).map(|i| f64::from(i % 90) * 2.5).collect();
    let all: Vec<f64> = (0..5000).map(|i| f64::from(i).sqrt()).collect();
    assert!(size(&[7.0; 5000]) < 60);
    assert!((6600..7300).contains(&size(&few)), "a byte each in base64: {}", size(&few));
    assert!((26_000..27_000).contains(&size(&all)), "four bytes each: {}", size(&all));
    assert_eq!(runs(&[3, 4, 5, 9, 1 << 40]), json!([3, 3, 9, 1, 1u64 << 40, 1]));
    assert_eq!(words(["b", "a", "b"].into_iter())["words"], json!(["b", "a"]));
    assert_eq!(packed(&[])["n"], 0);
}

/// What `data.js` does.
pub(crate) fn unpacked(column: &Value) -> Vec<f32> {
    let bytes = |key: &str| column.get(key).map(|t| STANDARD.decode(t.as_str().unwrap()).unwrap());
    let floats =
        |b: Vec<u8>| b.chunks(4).map(|c| f32::from_le_bytes(c.try_into().unwrap())).collect::<Vec<_>>();
    if let Some(all) = bytes("f32") {
        return floats(all);
    }
    let table = floats(bytes("table").unwrap());
    let count = column["n"].as_u64().unwrap() as usize;
    match (bytes("u8"), bytes("u16")) {
        (Some(codes), _) => codes.iter().map(|c| table[usize::from(*c)]).collect(),
        (_, Some(codes)) => {
            codes.chunks(2).map(|c| table[usize::from(u16::from_le_bytes([c[0], c[1]]))]).collect()
        }
        _ => vec![table.first().copied().unwrap_or(0.0); count],
    }
}

/// What `data.js` does.
pub(crate) fn whole(packed: &Value, rows: usize, cols: usize) -> Vec<Vec<i32>> {
    let deflated = STANDARD.decode(packed["deflated"].as_str().unwrap()).unwrap();
    let mut bytes = Vec::new();
    flate2::read::DeflateDecoder::new(&deflated[..]).read_to_end(&mut bytes).unwrap();
    let (count, size) = (packed["count"].as_u64().unwrap() as usize, rows * cols);
    let mut out = vec![vec![0i32; size]; count];
    for (k, picture) in out.iter_mut().enumerate() {
        for i in 0..size {
            let at = k * size + i;
            let high = count * size + 2 * at;
            let code = i32::from(bytes[at]) | i32::from(bytes[high]) << 8 | i32::from(bytes[high + 1]) << 16;
            let (row, col) = (i / cols, i % cols);
            let left = if col > 0 { picture[i - 1] } else { 0 };
            let above = if row > 0 { picture[i - cols] } else { 0 };
            let expected = match (row, col) {
                (0, _) => left,
                (_, 0) => above,
                _ => (left + above - picture[i - cols - 1]).clamp(left.min(above), left.max(above)),
            };
            picture[i] = expected + ((code >> 1) ^ -(code & 1));
        }
    }
    out
}

#[test]
fn smooth_pictures_of_numbers_are_small() {
    let smooth: Vec<i32> = (0..200 * 300).map(|i| (i / 300) * (i % 300) / 7 - 4000).collect();
    let text = whole_pictures([&smooth[..]].into_iter(), 300).to_string();
    assert!(text.len() < 4000, "{} bytes", text.len());
    assert_eq!(whole_pictures(std::iter::empty(), 300)["count"], 0);
}

#[test]
fn pictures_are_whole_and_small() {
    let rgb: Vec<u8> = (0..64 * 48).flat_map(|i| [(i % 64) as u8 * 4, (i / 64) as u8 * 5, 90]).collect();
    let uri = DataUri::jpeg(64, 48, &rgb, 80).unwrap();
    let bytes = STANDARD.decode(uri.as_str().strip_prefix("data:image/jpeg;base64,").unwrap()).unwrap();
    assert!(
        bytes.starts_with(&[0xff, 0xd8]) && bytes.ends_with(&[0xff, 0xd9]) && bytes.len() < rgb.len() / 4
    );
    assert!(matches!(DataUri::jpeg(64, 48, &rgb[1..], 80), Err(crate::FigureError::Picture { .. })));
    assert!(matches!(DataUri::jpeg(0, 0, &[], 80), Err(crate::FigureError::Picture { .. })));
    let wide = vec![0; 3 * 70_000];
    assert!(matches!(DataUri::jpeg(70_000, 1, &wide, 80), Err(crate::FigureError::Size { .. })));
    let exact = DataUri::png(64, 48, &rgb).unwrap();
    let file = STANDARD.decode(exact.as_str().strip_prefix("data:image/png;base64,").unwrap()).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut back = vec![0; rgb.len()];
    reader.next_frame(&mut back).unwrap();
    assert_eq!(back, rgb);
    assert!(matches!(DataUri::png(64, 47, &rgb), Err(crate::FigureError::Picture { .. })));
    assert!(matches!(DataUri::png(70_000, 1, &wide), Err(crate::FigureError::Size { .. })));
    let grey: Vec<u8> = rgb.iter().step_by(3).copied().collect();
    let small = DataUri::grey_jpeg(64, 48, &grey, 80).unwrap();
    assert!(small.as_str().len() < uri.as_str().len());
    assert!(matches!(DataUri::grey_jpeg(64, 48, &rgb, 80), Err(crate::FigureError::Picture { .. })));
    assert!(uri.image(64, 48, "a \"b\"").attr("class", "x").clone() != el("img"));
}

proptest! {
    #[test]
    fn no_text_leaves_its_place(text in any::<String>(), value in any::<String>()) {
        let html = Markup::from(el("p").attr("title", &value).child(&text));
        let inner = html.as_str().strip_prefix("<p title=\"").unwrap().strip_suffix("</p>").unwrap();
        // One quote ends the attribute, one bracket the tag; all others are escaped.
        prop_assert_eq!(inner.matches('"').count(), 1);
        prop_assert_eq!(inner.matches('<').count(), 0);
        prop_assert_eq!(inner.matches('>').count(), 1);
        let steers = |c: char| c.is_control() || ('\u{202A}'..='\u{202E}').contains(&c);
        prop_assert_eq!(inner.chars().find(|c| steers(*c)), None);
    }

    #[test]
    fn no_data_end_their_element(text in any::<String>(), extra in "(</script|<!--|\u{2028}|\\\\|\"|\n|&){0,4}") {
        let value = json!({(text.clone()): [extra, text, 1.5, null, true]});
        let html = json_text(&value);
        let ends = html.find(['<', '\u{2028}', '\u{2029}', '\n']);
        prop_assert_eq!(ends, None);
        let back: Value = serde_json::from_str(&html).unwrap();
        let cleaned = |t: &Value| t.as_str().unwrap().split('\n').map(crate::text::clean).collect::<Vec<_>>().join("\n");
        let (old, new) = (value.as_object().unwrap(), back.as_object().unwrap());
        let (old, new) = (old.values().next().unwrap(), new.values().next().unwrap());
        prop_assert_eq!(cleaned(&old[0]), new[0].as_str().unwrap());
        prop_assert_eq!(cleaned(&old[1]), new[1].as_str().unwrap());
        prop_assert_eq!(&new[2], &json!(1.5));
    }

    #[test]
    fn columns_come_back(values in prop::collection::vec(prop_oneof![Just(f64::NAN), Just(0.0), Just(-0.0), any::<f64>(), (0..400u32).prop_map(f64::from)], 0..700)) {
        let back = unpacked(&packed(&values));
        prop_assert_eq!(back.len(), values.len());
        for (a, b) in values.iter().zip(back) {
            prop_assert!((*a as f32).to_bits() == b.to_bits() || a.is_nan() && b.is_nan());
        }
    }

    #[test]
    fn pictures_of_numbers_come_back(
        cols in 1..9usize,
        values in prop::collection::vec(prop_oneof![Just(i32::MIN), Just(i32::MAX), any::<i16>().prop_map(i32::from), -3..3i32], 0..200),
    ) {
        let rows = values.len() / cols / 2;
        let pictures: Vec<&[i32]> = values.chunks_exact((rows * cols).max(1)).take(2).collect();
        let cut: Vec<Vec<i32>> = pictures.iter().map(|p| p.iter().map(|v| (*v).clamp(-32768, 32767)).collect()).collect();
        let packed = whole_pictures(pictures.into_iter(), cols);
        if rows > 0 {
            prop_assert_eq!(whole(&packed, rows, cols), cut);
        }
    }
}
