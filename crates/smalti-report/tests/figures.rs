//! Figures are well-formed, contain their labels and are reproducible, and bad input gives an error.
#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use smalti_report::{
    Cell, Corner, Figure, FigureError, Histogram, Line, Mosaics, Panels, Plot, Points, Rgb, Scale, Sheet,
    Symbol,
};

/// All text of a document; fails when it is not well-formed.
fn texts(figure: &Figure) -> Vec<String> {
    let options = roxmltree::ParsingOptions::default();
    let document = roxmltree::Document::parse_with_options(figure.svg(), options).unwrap();
    document
        .descendants()
        .filter_map(|n| n.text().map(|t| t.trim().to_owned()))
        .filter(|t| !t.is_empty())
        .collect()
}

fn holds(figure: &Figure, wanted: &str) -> bool {
    texts(figure).iter().any(|t| t.contains(wanted))
}

/// Values that look random, the same each time.
fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n).map(|_| next()).collect()
}

/// Width, height, and the RGB bytes.
fn decoded(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width, info.height, pixels)
}

fn one_of_each() -> Vec<Figure> {
    let (x, y) = (noise(50, 1), noise(50, 2));
    let plot = Plot::new("MTF50 (cy/mm)", "ΔE*ab")
        .title("Title")
        .note("Note")
        .values("noise (%)")
        .points(Points::new("valued", &x, &y).values(&y))
        .points(
            Points::new("means", &[0.5], &[0.5]).symbol(Symbol::Star).x_intervals(&[(0.2, f64::INFINITY)]),
        )
        .line(Line::new("front", &x[..3], &y[..3]).corner(Corner::YFirst).dashed());
    let panels = Panels::new(2).title("Panels").panel(plot.clone().title("A")).panel(plot.clone().title("B"));
    let spectra = Plot::spectra("Transmittance")
        .line(Line::new("G", &[400.0, 550.0, 700.0], &[0.0, 1.0, 0.0]).filled());
    let histogram = Plot::new("ΔE", "designs").histogram(Histogram::new("h", &x).interval(0.1, 0.5, 0.9));
    let cell = Cell { letter: "G".to_owned(), color: Rgb(0, 158, 115) };
    let mosaic = Mosaics::new().mosaic("mosaic", 1, &[cell.clone(), cell]);
    let sheet = Sheet::new(2).picture("picture", 4, 2, &[9; 24]).picture("other", 1, 1, &[9; 3]).enlarge(10);
    vec![
        plot.draw().unwrap(),
        panels.draw().unwrap(),
        spectra.draw().unwrap(),
        histogram.draw().unwrap(),
        mosaic.draw().unwrap(),
        sheet.draw().unwrap(),
    ]
}

/// The numbers of an attribute of all elements of a name.
fn numbers_of(svg: &str, element: &str, attribute: &str) -> Vec<f64> {
    let of = |tag: &str| tag.split_once(&format!(" {attribute}=\""))?.1.split('"').next()?.parse().ok();
    svg.split(&format!("<{element}")).skip(1).filter(|tag| tag.starts_with(' ')).filter_map(of).collect()
}

#[test]
fn what_lies_beyond_the_axes_is_cut_and_not_moved_to_their_ends() {
    let plot = || Plot::new("x", "y").x_range(0.0, 10.0).y_range(0.0, 10.0);
    let lines = |plot: Plot| {
        let svg = plot.draw().unwrap().svg().to_owned();
        let series = svg.split("overflow=\"hidden\"").nth(1).unwrap().to_owned();
        let ends = ["x1", "x2", "y1", "y2"].map(|name| numbers_of(&series, "line", name));
        (ends, numbers_of(&svg, "svg", "width")[1], numbers_of(&svg, "svg", "x")[0], series)
    };
    // At the right end of the panel a line to twice its height is as far above as the panel is high.
    let heights = |y: f64| {
        let (.., series) = lines(plot().line(Line::new("line", &[0.0, 10.0], &[0.0, y])));
        let path = series.split("<path d=\"M").nth(1).unwrap().split('"').next().unwrap();
        let ends: Vec<&str> = path.split('L').collect();
        [ends[0], ends[1]].map(|end| end.split_once(' ').unwrap().1.parse::<f64>().unwrap())
    };
    let (inside, beyond) = (heights(10.0), heights(20.0));
    let high = inside[0] - inside[1];
    assert!((beyond[1] - (inside[1] - high)).abs() < 0.1, "{beyond:?} {inside:?}");
    // A mark beyond the range is not in the window; an endless interval has no end in it, and no mark a ring.
    let means = Points::new("means", &[5.0, 15.0], &[5.0, 5.0]);
    let (ends, width, left, series) =
        lines(plot().points(means.radius(3.0).x_intervals(&[(2.0, f64::INFINITY), (14.0, 16.0)])));
    let within = |x: &f64| (left..=left + width).contains(x);
    let at: Vec<f64> = numbers_of(&series, "circle", "cx").into_iter().filter(within).collect();
    assert!(!at.is_empty() && at.iter().all(|x| (x - at[0]).abs() < 0.1), "{at:?}");
    assert!(numbers_of(&series, "circle", "r").iter().all(|r| *r == 3.0), "{series}");
    // Bars begin at the interval's low end, twice: white below, in colour above. Of the caps only those are in the window.
    let caps: Vec<f64> =
        ends[0].iter().zip(&ends[1]).filter(|(a, b)| a == b).map(|(a, _)| *a).filter(within).collect();
    assert_eq!(caps.len(), 2, "{ends:?}");
    assert_eq!(caps[0], caps[1]);
}

#[test]
fn a_dashed_line_is_one_shape() {
    // From edge to edge a thousand times: millions of dashes.
    let x: Vec<f64> = (0..1000).map(|i| f64::from(i % 2)).collect();
    let of = |line: Line| Plot::new("x", "y").line(line).draw().unwrap().svg().len();
    let dashed = of(Line::new("front", &x, &x).dashed());
    assert!(dashed < of(Line::new("front", &x, &x)) + 100, "{dashed} bytes");
}

#[test]
fn figures_hold_their_labels() {
    let figures = one_of_each();
    for (figure, labels) in figures.iter().zip([
        &["MTF50 (cy/mm)", "ΔE*ab", "Title", "Note", "noise (%)", "valued", "means", "front"][..],
        &["Panels", "A", "B", "MTF50 (cy/mm)"],
        &["Wavelength (nm)", "Transmittance", "G"],
        &["ΔE", "designs", "h"],
        &["mosaic", "G"],
        &["picture", "other"],
    ]) {
        for label in labels {
            assert!(holds(figure, label), "{label} is missing");
        }
        let document = roxmltree::Document::parse(figure.svg()).unwrap();
        let names: Vec<&str> = document.root_element().children().map(|n| n.tag_name().name()).collect();
        assert!(names.contains(&"title") && names.contains(&"desc"), "{names:?}");
    }
}

#[test]
fn equal_inputs_give_equal_bytes() {
    for (a, b) in one_of_each().iter().zip(one_of_each()) {
        assert_eq!(a.svg(), b.svg());
        assert_eq!(a.png(1.0).unwrap(), b.png(1.0).unwrap());
    }
}

#[test]
fn pngs_have_their_size_and_their_text() {
    let figure =
        Plot::new("x", "y").size(320.0, 240.0).points(Points::new("", &[1.0], &[1.0])).draw().unwrap();
    assert_eq!(figure.size(), (320.0, 240.0));
    let (width, height, with) = decoded(&figure.png(1.5).unwrap());
    assert_eq!((width, height), (480, 360));
    // The title takes room, so compare labels of one height: ink must differ where the text differs.
    let other =
        Plot::new("W", "y").size(320.0, 240.0).points(Points::new("", &[1.0], &[1.0])).draw().unwrap();
    assert_ne!(with, decoded(&other.png(1.5).unwrap()).2);
    for scale in [0.0, -1.0, f64::NAN, 1e-9, 1e6] {
        assert!(matches!(figure.png(scale), Err(FigureError::Size { .. })), "{scale}");
    }
}

#[test]
fn hostile_names_stay_text() {
    let name = "</text><script>alert(1)</script>&\"'\u{0}\u{1b}\u{202e}\u{ffff}\n]]>";
    let figure = Plot::new(name, name)
        .title(name)
        .note(name)
        .values(name)
        .points(Points::new(name, &[1.0, 2.0], &[1.0, 2.0]).values(&[1.0, 2.0]))
        .line(Line::new(name, &[1.0], &[1.0]))
        .draw()
        .unwrap();
    let cell = Cell { letter: name.to_owned(), color: Rgb(1, 2, 3) };
    let mosaic = Mosaics::new().title(name).mosaic(name, 1, &[cell]).draw().unwrap();
    let sheet = Sheet::new(1).title(name).picture(name, 1, 1, &[0; 3]).draw().unwrap();
    for figure in [figure, mosaic, sheet] {
        let document = roxmltree::Document::parse(figure.svg()).unwrap();
        assert!(document.descendants().all(|n| n.tag_name().name() != "script"));
        assert!(!figure.svg().contains('\u{202e}'));
        figure.png(0.5).unwrap();
    }
}

#[test]
fn what_is_not_drawn_is_said() {
    let nan = f64::NAN;
    let points = Points::new("p", &[1.0, nan, 3.0, 2.0], &[1.0, 2.0, f64::INFINITY, 9.0]);
    let figure = Plot::new("x", "y").points(points).y_range(0.0, 5.0).draw().unwrap();
    assert!(
        holds(&figure, "2 of 4 marks have no place on the axes; 1 of 4 marks lie beyond the axes"),
        "{:?}",
        texts(&figure)
    );
    assert!(!figure.svg().contains("NaN") && !figure.svg().contains("inf"));
    let log = Plot::new("x", "y").x_scale(Scale::Log).points(Points::new("", &[-1.0, 10.0], &[1.0, 1.0]));
    assert!(holds(&log.draw().unwrap(), "1 of 2 marks have no place on the axes"));
    let empty = Plot::new("x", "y").points(Points::new("p", &[nan], &[1.0])).draw().unwrap();
    assert!(holds(&empty, "no data"));
    assert!(holds(&Plot::new("x", "y").draw().unwrap(), "no data"));
}

#[test]
fn bad_input_is_refused() {
    let lengths = Plot::new("x", "y").points(Points::new("s", &[1.0, 2.0], &[1.0])).draw().unwrap_err();
    assert_eq!(lengths.to_string(), "series `s`: 2 values of x, but 1 values of y");
    let values = Points::new("s", &[1.0], &[1.0]).values(&[]);
    assert!(matches!(Plot::new("x", "y").points(values).draw(), Err(FigureError::Lengths { .. })));
    let line = Line::new("l", &[1.0], &[]);
    assert!(matches!(Plot::new("x", "y").line(line).draw(), Err(FigureError::Lengths { .. })));
    for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (0.0, 1e-300)] {
        let plot = Plot::new("x", "y").x_range(low, high);
        assert!(matches!(plot.draw(), Err(FigureError::Range { axis: "x", .. })), "{low} {high}");
    }
    let log = Plot::new("x", "y").y_scale(Scale::Log).y_range(0.0, 1.0);
    assert!(matches!(log.draw(), Err(FigureError::Range { axis: "y", .. })));
    for (w, h) in [(0.0, 600.0), (800.0, f64::NAN), (1e9, 600.0), (100.0, 100.0), (-800.0, -600.0)] {
        let plot = Plot::new("x", "y").size(w, h);
        assert!(matches!(plot.draw(), Err(FigureError::Size { .. })), "{w} {h}");
    }
    assert!(matches!(Panels::new(0).draw(), Err(FigureError::Nothing { what: "panel" })));
    assert!(matches!(Mosaics::new().draw(), Err(FigureError::Nothing { what: "mosaic" })));
    assert!(matches!(Sheet::new(1).draw(), Err(FigureError::Nothing { what: "picture" })));
    let cell = Cell { letter: "R".to_owned(), color: Rgb(200, 0, 0) };
    for (cols, count) in [(0, 1), (2, 3), (1, 0)] {
        let mosaic = Mosaics::new().mosaic("m", cols, &vec![cell.clone(); count]);
        assert!(matches!(mosaic.draw(), Err(FigureError::Mosaic { .. })), "{count} in rows of {cols}");
    }
    assert!(matches!(
        Sheet::new(1).picture("p", 2, 2, &[0; 11]).draw(),
        Err(FigureError::Picture { expected: 12, .. })
    ));
    for (w, h) in [(0, 1), (1, usize::MAX), (1 << 20, 1)] {
        assert!(
            matches!(Sheet::new(1).picture("p", w, h, &[]).draw(), Err(FigureError::Size { .. })),
            "{w} × {h}"
        );
    }
}

/// Uniform noise in every pixel is the worst a cloud can hold.
#[test]
fn a_hundred_thousand_points_stay_below_a_megabyte() {
    let (x, y, v) = (noise(100_000, 1), noise(100_000, 2), noise(100_000, 3));
    let figure = Plot::new("x", "y").values("v").points(Points::new("", &x, &y).values(&v)).draw().unwrap();
    assert!(figure.svg().len() < 1_000_000, "{} bytes", figure.svg().len());
    assert!(holds(&figure, "drawn as a picture"));
    let panel = |k: usize| {
        let part = k * 8000..(k + 1) * 8000;
        Plot::new("x", "y")
            .values("v")
            .points(Points::new("", &x[part.clone()], &y[part.clone()]).values(&v[part]))
    };
    let panels = (0..5).fold(Panels::new(3), |panels, k| panels.panel(panel(k))).draw().unwrap();
    assert!(panels.svg().len() < 1_000_000, "{} bytes", panels.svg().len());
}

#[test]
fn pictures_keep_their_pixels() {
    let rgb: Vec<u8> = (0..160 * 120 * 3).map(|i| (i * 37 % 251) as u8).collect();
    let figure = Sheet::new(1).picture("p", 160, 120, &rgb).draw().unwrap();
    let (width, height, pixels) = decoded(&figure.png(1.0).unwrap());
    let rows: Vec<&[u8]> = pixels.chunks_exact(3 * width as usize).collect();
    let found = (0..height as usize - 120).any(|top| {
        (0..width as usize - 160).any(|left| {
            (0..120).all(|r| rows[top + r][3 * left..3 * (left + 160)] == rgb[3 * 160 * r..3 * 160 * (r + 1)])
        })
    });
    assert!(found, "the picture is not in the PNG pixel for pixel");
}

/// Copied pictures are those that the renderer of the SVG draws.
#[test]
fn a_sheet_has_the_same_png_with_and_without_svg() {
    let rgb: Vec<u8> = (0..3 * 37 * 22).map(|i| (i * i % 251) as u8).collect();
    for times in [1, 2, 5] {
        let sheet =
            Sheet::new(3).title("a title that is longer than one line of a narrow sheet").note("a note");
        let sheet = sheet.picture("one\nin two lines", 37, 22, &rgb).picture("smaller", 11, 14, &rgb[..462]);
        let sheet =
            sheet.picture("c", 22, 37, &rgb).picture("in the second row", 1, 1, &rgb[..3]).enlarge(times);
        assert!(sheet.png().unwrap() == sheet.draw().unwrap().png(1.0).unwrap(), "{times}");
    }
    assert!(matches!(Sheet::new(2).png(), Err(FigureError::Nothing { .. })));
}

/// A mark stands where its values say, on either scale; a colour bar's ends have the ends of viridis.
#[test]
fn points_stand_where_they_should() {
    for scale in [Scale::Linear, Scale::Log] {
        let plot = Plot::new("x", "y").x_scale(scale).x_range(1.0, 100.0).y_range(0.0, 1.0);
        let middle = if scale == Scale::Log { 10.0 } else { 50.5 };
        let points = Points::new("", &[1.0, middle, 100.0], &[0.0, 0.5, 1.0]).values(&[0.0, 0.5, 1.0]);
        let figure = plot.points(points).draw().unwrap();
        let document = roxmltree::Document::parse(figure.svg()).unwrap();
        let mut dots: Vec<(f64, f64, String)> = document
            .descendants()
            .filter(|n| n.tag_name().name() == "circle")
            .map(|n| {
                let number = |name| n.attribute(name).unwrap().parse().unwrap();
                (number("cx"), number("cy"), n.attribute("fill").unwrap().to_owned())
            })
            .collect();
        dots.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(dots.len(), 3);
        assert!((dots[1].0 - 0.5 * (dots[0].0 + dots[2].0)).abs() < 0.02, "{dots:?}");
        assert!(
            (dots[1].1 - 0.5 * (dots[0].1 + dots[2].1)).abs() < 0.02 && dots[0].1 > dots[2].1,
            "{dots:?}"
        );
        assert_eq!((dots[0].2.as_str(), dots[2].2.as_str()), ("#440154", "#fde725"));
    }
}

#[test]
fn histograms_count() {
    // Bins of width 1 from 0, about 40: 2, 1, 0, 3, none up to the last, 1.
    let values = [0.1, 0.9, 1.5, 3.0, 3.5, 3.99, 40.0, f64::NAN];
    let figure = Plot::new("x", "y").histogram(Histogram::new("h", &values)).draw().unwrap();
    let document = roxmltree::Document::parse(figure.svg()).unwrap();
    let outlines: Vec<&str> = document
        .descendants()
        .filter(|n| n.tag_name().name() == "path" && n.attribute("fill-opacity").is_some())
        .filter_map(|n| n.attribute("d"))
        .collect();
    // Three runs of bins; heights above the floor are as 2 : 1, 3 and 1.
    assert_eq!(outlines.len(), 3, "{outlines:?}");
    let heights: Vec<f64> = outlines
        .iter()
        .flat_map(|d| {
            let ys: Vec<f64> = d[1..]
                .trim_end_matches('Z')
                .split('L')
                .map(|p| p.split(' ').nth(1).unwrap().parse().unwrap())
                .collect();
            let floor = ys[0];
            ys.into_iter().map(move |y| floor - y).filter(|h| *h > 0.0).collect::<Vec<_>>()
        })
        .collect();
    let unit = heights[heights.len() - 1];
    let mut counts: Vec<i64> = heights.iter().map(|h| (h / unit).round() as i64).collect();
    counts.dedup();
    assert_eq!(counts, [2, 1, 3, 1]);
    assert!(holds(&figure, "1 of 8 values have no place on the axes"));
}

#[test]
fn colors_of_wavelengths_and_filters() {
    let [blue, green, red] = [450.0, 540.0, 650.0].map(Rgb::of_wavelength);
    assert!(blue.2 > blue.1 && green.1 > green.0.max(green.2) && red.0 > red.1.max(red.2));
    let (w, flat): (Vec<f64>, Vec<f64>) = (0..31).map(|i| (400.0 + 10.0 * f64::from(i), 0.95)).unzip();
    let grey = Rgb::of_transmittance(&w, &flat);
    assert!(grey.0.abs_diff(grey.1) < 40 && grey.1.abs_diff(grey.2) < 40, "{grey}");
    assert_eq!(Rgb::viridis(f64::NAN), Rgb::viridis(0.0));
    assert_eq!((Rgb::viridis(0.0), Rgb::viridis(2.0)), (Rgb(0x44, 0x01, 0x54), Rgb(0xfd, 0xe7, 0x25)));
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -100.0..100.0f64,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![0.0, -0.0, 5e-324, 1e-310, f64::MAX, f64::MIN, f64::INFINITY, f64::NAN]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    /// Whatever the numbers and names: a well-formed figure without a number that is none, or an error.
    #[test]
    fn any_numbers_and_names_give_a_figure_or_an_error(
        rows in prop::collection::vec((any_number(), any_number(), any_number()), 0..12),
        name in any::<String>(),
        log in any::<(bool, bool)>(),
        range in prop::option::of((any_number(), any_number())),
        size in prop::sample::select(vec![(800.0, 600.0), (300.0, 220.0), (90.0, 4000.0)]),
    ) {
        let x: Vec<f64> = rows.iter().map(|r| r.0).collect();
        let y: Vec<f64> = rows.iter().map(|r| r.1).collect();
        let v: Vec<f64> = rows.iter().map(|r| r.2).collect();
        let intervals: Vec<(f64, f64)> = rows.iter().map(|r| (r.2, r.0)).collect();
        let scale = |log| if log { Scale::Log } else { Scale::Linear };
        let mut plot = Plot::new(name.clone(), "y").size(size.0, size.1)
            .x_scale(scale(log.0)).y_scale(scale(log.1))
            .points(Points::new(name.clone(), &x, &y).values(&v))
            .points(Points::new("m", &x, &y).x_intervals(&intervals).y_intervals(&intervals))
            .line(Line::new("l", &x, &y).filled().corner(Corner::YFirst))
            .histogram(Histogram::new("h", &v).interval(v.first().copied().unwrap_or(1.0), 0.0, 1.0));
        if let Some((a, b)) = range { plot = plot.x_range(a, b).value_range(a, b); }
        match plot.draw() {
            Ok(figure) => {
                let document = roxmltree::Document::parse(figure.svg()).unwrap();
                for attribute in document.descendants().flat_map(|n| n.attributes()) {
                    prop_assert!(!attribute.value().contains("NaN") && !attribute.value().contains("inf"));
                }
                prop_assert!(figure.svg().len() < 200_000);
            }
            Err(error) => prop_assert!(matches!(error, FigureError::Range { .. } | FigureError::Size { .. }), "{}", error),
        }
    }
}
