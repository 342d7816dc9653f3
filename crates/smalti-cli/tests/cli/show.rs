//! `smalti show`: what is drawn, in characters and in pictures, and what it says as JSON and TOML.

use base64::Engine;

use crate::Place;

/// As seen by a terminal of all colours, 80 wide.
fn colored(place: &Place, words: &str) -> String {
    let mut command = place.command();
    command.args(words.split(' ')).env("COLORTERM", "truecolor").env("COLUMNS", "80");
    let run = crate::Run::of(&mut command);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "smalti {words}");
    run.out
}

#[test]
fn piped_it_is_plain() {
    let place = Place::new();
    for name in
        ["rgbw", "quad-bayer", "condat2011", "random", "macbeth", "table2", "LED", "silicon", "nikon-d5100/R"]
    {
        let mut command = place.command();
        command.args(["show", name]).env("COLORTERM", "truecolor").env("TERM", "xterm-kitty");
        let run = crate::Run::of(&mut command);
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{name}");
        let control = |c: char| c.is_control() && c != '\n';
        assert!(!run.out.contains(control) && run.out.lines().count() > 10, "{name}:\n{}", run.out);
    }
    // What is asked for holds, whatever the terminal.
    let mut command = place.command();
    let run = crate::Run::of(command.args(["show", "rgbw", "--color", "always"]).env("NO_COLOR", "1"));
    assert!(run.out.contains("\x1b["));
}

#[test]
fn a_mosaic_has_its_tile_shares_and_spectra() {
    let place = Place::new();
    let text = place.ok("show xtrans");
    for line in ["GBGGRG", "6 × 6", "red", "0.5 ┤", "400", "700 nm", "transmittance"] {
        let squeezed = text.replace(' ', "");
        let found =
            text.to_lowercase().contains(&line.to_lowercase()) || squeezed.contains(&line.replace(' ', ""));
        assert!(found, "{line}:\n{text}");
    }
    let json = place.document("show xtrans --json");
    assert_eq!((json["kind"].as_str(), json["rows"].as_u64()), (Some("cfa"), Some(6)));
    let channels = json["channels"].as_array().unwrap();
    // X-Trans: 20 green, 8 red and 8 blue of 36.
    let cells = |letter: &str| channels.iter().find(|c| c["letter"] == letter).unwrap()["cells"].as_u64();
    assert_eq!((cells("G"), cells("R"), cells("B")), (Some(20), Some(8), Some(8)));
    let nm = json["wavelengths_nm"].as_array().unwrap().len();
    assert!(channels.iter().all(|c| c["transmittance"].as_array().unwrap().len() == nm));
    // A mosaic that sees infrared is drawn as far as that.
    assert!(place.ok("show rgbir").contains("1000"));
    assert!(place.ok("show xtrans --wavelengths 300:10:500").contains("300"));
}

/// The colours of text on a colour, in order.
fn grounds(text: &str) -> Vec<[u8; 3]> {
    let codes =
        text.split("\x1b[").filter_map(|s| s.split_once('m')).filter_map(|(c, _)| c.split_once("48;2;"));
    let color = |c: &str| {
        let v: Vec<u8> = c.split(';').map(|v| v.parse().unwrap()).collect();
        [v[0], v[1], v[2]]
    };
    codes.map(|(_, c)| color(c)).collect()
}

#[test]
fn cells_have_the_colours_of_their_filters() {
    let place = Place::new();
    let text = colored(&place, "show bayer --as cfa --graphics blocks");
    let json = place.document("show bayer --as cfa --json");
    let channels = json["channels"].as_array().unwrap();
    let color = |letter: char| {
        let hex =
            channels.iter().find(|c| c["letter"] == letter.to_string()).unwrap()["color"].as_str().unwrap();
        [1, 3, 5].map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap())
    };
    let ([r, g, b], shown) = (['R', 'G', 'B'].map(color), grounds(&text));
    // The red filter looks red, the green one green, the blue one blue.
    assert!(r[0] > 200 && r[0] > 2 * r[2] && g[1] > 200 && g[1] > 2 * g[0] && b[2] > 200 && b[2] > 2 * b[0]);
    let first = json["pattern"][0].as_str().unwrap().chars().map(color);
    assert_eq!(shown[..2], first.collect::<Vec<_>>(), "{text}");
    assert!([r, g, b].iter().all(|c| shown.contains(c)));
    // Curves are dots of Braille, each in its colour.
    assert!(text.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c)), "{text}");
    assert!(text.lines().all(|l| l.matches("\x1b[38").count() == l.matches("\x1b[0m").count()), "{text}");
    // With 256 colours, no code of more.
    let mut command = place.command();
    command.args(["show", "bayer", "--graphics", "blocks"]).env("TERM", "xterm-256color");
    let run = crate::Run::of(
        ["COLORTERM", "KITTY_WINDOW_ID", "TERM_PROGRAM", "WT_SESSION"]
            .iter()
            .fold(&mut command, |c, v| c.env_remove(v)),
    );
    assert!(run.out.contains(";48;5;") && !run.out.contains("8;2;"), "{}", run.out);
}

#[test]
fn a_scene_is_a_picture_in_half_blocks() {
    let place = Place::new();
    let text = colored(&place, "show macbeth?patch=8 --graphics blocks");
    let rows: Vec<&str> = text.lines().filter(|l| l.contains('▀')).collect();
    // 48 × 32 pixels, two rows in each line.
    assert_eq!((rows.len(), rows[0].matches('▀').count()), (16, 48), "{text}");
    // The row of greys: white is white, black is dark, and no patch has a tint.
    let greys = grounds(rows[15]);
    assert_eq!(greys.len(), 6, "{greys:?}");
    assert!(greys[0].iter().all(|&v| v > 235) && greys[5].iter().all(|&v| v < 75), "{greys:?}");
    assert!(greys.iter().all(|c| c.iter().max().unwrap() - c.iter().min().unwrap() < 16), "{greys:?}");
    // Blue, green, red stand third, one above the greys.
    let [blue, green, red] = grounds(rows[9])[..3] else { panic!("{text}") };
    assert!(blue[2] > blue[0] && green[1] > green[0] && red[0] > 2 * red[1], "{blue:?} {green:?} {red:?}");
    for words in
        ["size         48 × 32 pixels", "mean 100 cd/m²", "D65", "1.2 m", "400–700 nm in 30 steps of 10 nm"]
    {
        assert!(text.contains(words), "{words}:\n{text}");
    }
    let dim = place.document("show macbeth?patch=8 --luminance 5 --illuminant A --distance 3 --json");
    assert!((dim["mean_luminance_cd_m2"].as_f64().unwrap() - 5.0).abs() < 1e-4, "{dim}");
    assert_eq!((dim["illuminant"].as_str(), dim["distance_m"].as_f64()), (Some("A"), Some(3.0)));
    assert!((dim["illuminant_temperature_k"].as_f64().unwrap() - 2856.0).abs() < 15.0, "{dim}");
}

/// The pictures of kitty commands, put together again.
fn kitty(text: &str) -> Vec<(u32, u32)> {
    let (mut sizes, mut payload) = (Vec::new(), String::new());
    for command in text.split("\x1b_G").skip(1) {
        let (control, rest) = command.split_once(';').unwrap();
        let chunk = rest.split_once("\x1b\\").unwrap().0;
        assert!(chunk.len() <= 4096 && (payload.is_empty() == control.contains("a=T,f=100,c=")), "{control}");
        payload += chunk;
        if control.ends_with("m=0") {
            let png = base64::engine::general_purpose::STANDARD.decode(&payload).unwrap();
            let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
            sizes.push(reader.info().size());
            payload.clear();
        }
    }
    assert!(payload.is_empty());
    sizes
}

/// The pixels of a sixel picture: as many as it says, each painted.
fn sixel(text: &str) -> (usize, Vec<Option<[u8; 3]>>) {
    let body = text.split_once("q\"1;1;").unwrap().1.split_once("\x1b\\").unwrap().0;
    let (width, rest) = body.split_once(';').unwrap();
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap();
    let (width, height): (usize, usize) = (width.parse().unwrap(), rest[..end].parse().unwrap());
    let mut pixels = vec![None; width * height];
    let mut palette = std::collections::BTreeMap::new();
    let (mut x, mut y, mut color) = (0, 0, [0; 3]);
    let mut chars = rest[end..].chars().peekable();
    while let Some(c) = chars.next() {
        let mut number = || {
            let mut n = 0;
            while let Some(d) = chars.peek().and_then(|c| c.to_digit(10)) {
                n = 10 * n + d as usize;
                chars.next();
            }
            n
        };
        match c {
            '#' => {
                let index = number();
                if chars.next_if_eq(&';').is_some() {
                    let mut next = || {
                        let digits: String =
                            std::iter::from_fn(|| chars.next_if(char::is_ascii_digit)).collect();
                        chars.next_if_eq(&';');
                        digits.parse::<f64>().unwrap()
                    };
                    assert_eq!(next(), 2.0);
                    palette.insert(index, [next(), next(), next()].map(|v| (v * 2.55).round() as u8));
                } else {
                    color = palette[&index];
                }
            }
            '$' => x = 0,
            '-' => (x, y) = (0, y + 6),
            c => {
                let (count, bits) = if c == '!' {
                    let n = number();
                    (n, chars.next().unwrap() as usize - 63)
                } else {
                    (1, c as usize - 63)
                };
                for _ in 0..count {
                    (0..6)
                        .filter(|b| bits >> b & 1 == 1)
                        .for_each(|b| pixels[(y + b) * width + x] = Some(color));
                    x += 1;
                }
            }
        }
    }
    assert!(palette.len() <= 256);
    (width, pixels)
}

#[test]
fn pictures_for_terminals_that_show_them_decode() {
    let place = Place::new();
    // A mosaic and its spectra; a scene, pixel for pixel.
    assert_eq!(kitty(&colored(&place, "show rgbw --as cfa --graphics kitty")).len(), 2);
    assert_eq!(kitty(&colored(&place, "show macbeth?patch=8 --graphics kitty")), [(48, 32)]);
    let large = kitty(&colored(&place, "show uniform?size=2500 --wavelengths 450:100:650 --graphics kitty"));
    assert!(large[0].0 <= 960 && large[0].0 == large[0].1, "{large:?}");

    let (width, pixels) = sixel(&colored(&place, "show macbeth?patch=8 --graphics sixel"));
    assert_eq!((width, pixels.len()), (48, 48 * 32));
    let blocks = colored(&place, "show macbeth?patch=8 --graphics blocks");
    let rows: Vec<&str> = blocks.lines().filter(|l| l.contains('▀')).collect();
    for (patch, expected) in grounds(rows[15]).into_iter().enumerate() {
        let own = pixels[31 * 48 + 8 * patch + 3].unwrap();
        let far = own.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        assert!(far <= 3, "{patch}: {own:?} {expected:?}");
    }
    assert!(pixels.iter().all(Option::is_some));
    let tile = sixel(&colored(&place, "show rgbw --as cfa --graphics sixel"));
    assert!(tile.1.iter().all(Option::is_some));
}

#[test]
fn a_camera_is_its_description_and_its_file() {
    let place = Place::new();
    let text = place.ok("show phone");
    for words in
        ["[sensor.pixel]", "pitch_um", "µm", "e⁻", "Nyquist frequency", "500 ", "cy/mm", "quantum efficiency"]
    {
        assert!(text.contains(words), "{words}:\n{text}");
    }
    // The file can be copied as a start; an own one is shown, with what was set.
    for camera in ["bayer", "rgbw", "phone", "table1"] {
        place.write("own.toml", place.ok(&format!("show {camera} --toml")));
        let [own, built_in] =
            ["show own.toml --json".to_owned(), format!("show {camera} --as camera --json")]
                .map(|words| place.document(&words)["description"].clone());
        assert_eq!(own, built_in, "{camera}");
    }
    let json = place.document("show own.toml --set sensor.pixel.pitch_um=2.5 --json");
    assert_eq!(json["description"]["sensor"]["pixel"]["pitch_um"], 2.5);
    let nyquist =
        json["derived"].as_array().unwrap().iter().find(|d| d["name"] == "Nyquist frequency").unwrap();
    assert!((nyquist["value"].as_f64().unwrap() - 200.0).abs() < 1e-9);
    // The sensitivity is that of the filter times what stands before it.
    let (filter, sensitivity) =
        (&json["cfa"]["channels"][0]["transmittance"], &json["channels"][0]["effective_sensitivity"]);
    let pairs = crate::numbers(filter).into_iter().zip(crate::numbers(sensitivity));
    assert!(pairs.clone().all(|(f, s)| s <= f + 1e-12) && pairs.count() == 31);
    // The keys of a mosaic, too, make a camera.
    for mosaic in ["rgbw", "xtrans", "condat2011", "random"] {
        place.write("mosaic.toml", place.ok(&format!("show {mosaic} --as cfa --toml")));
        // A camera without infrared cut: for white pixels a note tells it.
        let run = place.run(&["show", "mosaic.toml"]);
        assert!(run.code == 0 && run.out.contains("a camera"), "{mosaic}: {}", run.err);
        assert_eq!(run.err.contains("clear channel W"), mosaic == "rgbw", "{}", run.err);
    }
    assert!(place.ok("show table2 --toml").contains("[filters.gaussian_grid]"));
}

#[test]
fn a_name_of_several_things_and_of_none() {
    let place = Place::new();
    let text = place.ok("show bayer");
    assert!(text.starts_with("bayer: a camera") && text.contains("also a CFA (--as cfa)"), "{text}");
    assert_eq!(place.document("show bayer --json")["also"][0], "cfa");
    assert!(place.ok("show bayer --as cfa").starts_with("bayer: a colour filter array"));
    place.write("curve.csv", "400,0.1\n550,1\n700,0.2\n");
    assert!(place.ok("show curve.csv").contains("peak 1.00 at 550 nm"));
    place.ok("convert macbeth?patch=4 -o photo.png");
    assert!(place.ok("show photo.png").contains("24 × 16 pixels"));
}

#[test]
fn what_cannot_be_shown_says_why() {
    let place = Place::new();
    place.write("broken.toml", "[sensor\n");
    place.write("no.png", "not a picture");
    for (words, expected) in [
        ("show bayr", &["'bayr'", "bayer (camera, cfa)", "smalti list"][..]),
        ("show macbet", &["macbeth (scene)"]),
        ("show qqqqqqq", &["neither built in nor a file", "smalti list"]),
        ("show macbeth --as cfa", &["macbeth"]),
        ("show rgbw --as scene", &["rgbw"]),
        ("show macbeth?pach=3", &["patch"]),
        ("show no.toml", &["no.toml"]),
        ("show broken.toml", &["broken.toml"]),
        ("show no.png", &["no.png"]),
        ("show absent.csv", &["absent.csv"]),
        ("show rgbw --luminance 3", &["--luminance does not apply to a camera"]),
        ("show macbeth --set isp.output=srgb", &["--set does not apply to a scene"]),
        ("show macbeth --toml", &["a scene has no TOML"]),
        ("show bayer --set sensor.pixel.pitch_um=0", &["pitch_um"]),
        ("show bayer --toml --set isp.output=srgb", &["--json"]),
        ("show quad-bayer --wavelengths 3:2:1", &["--wavelengths 3:2:1"]),
    ] {
        let run = place.run(&words.split(' ').collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{words}: {}", run.err);
        assert!(
            run.err.starts_with("error: ") && expected.iter().all(|e| run.err.contains(e)),
            "{words}: {}",
            run.err
        );
    }
}

/// A quantity that a file states in electrons is not shown with the default in volts that it replaces.
#[test]
fn a_quantity_in_electrons_stands_once() {
    let place = Place::new();
    place.write("own.toml", "[sensor]\ndsnu_e = 1.5\n[sensor.pixel]\nread_noise_e = 3.0\n");
    let text = place.ok("show own.toml");
    assert!(text.contains("read_noise_e") && text.contains("dsnu_e"), "{text}");
    assert!(!text.contains("read_noise_mv") && !text.contains("dsnu_mv"), "{text}");
    assert!(text.contains("dark_voltage_v_per_s"), "{text}");
}
