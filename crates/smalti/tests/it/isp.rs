//! Laws of processing, over random mosaics and sizes.
#![allow(missing_docs, clippy::unwrap_used)]

use proptest::prelude::*;
use smalti::color::ColorSpace;
use smalti::isp::demosaic::Bilinear;
use smalti::isp::{Classic, ColorMatrix, Demosaic, Isp, IspError, WhiteBalance};
use smalti::numeric::{Planes, philox::Stream};
use smalti::sensor::{Mosaic, RawImage, RawSamples, Sampling};

fn raw_of(mosaic: &Mosaic, rows: usize, cols: usize, f: impl Fn(usize, usize) -> f32) -> RawImage {
    let samples = (0..rows * cols).map(|i| f(i / cols, i % cols)).collect();
    let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
    let sampling = Sampling::Mosaic(mosaic.clone());
    RawImage::new(rows, cols, RawSamples::Analog(samples), sampling, names, 0.0, 1.0).unwrap()
}

fn noise(mosaic: &Mosaic, rows: usize, cols: usize, seed: u64) -> RawImage {
    let mut random = Stream::new(seed, 0, 0);
    let values: Vec<f32> = (0..rows * cols).map(|_| random.uniform() as f32).collect();
    raw_of(mosaic, rows, cols, |r, c| values[r * cols + c])
}

fn bayer(shift_rows: usize, shift_cols: usize) -> Mosaic {
    Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap().shifted(shift_rows, shift_cols)
}

/// Any mosaic up to 6 × 6 with 1 to 7 channels, each in at least one cell.
fn any_mosaic() -> impl Strategy<Value = Mosaic> {
    (1usize..=6, 1usize..=6, 1usize..=7, any::<u64>()).prop_map(|(rows, cols, channels, seed)| {
        let mut random = Stream::new(seed, 1, 0);
        let channels = channels.min(rows * cols);
        let mut cells: Vec<u8> = (0..rows * cols).map(|_| random.below(channels as u32) as u8).collect();
        for channel in 0..channels {
            // Overwrites a cell of a channel that has another one left, if there is such a cell.
            if !cells.contains(&(channel as u8)) {
                let twice = (0..cells.len()).find(|&i| cells.iter().filter(|&&c| c == cells[i]).count() > 1);
                cells[twice.unwrap()] = channel as u8;
            }
        }
        Mosaic::new(rows, cols, cells).unwrap()
    })
}

fn methods(mosaic: &Mosaic) -> Vec<Demosaic> {
    let bayer = (mosaic.rows(), mosaic.cols(), mosaic.channels()) == (2, 2, 3)
        && (mosaic.cells()[0] == mosaic.cells()[3] || mosaic.cells()[1] == mosaic.cells()[2]);
    let all = [Demosaic::Bilinear, Demosaic::Malvar2004, Demosaic::HamiltonAdams1997];
    if bayer { all.to_vec() } else { all[..1].to_vec() }
}

fn largest_error(planes: &Planes, expected: impl Fn(usize, usize, usize) -> f32, inset: usize) -> f32 {
    let (rows, cols) = (planes.rows(), planes.cols());
    let mut largest = 0.0f32;
    for (channel, plane) in planes.planes().enumerate() {
        for row in inset..rows.saturating_sub(inset) {
            for col in inset..cols.saturating_sub(inset) {
                largest = largest.max((plane[row * cols + col] - expected(channel, row, col)).abs());
            }
        }
    }
    largest
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Channels each constant stay so, to the rounding of a sum of a few products, up to the border.
    #[test]
    fn constants_stay_constant(mosaic in any_mosaic(), rows in 1usize..40, cols in 1usize..40) {
        let level = |channel: usize| 0.1 + 0.12 * channel as f32;
        let raw = raw_of(&mosaic, rows, cols, |r, c| level(mosaic.channel_at(r, c)));
        match Demosaic::Bilinear.apply(&raw) {
            Ok(planes) => prop_assert!(largest_error(&planes, |channel, _, _| level(channel), 0) < 3e-7),
            Err(IspError::ChannelNotSeen { .. }) => prop_assert!(rows < mosaic.rows() || cols < mosaic.cols()),
            Err(e) => prop_assert!(false, "{e}"),
        }
    }

    /// Away from the border a plane stays a plane: the weights of every cell have the right centre.
    #[test]
    fn gradients_are_reproduced(mosaic in any_mosaic(), dr in -0.01f32..0.01, dc in -0.01f32..0.01) {
        let plane = |r: usize, c: usize| 0.5 + dr * r as f32 + dc * c as f32;
        let planes = Demosaic::Bilinear.apply(&raw_of(&mosaic, 40, 41, plane)).unwrap();
        prop_assert!(largest_error(&planes, |_, r, c| plane(r, c), 12) < 1e-6);
    }

    #[test]
    fn measured_samples_are_kept(mosaic in any_mosaic(), seed in any::<u64>()) {
        let raw = noise(&mosaic, 13, 21, seed);
        let own = raw.normalized();
        for method in methods(&mosaic) {
            let planes = method.apply(&raw).unwrap();
            for (i, v) in own.iter().enumerate() {
                prop_assert_eq!(planes.plane(mosaic.channel_at(i / 21, i % 21)).unwrap()[i], *v);
            }
        }
    }

    /// Interpolation invents nothing: no value beyond those measured.
    #[test]
    fn bilinear_stays_in_range(mosaic in any_mosaic(), seed in any::<u64>()) {
        let planes = Demosaic::Bilinear.apply(&noise(&mosaic, 13, 21, seed)).unwrap();
        prop_assert!(planes.data().iter().all(|v| (0.0..=1.0).contains(v)));
    }

    /// Cropping by whole tiles crops the result, away from the border.
    #[test]
    fn shifts_by_the_tile_commute(mosaic in any_mosaic(), seed in any::<u64>()) {
        let (rows, cols) = (40, 43);
        let (down, right) = (mosaic.rows(), mosaic.cols());
        let raw = noise(&mosaic, rows, cols, seed);
        let all = raw.normalized();
        let cropped = raw_of(&mosaic, rows - down, cols - right, |r, c| all[(r + down) * cols + c + right]);
        for method in methods(&mosaic) {
            let (whole, part) = (method.apply(&raw).unwrap(), method.apply(&cropped).unwrap());
            let expected = |ch: usize, r: usize, c: usize| whole.plane(ch).unwrap()[(r + down) * cols + c + right];
            prop_assert_eq!(largest_error(&part, expected, 12), 0.0);
        }
    }

    /// 16-bit planes are the real-valued ones rounded.
    #[test]
    fn integers_are_rounded(mosaic in any_mosaic(), rows in 6usize..40, cols in 6usize..70, seed in any::<u64>()) {
        let mut random = Stream::new(seed, 2, 0);
        let samples: Vec<u16> = (0..rows * cols).map(|_| random.next_u32() as u16).collect();
        let method = Bilinear::new(&mosaic).unwrap();
        let mut got = vec![0; samples.len() * mosaic.channels()];
        method.apply_u16(&samples, rows, cols, &mut got).unwrap();
        let raw = raw_of(&mosaic, rows, cols, |r, c| f32::from(samples[r * cols + c]));
        let mut exact = Planes::zeros(rows, cols, mosaic.channels());
        method.apply_into(&raw, &mut exact).unwrap();
        for (g, e) in got.iter().zip(exact.data()) {
            // Half a unit, and the rounding of f32 near 65535.
            prop_assert!((f32::from(*g) - e).abs() <= 0.51, "{} for {}", g, e);
        }
    }
}

#[test]
fn bayer_methods_reproduce_constants_and_gradients() {
    for (shift, method) in
        (0..4).flat_map(|s| [Demosaic::Malvar2004, Demosaic::HamiltonAdams1997].map(|m| (s, m)))
    {
        let mosaic = bayer(shift / 2, shift % 2);
        for (rows, cols) in [(2, 2), (2, 9), (3, 5), (40, 37)] {
            let planes = method.apply(&raw_of(&mosaic, rows, cols, |_, _| 0.4)).unwrap();
            assert!(largest_error(&planes, |_, _, _| 0.4, 0) < 1e-6, "{method:?} {rows} × {cols}");
        }
        let plane = |r: usize, c: usize| 0.1 + 0.011 * r as f32 + 0.007 * c as f32;
        let planes = method.apply(&raw_of(&mosaic, 40, 37, plane)).unwrap();
        assert!(largest_error(&planes, |_, r, c| plane(r, c), 3) < 1e-6, "{method:?}");
    }
}

/// A corner of the random mosaic of the reference values and what ISETCam makes of its inside.
#[test]
fn bilinear_is_isetcams() {
    let mosaic = Mosaic::new(2, 2, vec![1, 0, 2, 1]).unwrap();
    let samples = [
        [0.6229, 0.6175, 0.0034, 0.9297, 0.6892, 0.1492],
        [0.7418, 0.1267, 0.6779, 0.942, 0.9967, 0.8447],
        [0.7952, 0.0018, 0.3379, 0.3444, 0.1615, 0.2948],
        [0.9425, 0.8714, 0.31, 0.3548, 0.0486, 0.4532],
        [0.7399, 0.2095, 0.8185, 0.5247, 0.9867, 0.9993],
        [0.9223, 0.2155, 0.4807, 0.7756, 0.5335, 0.8523],
    ];
    let expected = [
        [0.30965, 0.47335, 0.63705, 0.429525],
        [0.0018, 0.1731, 0.3444, 0.3196],
        [0.10565, 0.2701, 0.43455, 0.5408],
        [0.2095, 0.3671, 0.5247, 0.762],
        [0.1267, 0.3525, 0.942, 0.65935],
        [0.5328, 0.3379, 0.44905, 0.1615],
        [0.8714, 0.59565, 0.3548, 0.48905],
        [0.661325, 0.8185, 0.7339, 0.9867],
        [0.70985, 0.6779, 0.8373, 0.9967],
        [0.66805, 0.49395, 0.5083, 0.52265],
        [0.62625, 0.31, 0.1793, 0.0486],
        [0.663875, 0.39535, 0.3432, 0.29105],
    ];
    let planes = Demosaic::Bilinear.apply(&raw_of(&mosaic, 6, 6, |r, c| samples[r][c])).unwrap();
    let inside = |channel: usize, r: usize, c: usize| expected[channel * 4 + r - 1][c - 1];
    // f32 rounding of a sum of four.
    assert!(largest_error(&planes, inside, 1) < 2e-7);
    // At the border the mean is over the neighbours there are, where ISETCam repeats the outermost samples.
    assert_eq!(planes.plane(1).unwrap()[1], (samples[0][0] + samples[0][2] + samples[1][1]) / 3.0);
    assert_eq!(planes.plane(0).unwrap()[0], samples[0][1]);
}

/// The filters of Malvar, He and Cutler as their paper prints them, by the response to a single bright sample.
#[test]
fn malvar_impulses() {
    let mosaic = bayer(0, 0); // R G / G B
    let at = |row: usize, col: usize| {
        let raw = raw_of(&mosaic, 16, 16, |r, c| if (r, c) == (row, col) { 1.0 } else { 0.0 });
        let planes = Demosaic::Malvar2004.apply(&raw).unwrap();
        move |channel: usize, r: usize, c: usize| planes.plane(channel).unwrap()[r * 16 + c] * 8.0
    };
    let red = at(8, 8);
    assert_eq!([red(1, 8, 8), red(1, 8, 10), red(2, 8, 8), red(2, 10, 8)], [4.0, -1.0, 6.0, -1.5]);
    assert_eq!([red(0, 8, 9), red(0, 9, 8), red(0, 9, 9)], [4.0, 4.0, 2.0]);
    let green = at(8, 9);
    assert_eq!([green(1, 8, 8), green(0, 8, 9), green(2, 8, 9)], [2.0, 5.0, 5.0]);
    // At a green pixel, green two to the side along the channel's samples weighs −1, across them +1/2.
    assert_eq!([green(0, 8, 11), green(0, 10, 9), green(2, 8, 11), green(2, 10, 9)], [-1.0, 0.5, 0.5, -1.0]);
    assert_eq!([green(0, 9, 10), green(2, 9, 10)], [-1.0, -1.0]);
}

/// A step along the sensor's axes leaves no zipper in green with hamilton-adams1997, while bilinear has one.
#[test]
fn hamilton_adams1997_follows_edges() {
    let step = |_: usize, c: usize| if c < 20 { 0.2 } else { 0.8 };
    let raw = raw_of(&bayer(0, 0), 40, 40, step);
    let error = |m: Demosaic| {
        let planes = m.apply(&raw).unwrap();
        let green = Planes::new(40, 40, 1, planes.plane(1).unwrap().to_vec()).unwrap();
        largest_error(&green, |_, r, c| step(r, c), 3)
    };
    assert!(error(Demosaic::HamiltonAdams1997) < 1e-6);
    assert!(error(Demosaic::Bilinear) > 0.1);
}

#[test]
fn other_mosaics_are_refused_by_name() {
    let quad = Mosaic::new(4, 4, vec![0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 2, 2, 1, 1, 2, 2]).unwrap();
    for method in [Demosaic::Malvar2004, Demosaic::HamiltonAdams1997] {
        let error = method.apply(&noise(&quad, 16, 16, 1)).unwrap_err();
        assert!(matches!(error, IspError::UnsupportedCfa { rows: 4, cols: 4, channels: 3, .. }), "{error}");
    }
    // Bayer written as a larger tile is still Bayer.
    let twice = Mosaic::new(2, 4, vec![0, 1, 0, 1, 1, 2, 1, 2]).unwrap();
    assert!(Demosaic::Malvar2004.apply(&noise(&twice, 16, 16, 1)).is_ok());
}

#[test]
fn full_sampling_passes_through() {
    let samples = vec![16, 272, 16, 16, 272, 528];
    let sampling = Sampling::Full { channels: 3 };
    let names = ["R", "G", "B"].map(String::from).to_vec();
    let raw = RawImage::new(1, 2, RawSamples::Digital(samples), sampling, names, 16.0, 528.0).unwrap();
    for method in [Demosaic::Bilinear, Demosaic::Malvar2004, Demosaic::HamiltonAdams1997] {
        assert_eq!(method.apply(&raw).unwrap().data(), [0.0, 0.5, 0.0, 0.0, 0.5, 1.0]);
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mosaic = Mosaic::new(3, 3, vec![0, 1, 2, 3, 4, 5, 1, 2, 3]).unwrap();
    let matrix = ColorMatrix::new(vec![[0.1, 0.2, 0.3]; 6], vec![1.0; 6], [0.9, 1.0, 1.1]).unwrap();
    let isp = Classic { white_balance: WhiteBalance::GrayWorld, ..Classic::new(matrix) };
    let raw = noise(&mosaic, 120, 131, 3);
    let on = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| isp.render(&raw))
    };
    assert_eq!(on(1).unwrap(), on(3).unwrap());
}

/// X, Y, Z from three channels that are themselves X, Y, Z.
fn seeing() -> ColorMatrix {
    let eye = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    ColorMatrix::new(eye, vec![1.0985, 1.0, 0.3558], [1.0985, 1.0, 0.3558]).unwrap()
}

fn first_pixel(isp: &Classic, camera: [f32; 3]) -> [f64; 3] {
    let image = isp.render_planes(&Planes::new(1, 1, 3, camera.to_vec()).unwrap()).unwrap();
    assert_eq!(image.space(), ColorSpace::Xyz);
    [0, 1, 2].map(|i| f64::from(image.planes().plane(i).unwrap()[0]))
}

#[test]
fn white_balance_says_what_is_white() {
    let isp = |white_balance, gain| Classic { white_balance, gain, ..Classic::new(seeing()) };
    let white = [0.5493f32, 0.5, 0.1779];
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    let d65 = [0.3127 / 0.3290, 1.0, 0.3583 / 0.3290];
    assert!(near(first_pixel(&isp(WhiteBalance::None, 2.0), white), [1.0986, 1.0, 0.3558]));
    assert!(near(first_pixel(&isp(WhiteBalance::Illuminant, 2.0), [0.54925, 0.5, 0.1779]), d65));
    // Grey world takes any single colour for the light.
    let green = first_pixel(&isp(WhiteBalance::GrayWorld, 1.0), [0.1, 0.5, 0.2]);
    assert!(near(green.map(|v| v * 2.0), d65), "{green:?}");
    assert!(near(first_pixel(&isp(WhiteBalance::GrayWorld, 1.0), [0.0; 3]), [0.0; 3]));
}

#[test]
fn bad_input_is_named() {
    let isp = Classic::new(seeing());
    let two = Planes::zeros(2, 2, 2);
    assert!(matches!(isp.render_planes(&two), Err(IspError::Channels { expected: 3, got: 2, .. })));
    let isp = Classic { gain: f64::NAN, ..isp };
    assert!(matches!(
        isp.render_planes(&Planes::zeros(2, 2, 3)),
        Err(IspError::Parameter { name: "gain", .. })
    ));
    assert!(ColorMatrix::new(vec![], vec![], [1.0; 3]).is_err());
    assert!(ColorMatrix::new(vec![[f64::NAN; 3]], vec![1.0], [1.0; 3]).is_err());
    assert!(ColorMatrix::new(vec![[1.0; 3]], vec![1.0, 1.0], [1.0; 3]).is_err());
    assert!(ColorMatrix::new(vec![[1.0; 3]], vec![1.0], [1.0, 0.0, 1.0]).is_err());

    let small = noise(&bayer(0, 0), 1, 5, 1);
    for method in [Demosaic::Bilinear, Demosaic::Malvar2004, Demosaic::HamiltonAdams1997] {
        assert!(matches!(method.apply(&small), Err(IspError::ChannelNotSeen { channel: 2, .. })));
    }
    let mut sparse = vec![0; 200 * 200];
    sparse[0] = 1;
    let sparse = Mosaic::new(200, 200, sparse).unwrap();
    assert!(matches!(Bilinear::new(&sparse), Err(IspError::SparseChannel { channel: 1, .. })));
    let method = Bilinear::new(&bayer(0, 0)).unwrap();
    assert!(method.apply_u16(&[0; 16], 4, 4, &mut [0; 47]).is_err());
    assert!(method.apply_u16(&[0; 16], 4, 5, &mut [0; 60]).is_err());
    assert!(method.apply_u16(&[], 0, 4, &mut []).is_err());
    assert!(method.apply_u16(&[], usize::MAX, 4, &mut []).is_err());
    assert!(matches!(
        method.apply_into(&noise(&bayer(1, 0), 4, 4, 1), &mut Planes::zeros(4, 4, 3)),
        Err(IspError::Mosaic)
    ));
    assert!(method.apply_into(&noise(&bayer(0, 0), 4, 4, 1), &mut Planes::zeros(4, 5, 3)).is_err());
}
