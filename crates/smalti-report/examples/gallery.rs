//! One figure of each kind from made-up numbers: `cargo run -p smalti-report --example gallery -- FOLDER`.
#![allow(clippy::unwrap_used)]

use std::error::Error;
use std::path::{Path, PathBuf};

use smalti_report::{
    Cell, Corner, Figure, Histogram, Line, Mosaics, OKABE_ITO, Panels, Plot, Points, Rgb, Sheet, Symbol,
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "gallery".to_owned()));
    std::fs::create_dir_all(&folder)?;
    save(&folder, "series", &series().draw()?)?;
    save(&folder, "values", &cloud(100_000)?)?;
    save(&folder, "panels", &panels()?)?;
    save(&folder, "means", &means()?)?;
    save(&folder, "spectra", &spectra()?)?;
    save(&folder, "histograms", &histograms()?)?;
    save(&folder, "mosaics", &mosaics()?)?;
    save(&folder, "pictures", &pictures()?)?;
    save(&folder, "empty", &Plot::new("MTF50 (cy/mm)", "ΔE*ab").title("A study without a design").draw()?)?;
    Ok(())
}

fn save(folder: &Path, name: &str, figure: &Figure) -> Result<(), Box<dyn Error>> {
    let png = figure.png(2.0)?;
    println!("{name}: SVG {} kB, PNG {} kB", figure.svg().len() / 1000, png.len() / 1000);
    std::fs::write(folder.join(name).with_extension("svg"), figure.svg())?;
    Ok(std::fs::write(folder.join(name).with_extension("png"), png)?)
}

/// Numbers that look random, the same each time.
struct Dice(u64);

impl Dice {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Designs of `n` colours: MTF50, ΔE, luminance noise; about the spread of the seed study.
fn designs(n: usize, count: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut dice = Dice(n as u64);
    let (center, spread) = ([72.0, 60.0, 57.0, 54.0, 51.0][n - 3], [14.0, 6.0, 9.0, 7.0, 4.0][n - 3]);
    let base = [2.2, 1.6, 1.3, 1.2, 1.7][n - 3];
    let mut columns = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count {
        let far = dice.normal();
        columns.0.push(center + spread * far);
        columns.1.push(base + base * (0.5 * dice.normal()).exp() * (0.35 + 0.25 * far * far));
        columns.2.push(1.5 + 0.6 * far.abs() + 0.3 * dice.uniform());
    }
    columns
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

fn series() -> Plot {
    let mut plot = Plot::new("MTF50 (cy/mm)", "Mean colour difference ΔE*ab")
        .title("What more colours cost in resolution")
        .note("1000 designs for each number of colours; lower right is better.");
    let mut all = Vec::new();
    for n in 3..=7 {
        let (mtf50, delta_e, _) = designs(n, 1000);
        all.extend(mtf50.iter().copied().zip(delta_e.iter().copied()));
        plot = plot.points(Points::new(format!("{n} colours"), &mtf50, &delta_e));
    }
    // From the sharpest down, whatever has the best colour so far is on the front.
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut least = f64::INFINITY;
    all.retain(|p| p.1 < least && std::mem::replace(&mut least, p.1) > p.1);
    all.reverse();
    let (x, y): (Vec<f64>, Vec<f64>) = all.into_iter().unzip();
    plot.line(Line::new("Pareto front", &x, &y).corner(Corner::YFirst).color(Rgb(20, 20, 20)).width(2.0))
}

fn cloud(count: usize) -> Result<Figure, Box<dyn Error>> {
    let (mtf50, delta_e, noise) = designs(3, count);
    Ok(Plot::new("MTF50 (cy/mm)", "Mean colour difference ΔE*ab")
        .title("Luminance noise of 100 000 three-colour designs")
        .values("Luminance noise (%)")
        .value_range(1.5, percentile(&noise, 0.99).round())
        .points(Points::new("", &mtf50, &delta_e).values(&noise))
        .draw()?)
}

fn panels() -> Result<Figure, Box<dyn Error>> {
    let mut panels = Panels::new(3).title("Luminance noise by number of colours").without_legend();
    for n in 3..=7 {
        let (mtf50, delta_e, noise) = designs(n, 1000);
        panels = panels.panel(
            Plot::new("MTF50 (cy/mm)", "Mean colour difference ΔE*ab")
                .title(format!("{n} colours"))
                .values("Luminance noise (%)")
                .points(Points::new("", &mtf50, &delta_e).values(&noise)),
        );
    }
    Ok(panels.draw()?)
}

fn means() -> Result<Figure, Box<dyn Error>> {
    let mut plot = Plot::new("MTF50 (cy/mm)", "Mean colour difference ΔE*ab")
        .title("Means, 90 % of the designs, and filters by rule")
        .note("Bars hold 90 % of the designs of a number of colours.");
    for (n, color) in (3..=7).zip(OKABE_ITO) {
        let (x, y, _) = designs(n, 1000);
        let interval = |v: &[f64]| [(percentile(v, 0.05), percentile(v, 0.95))];
        plot = plot.points(
            Points::new(format!("{n} colours, mean"), &[mean(&x)], &[mean(&y)])
                .symbol(Symbol::Square)
                .color(color)
                .x_intervals(&interval(&x))
                .y_intervals(&interval(&y)),
        );
    }
    // After the means, so that the legend names colours first; a rule in several colours is named by its symbol.
    let rules = [
        ("uniform", Symbol::Circle, 0.6),
        ("height-scaled", Symbol::TriangleUp, 0.5),
        ("all-scaled", Symbol::Star, 0.45),
    ];
    for (n, color) in (3..=7).zip(OKABE_ITO) {
        let (x, y, _) = designs(n, 1000);
        for (i, (rule, symbol, factor)) in rules.into_iter().enumerate() {
            let (x, y) = ([mean(&x) + 2.5 * i as f64 + 2.0], [mean(&y) * factor]);
            plot = plot.points(Points::new(rule, &x, &y).symbol(symbol).color(color).marks());
        }
    }
    Ok(plot.draw()?)
}

fn gaussian(center_nm: f64, sigma_nm: f64) -> (Vec<f64>, Vec<f64>) {
    let wavelengths: Vec<f64> = (0..=150).map(|i| 400.0 + 2.0 * f64::from(i)).collect();
    let values = wavelengths.iter().map(|w| (-0.5 * ((w - center_nm) / sigma_nm).powi(2)).exp()).collect();
    (wavelengths, values)
}

fn filter_color(center_nm: f64, sigma_nm: f64) -> Rgb {
    let (w, t) = gaussian(center_nm, sigma_nm);
    Rgb::of_transmittance(&w, &t)
}

fn spectra() -> Result<Figure, Box<dyn Error>> {
    let mut plot =
        Plot::spectra("Transmittance").title("Filters of the best five-colour design").y_range(0.0, 1.05);
    for (letter, center, sigma) in
        [("B", 450.0, 24.0), ("C", 500.0, 22.0), ("G", 545.0, 26.0), ("Y", 585.0, 30.0), ("R", 630.0, 34.0)]
    {
        let (w, t) = gaussian(center, sigma);
        plot = plot.line(Line::new(letter, &w, &t).color(Rgb::of_transmittance(&w, &t)).filled().width(3.0));
    }
    Ok(plot.draw()?)
}

fn histograms() -> Result<Figure, Box<dyn Error>> {
    let mut plot = Plot::new("Mean colour difference ΔE*ab", "Designs per bin")
        .title("How colour spreads over the designs")
        .note("Bars above: the interval that holds 90 % of the designs, and their mean.");
    for n in [3, 4, 6] {
        let (_, delta_e, _) = designs(n, 1000);
        let (low, high) = (percentile(&delta_e, 0.05), percentile(&delta_e, 0.95));
        plot = plot.histogram(Histogram::new(format!("{n} colours"), &delta_e).interval(
            low,
            mean(&delta_e),
            high,
        ));
    }
    Ok(plot.draw()?)
}

fn mosaics() -> Result<Figure, Box<dyn Error>> {
    let filters: Vec<Cell> =
        [("R", 620.0), ("G", 545.0), ("B", 455.0), ("C", 500.0), ("Y", 580.0), ("V", 425.0), ("O", 600.0)]
            .into_iter()
            .map(|(letter, center)| Cell { letter: letter.to_owned(), color: filter_color(center, 25.0) })
            .collect();
    let tile = |text: &str| -> Vec<Cell> {
        text.chars().map(|c| filters.iter().find(|f| f.letter == c.to_string()).unwrap().clone()).collect()
    };
    Ok(Mosaics::new()
        .title("Winning mosaics")
        .note("One period is framed.")
        .mosaic("3 colours\nΔE 2.1, 76 cy/mm", 2, &tile("RGGB"))
        .mosaic("4 colours\nΔE 1.6, 61 cy/mm", 2, &tile("RGCB"))
        .mosaic("5 colours\nΔE 1.3, 60 cy/mm", 3, &tile("RGBCYRGBC"))
        .mosaic("6 colours\nΔE 1.2, 56 cy/mm", 3, &tile("RGBCYVGRB"))
        .mosaic("7 colours\nΔE 1.7, 52 cy/mm", 3, &tile("ROYGCBVGR"))
        .draw()?)
}

/// A circular zone plate, sampled so coarsely that it aliases, tinted more the further from grey.
fn zone_plate(side: usize, tint: f64) -> Vec<u8> {
    let mut rgb = Vec::with_capacity(3 * side * side);
    for (row, col) in (0..side).flat_map(|r| (0..side).map(move |c| (r as f64, c as f64))) {
        let (x, y) = (col / side as f64 - 0.5, row / side as f64 - 0.5);
        let wave = |shift: f64| 0.5 + 0.5 * ((x * x + y * y) * side as f64 * 2.4 + shift).cos();
        rgb.extend([-tint, 0.0, tint].map(|shift| (255.0 * wave(shift).powf(1.0 / 2.2)) as u8));
    }
    rgb
}

fn pictures() -> Result<Figure, Box<dyn Error>> {
    let mut sheet = Sheet::new(3)
        .title("Aliasing on the zone plate")
        .note("Rendered by the design of least aliasing of each.");
    for (n, tint) in [(3, 0.1), (5, 0.6), (7, 1.4)] {
        sheet = sheet.picture(format!("{n} colours"), 300, 300, &zone_plate(300, tint));
    }
    Ok(sheet.draw()?)
}
