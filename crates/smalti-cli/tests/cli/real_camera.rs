//! Raw files as photographers have them: from pairs of raw file and camera picture to a linear DNG that raw developers open.

use smalti::color::matrix::{apply, inverse};
use smalti::color::{ColorSpace, Image, display::Primaries};
use smalti::numeric::Planes;
use smalti::sensor::{Mosaic, RawSamples, Sampling};
use smalti_io::picture::{self, Depth};
use smalti_io::{Limits, Orientation, ReadOptions, dng, l3};

use crate::camera_dng::{CameraDng, Value, gain_map, opcode_list};
use crate::{Place, Run, numbers, python};

/// Side of the scenes to learn from, pixels.
const SIDE: usize = 192;
/// Side of a patch of the chart to render, pixels.
const PATCH: usize = 32;
/// Rows, columns and codes of the cells.
type Tile = ([u16; 2], Vec<u8>);

/// A camera and how it writes its raw files.
struct Maker {
    /// The camera that is simulated.
    camera: &'static str,
    luminance: f64,
    /// How bright it makes its pictures.
    gain: f64,
    /// The first row and column of the simulated image that its files have.
    first: [usize; 2],
    /// `CFARepeatPatternDim` and the codes of `CFAPattern`, from the first pixel of the active area.
    stated: fn(&Mosaic, &[String]) -> Tile,
    /// `CFAPlaneColor`, where it has one.
    planes: Option<Vec<u8>>,
    big_endian: bool,
    bits: usize,
    masked: [usize; 2],
    darker: [u16; 4],
    orientation: u16,
    /// Gain of the lens shading in the corners.
    shading: f64,
    noise: Option<Vec<f64>>,
}

/// Gain at a point of a map, from 1 in the middle to that of the corners.
fn gain_at(corner: f64, down: f64, across: f64) -> f64 {
    1.0 + (corner - 1.0) * ((down - 0.5).powi(2) + (across - 0.5).powi(2)) * 2.0
}

impl Maker {
    /// Simulates a shot and writes it as this camera does: `NAME.dng` and the picture `NAME.png`.
    fn shoot(&self, place: &Place, scene: &str, [rows, cols]: [usize; 2], name: &str) {
        let Self { camera, luminance, .. } = self;
        let words = format!(
            "simulate {camera} --scene {scene} --luminance {luminance} --set sensor.rows={rows} --set sensor.cols={cols} --bits 16 \
             --format tif -o {name} -q"
        );
        place.ok(&words);
        let raw = dng::read(&place.path(&format!("{name}/raw.dng")), Limits::default()).unwrap().raw;
        let RawSamples::Digital(samples) = raw.samples() else { panic!("digital numbers") };
        let Sampling::Mosaic(mosaic) = raw.sampling() else { panic!("a mosaic") };
        let [row, col] = self.first;
        let (rows, cols) = (raw.rows() - row, raw.cols() - col);
        let black = raw.black_level();
        const POINTS: usize = 9;
        let gain = |r: usize, c: usize| gain_at(self.shading, r as f64 / 8.0, c as f64 / 8.0);
        // The shading that the map undoes, by bilinear interpolation at the centre of each pixel.
        let shading = |r: usize, c: usize| {
            let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 * (POINTS - 1) as f64;
            let (y, x) = (at(r, rows), at(c, cols));
            let (top, left) = (y as usize, x as usize);
            let (below, right) = (y.fract(), x.fract());
            let along = |r: usize| gain(r, left) * (1.0 - right) + gain(r, left + 1) * right;
            along(top) * (1.0 - below) + along(top + 1) * below
        };
        let seen = (0..rows * cols).map(|i| {
            let (r, c) = (i / cols, i % cols);
            let v = f64::from(samples[(row + r) * raw.cols() + col + c]) - black;
            (black + v / if self.shading == 1.0 { 1.0 } else { shading(r, c) }).round() as u16
        });
        let (dim, pattern) = (self.stated)(&mosaic.shifted(row, col), raw.channel_names());
        let mut fields = vec![(33421, Value::Short(dim.to_vec())), (33422, Value::Byte(pattern))];
        fields.extend(self.planes.clone().map(|planes| (50710, Value::Byte(planes))));
        fields.extend(self.noise.clone().map(|noise| (51041, Value::Double(noise))));
        if self.shading != 1.0 {
            let map = gain_map(rows, cols, POINTS, |r, c| gain(r, c) as f32);
            fields.push((51009, opcode_list(&[(9, map)])));
        }
        // What is not applied is told: a correction of distortion, here by nothing.
        fields.push((51022, opcode_list(&[(1, vec![0; 4])])));
        let crop = [3, 5, rows - 8, cols - 12];
        let shot = CameraDng {
            samples: seen.collect(),
            rows,
            cols,
            big_endian: self.big_endian,
            bits: self.bits,
            masked: self.masked,
            darker: self.darker,
            black: black as u16,
            white: raw.white_level() as u16,
            orientation: self.orientation,
            crop,
            fields,
        };
        place.write(&format!("{name}.dng"), shot.bytes());
        let picture = self.picture(place, name, [row + crop[0], col + crop[1], crop[2], crop[3]]);
        // The camera turns the samples of its picture.
        let upright = Orientation::from_exif(self.orientation.into()).apply(picture);
        picture::write(&place.path(&format!("{name}.png")), &upright, Depth::Eight).unwrap();
    }

    /// A part of the simulated picture, as bright as this camera makes its pictures: no colour clips.
    fn picture(&self, place: &Place, name: &str, [row, col, rows, cols]: [usize; 4]) -> Image {
        let read = picture::read(&place.path(&format!("{name}/rendered.tif")), &ReadOptions::default());
        let linear = read.unwrap().image.converted(ColorSpace::LinearSrgb).unwrap();
        let own = place.json(&format!("{name}/metrics.json"))["picture"]["brightness_gain"].as_f64().unwrap();
        let gain = (self.gain / own) as f32;
        let stride = linear.planes().cols();
        let part = linear.planes().planes().flat_map(|p| {
            (row..row + rows).flat_map(move |r| p[r * stride + col..][..cols].iter().map(move |v| v * gain))
        });
        let planes = Planes::new(rows, cols, 3, part.collect()).unwrap();
        Image::new(ColorSpace::LinearSrgb, planes).unwrap().converted(ColorSpace::Srgb).unwrap()
    }

    /// Trains from two shots and renders a third, of a ColorChecker, to a linear DNG. `options` are those that its raw files need. Returns the
    /// notes on standard error.
    fn follow(&self, place: &Place, options: &str) -> String {
        for (scene, name) in [
            ("color-patches?rows=192&cols=192&least=16&doublings=1", "a"),
            ("dead-leaves?rows=192&cols=192&largest=60", "b"),
        ] {
            self.shoot(place, scene, [SIDE, SIDE], name);
        }
        self.shoot(place, &format!("macbeth?patch={PATCH}"), [4 * PATCH, 6 * PATCH], "c");
        let camera = self.camera;
        let pairs = "--pair a.dng a.png --pair b.dng b.png";
        let run = told(place, &format!("train {camera} --quality best {pairs} {options} -o best.l3"));
        let told_of_c = told(place, &format!("render c.dng --pipeline best.l3 {options} -o c-linear.dng"));
        self.assert_colors(place, "c-linear.dng");
        run.err + &told_of_c.err
    }

    /// The linear DNG has the colours of the camera's own picture up to their brightness: the mean of each patch within a tenth of white in
    /// every channel, since one patch lies beyond the colours that were learned, and all of them within a hundredth on average.
    fn assert_colors(&self, place: &Place, name: &str) {
        let [row, col] = self.first;
        let (rows, cols) = (4 * PATCH - row, 6 * PATCH - col);
        let wanted =
            self.picture(place, "c", [row, col, rows, cols]).converted(ColorSpace::LinearSrgb).unwrap();
        let wanted =
            patches([row, col], &|c, r, col| f64::from(wanted.planes().plane(c).unwrap()[r * cols + col]));

        let linear = dng::read(&place.path(name), Limits::default()).unwrap();
        assert_eq!(linear.raw.sampling(), &Sampling::Full { channels: 3 });
        assert_eq!((linear.raw.rows(), linear.raw.cols()), (rows, cols));
        assert_eq!(u16::from(linear.orientation.exif()), self.orientation);
        let crop = linear.default_crop.unwrap();
        assert_eq!([crop.row, crop.col, crop.rows, crop.cols], [3, 5, rows - 8, cols - 12]);
        let matrix = linear.info.color_matrix.as_ref().unwrap().camera_from_xyz.clone();
        let xyz_from_camera = inverse(&[matrix[0], matrix[1], matrix[2]]).unwrap();
        let rgb_from_xyz = Primaries::SRGB.rgb_from_xyz().unwrap();
        let values = linear.raw.normalized();
        let camera = patches([row, col], &|c, r, col| f64::from(values[(c * rows + r) * cols + col]));
        let found = camera.map(|v| apply(&rgb_from_xyz, apply(&xyz_from_camera, v)));
        close(&found, &wanted);

        // LibRaw develops it to the same colours.
        let Some(seen) = python("check_linear_dng.py", "rawpy", &[&place.path(name)]) else { return };
        assert_eq!(numbers(&seen[0]["shape"]), [rows as f64, cols as f64, 3.0]);
        let lines: Vec<Vec<f64>> = seen[0]["rows"].as_array().unwrap().iter().map(numbers).collect();
        let developed = patches([row, col], &|c, r, col| lines[r][3 * col + c]);
        close(&developed, &wanted);
    }
}

/// The means of the middles of the patches of the ColorChecker, of an image that begins at this row and column of the chart.
fn patches([row, col]: [usize; 2], value: &dyn Fn(usize, usize, usize) -> f64) -> [[f64; 3]; 24] {
    const EDGE: usize = PATCH / 4;
    std::array::from_fn(|patch| {
        std::array::from_fn(|channel| {
            let (top, left) = (patch / 6 * PATCH + EDGE - row, patch % 6 * PATCH + EDGE - col);
            let all = (0..PATCH * PATCH / 4).map(|i| (top + i / (PATCH / 2), left + i % (PATCH / 2)));
            all.map(|(r, c)| value(channel, r, c)).sum::<f64>() / (PATCH * PATCH / 4) as f64
        })
    })
}

/// Asserts that colours are those that are wanted, up to a common factor.
fn close(found: &[[f64; 3]; 24], wanted: &[[f64; 3]; 24]) {
    let (found, wanted) = (found.as_flattened(), wanted.as_flattened());
    let product = |a: &[f64]| a.iter().zip(found).map(|(a, b)| a * b).sum::<f64>();
    let scale = product(wanted) / product(found);
    let white = wanted.iter().copied().fold(0.0, f64::max);
    let errors = found.iter().zip(wanted).map(|(f, w)| (scale * f - w).abs() / white).collect::<Vec<_>>();
    let (worst, at) =
        errors.iter().zip(0..).fold((0.0, 0), |worst, (e, i)| if *e > worst.0 { (*e, i) } else { worst });
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    assert!(worst < 0.1 && mean < 0.01, "patch {}, channel {}: {worst}; mean {mean}", at / 3, at % 3);
}

/// Words separated by spaces, with notes on standard error.
fn told(place: &Place, words: &str) -> Run {
    let run = place.run(&words.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, 0, "smalti {words}: {}", run.err);
    run
}

/// The tile and the DNG codes of its letters.
fn as_it_is(mosaic: &Mosaic, names: &[String]) -> Tile {
    // Clear is white.
    let code = |c: &u8| match names[usize::from(*c)].as_str() {
        "C" => 6,
        name => "RGBCMYW".find(name).unwrap() as u8,
    };
    ([mosaic.rows() as u16, mosaic.cols() as u16], mosaic.cells().iter().map(code).collect())
}

const QUAD: Maker = Maker {
    camera: "bayer@quad-bayer",
    luminance: 400.0,
    gain: 1.2,
    first: [1, 0],
    stated: |_, _| ([2, 2], vec![0, 1, 1, 2]),
    planes: None,
    big_endian: false,
    bits: 16,
    masked: [0, 0],
    darker: [0; 4],
    orientation: 6,
    shading: 2.5,
    noise: None,
};

/// A telephone labels Quad Bayer as Bayer, corrects its lens by a map and is held upright.
#[test]
fn a_quad_bayer_file_that_claims_to_be_bayer() {
    let place = Place::new();
    let maker = Maker { noise: Some(vec![4e-3, 4e-6]), ..QUAD };
    maker.shoot(&place, "dead-leaves?rows=192&cols=192&largest=60", [SIDE, SIDE], "a");
    let run = place.run(&["train", maker.camera, "--pair", "a.dng", "a.png", "-o", "a.l3"]);
    assert_eq!(run.code, 1);
    for words in [
        "a.dng and a.png",
        "2 × 2 with channels R G G B",
        "4 × 4 with channels R R G G",
        "--raw-cfa states the mosaic",
    ] {
        assert!(run.err.contains(words), "no {words} in {}", run.err);
    }
    // From the second row of the tile on.
    let notes = maker.follow(&place, "--raw-cfa RRGG/GGBB/GGBB/RRGG");
    for words in [
        "note: a.dng: OpcodeList2: 1 gain map(s) for the shading of the lens are applied to the samples\n",
        "note: a.dng: OpcodeList3 is ignored, corrections of the demosaicked image: WarpRectilinear\n",
        "note: a.dng: NoiseProfile states a standard deviation of 2.01 % of the range at a tenth of it, the camera has 0.12 %. Classes depend on the \
         noise: expected a camera with a full well of 250 electrons and a read noise of 0.5 electrons\n",
        "note: c.dng: OpcodeList2: 1 gain map(s)",
    ] {
        assert_eq!(notes.matches(words).count(), 1, "{words} in {notes}");
    }
    let run = place.run(&["render", "c.dng", "--pipeline", "best.l3", "-o", "c.png"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("c.dng with best.l3") && run.err.contains("--raw-cfa"), "{}", run.err);
    // A picture is upright.
    told(&place, "render c.dng --pipeline best.l3 --raw-cfa RRGG/GGBB/GGBB/RRGG -o c-shown.png");
    let shown = picture::read(&place.path("c-shown.png"), &ReadOptions::default()).unwrap().image;
    assert_eq!((shown.planes().rows(), shown.planes().cols()), (6 * PATCH, 4 * PATCH - 1));
}

/// X-Trans as Adobe's converter writes it, with masked borders, its tile cut by the active area, its samples packed.
#[test]
fn an_x_trans_file() {
    let place = Place::new();
    let maker = Maker {
        camera: "bayer@xtrans",
        first: [1, 2],
        stated: as_it_is,
        planes: Some(vec![0, 1, 2]),
        big_endian: true,
        bits: 14,
        masked: [7, 13],
        orientation: 1,
        shading: 1.0,
        ..QUAD
    };
    let notes = maker.follow(&place, "");
    assert!(!notes.contains("gain map"), "{notes}");
}

/// The clear channel of an RCCB sensor is white to DNG; its black levels differ from cell to cell, and nothing lists the planes.
#[test]
fn an_rccb_file() {
    let place = Place::new();
    let maker = Maker {
        camera: "bayer@rccb",
        luminance: 120.0,
        first: [0, 1],
        stated: as_it_is,
        planes: None,
        masked: [4, 2],
        darker: [3, 0, 1, 2],
        orientation: 1,
        shading: 1.0,
        ..QUAD
    };
    let notes = maker.follow(&place, "");
    assert!(notes.contains("a.dng: black levels from 61 to 64"), "{notes}");
    // A file that claims to be of a Bayer sensor is not taken for one of this camera.
    Maker { stated: |_, _| ([2, 2], vec![1, 0, 2, 1]), ..maker }.shoot(
        &place,
        "uniform?size=64",
        [64, 64],
        "d",
    );
    let run = place.run(&["render", "d.dng", "--pipeline", "best.l3", "-o", "d.png"]);
    assert!(
        run.code == 1 && run.err.contains("2 × 2 with channels G R B G") && run.err.contains("--raw-cfa"),
        "{}",
        run.err
    );
    told(&place, "render d.dng --pipeline best.l3 -o d.png --raw-cfa CR/BC");
}

/// Red, green, blue and white, where the planes are listed without white.
#[test]
fn an_rgbw_file() {
    let place = Place::new();
    let maker = Maker {
        camera: "bayer@rgbw-sony",
        luminance: 120.0,
        first: [3, 1],
        stated: as_it_is,
        planes: Some(vec![0, 1, 2]),
        big_endian: true,
        masked: [1, 1],
        orientation: 3,
        shading: 1.0,
        ..QUAD
    };
    let notes = maker.follow(&place, "");
    assert!(notes.contains("a.dng: CFAPattern has colours that CFAPlaneColor does not list: W"), "{notes}");
}

/// The second stage knows the noise in the pictures of a camera, however bright they are: twice the brightness is four times the variance.
#[test]
fn the_noise_of_best_quality_is_that_of_the_pictures() {
    let place = Place::new();
    let constant = |gain: f64| {
        let maker = Maker { gain, orientation: 1, shading: 1.0, stated: as_it_is, planes: None, ..QUAD };
        maker.shoot(&place, "dead-leaves?rows=192&cols=192&largest=60", [SIDE, SIDE], "a");
        told(&place, "train bayer@quad-bayer --quality best --pair a.dng a.png -o a.l3");
        f64::from(l3::read_table(&place.path("a.l3")).unwrap().refinement().unwrap().axes().noise()[0])
    };
    let ratio = constant(1.2) / constant(0.6);
    assert!((ratio - 4.0).abs() < 0.1, "{ratio}");
}

#[test]
fn mosaics_that_cannot_be_stated() {
    let place = Place::new();
    for (mosaic, expected) in [
        ("quad-bayr", &["'quad-bayr'", "did you mean 'quad-bayer'?", "rows of letters such as GR/BG"][..]),
        ("GR/B", &["'GR/B'", "rows of equally many letters"]),
    ] {
        let run = place.run(&["render", "a.dng", "--pipeline", "a.l3", "-o", "a.png", "--raw-cfa", mosaic]);
        assert_eq!(run.code, 2);
        for words in expected {
            assert!(run.err.contains(words), "no {words} in {}", run.err);
        }
    }
}
