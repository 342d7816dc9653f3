//! The closed form against textbook Wiener estimation and against kernels that are fitted to captures.

use smalti::camera::Camera;
use smalti::design::light::{LightClasses, LightSettings, LightStatistics};
use smalti::design::screen::Screen;
use smalti::sensor::{BinningMode, Cfa, NoiseMode};
use smalti::spectrum::Spectrum;

use super::{
    LUMINANCE, TIME_S, bayer, binned, binned_with_crosstalk, camera, condition, leaves, settings, statistics,
    with_crosstalk,
};

/// Solves a x = b by elimination with pivoting, for several right-hand sides.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = a.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            for j in 0..b[i].len() {
                b[i][j] -= factor * b[k][j];
            }
        }
    }
    for k in (0..n).rev() {
        for j in 0..b[k].len() {
            let sum: f64 = (k + 1..n).map(|i| a[k][i] * b[i][j]).sum();
            b[k][j] = (b[k][j] - sum) / a[k][k];
        }
    }
    b
}

/// The error of the Wiener estimate, written out from the moments: the mean square over X, Y, Z relative to white.
fn textbook(screen: &Screen, statistics: &LightStatistics, camera: &Camera, cfa: &Cfa) -> f64 {
    let transmittances: Vec<Spectrum> = cfa.channels().iter().map(|c| c.transmittance.clone()).collect();
    let spectra = screen.response_spectra();
    let response = |t: &Spectrum| -> Vec<f64> {
        spectra.iter().map(|s| s.values().iter().zip(t.values()).map(|(a, b)| a * b).sum()).collect()
    };
    let responses: Vec<Vec<f64>> = transmittances.iter().map(response).collect();
    let (light_side, k, xyz) = (statistics.settings().side, statistics.basis().len(), statistics.xyz());
    let (light_taps, n) = (light_side * light_side, statistics.coefficients());
    // With crosstalk, samples are those within the outermost ring of pixels.
    let border = usize::from(camera.sensor.crosstalk.is_some());
    let side = light_side - 2 * border;
    let taps = side * side;
    let exposure = camera
        .sensor
        .noise_variance(0.0, &smalti::sensor::Exposure { time_s: TIME_S, ..camera.gain_and_offset() });
    let dark_v2 = exposure.unwrap().total();
    let exposure = smalti::sensor::Exposure { time_s: TIME_S, ..camera.gain_and_offset() };
    let per_e = camera.sensor.volts_per_electron(&exposure) * exposure.analog_gain;
    let dark_e2 = dark_v2 / (per_e * per_e);
    let scale = LUMINANCE * TIME_S;
    let mosaic = cfa.mosaic();
    let (mut sum, mut patches) = (0.0, 0.0);
    for class in statistics.classes().values().filter(|c| c.moments.count() >= 64) {
        let m = &class.moments;
        let count = m.count() as f64;
        let mean = |i: usize| m.get(0, 1 + i) / count;
        let covariance = |i: usize, j: usize| m.get(1 + i, 1 + j) / count - mean(i) * mean(j);
        for position in 0..4 {
            // A, a row for each sample: in electrons.
            let channel = |tap: usize| {
                let (r, c) = (tap / light_side, tap % light_side);
                mosaic.channel_at(
                    position / 2 + r + 2 * light_side - light_side / 2,
                    position % 2 + c + 2 * light_side - light_side / 2,
                )
            };
            // The shares of the light of pixels that a sample has.
            let shares = |tap: usize| -> Vec<(usize, f64)> {
                let (r, c) = (tap / side + border, tap % side + border);
                let Some(kernel) = &camera.sensor.crosstalk else { return vec![(r * light_side + c, 1.0)] };
                let mut all = Vec::new();
                for (down, line) in kernel.iter().enumerate() {
                    for (right, share) in line.iter().enumerate() {
                        // The light of this pixel reaches the sample through entry (down, right).
                        all.push(((r + 1 - down) * light_side + c + 1 - right, *share));
                    }
                }
                all
            };
            let row = |tap: usize| -> Vec<f64> {
                let mut row = vec![0.0; n];
                for (pixel, share) in shares(tap) {
                    for (a, f) in responses[channel(pixel)].iter().enumerate() {
                        row[pixel * k + a] += share * f * scale;
                    }
                }
                row
            };
            let a: Vec<Vec<f64>> = (0..taps).map(row).collect();
            let seen =
                |vector: &[f64], i: usize| -> f64 { (0..n).map(|j| vector[j] * covariance(j, i)).sum() };
            let ac: Vec<Vec<f64>> = a.iter().map(|row| (0..n).map(|i| seen(row, i)).collect()).collect();
            let mut g: Vec<Vec<f64>> = ac
                .iter()
                .map(|ac| a.iter().map(|row| ac.iter().zip(row).map(|(x, y)| x * y).sum()).collect())
                .collect();
            for (tap, line) in g.iter_mut().enumerate() {
                let signal: f64 = (0..n).map(|i| a[tap][i] * mean(i)).sum();
                // The last term stands for the precision of the statistics.
                line[tap] += dark_e2 + signal + 1e-12 * signal * signal;
            }
            let middle = light_taps / 2 * k;
            let target =
                |of: &dyn Fn(usize) -> f64, c: usize| -> f64 { (0..k).map(|b| of(b) * xyz[b][c]).sum() };
            let crossed: Vec<Vec<f64>> =
                ac.iter().map(|ac| (0..3).map(|c| target(&|b| ac[middle + b], c)).collect()).collect();
            let solved = solve(g, crossed.clone());
            for c in 0..3 {
                let own = target(&|b| target(&|d| covariance(middle + b, middle + d), c), c);
                let known: f64 = crossed.iter().zip(&solved).map(|(r, w)| r[c] * w[c]).sum();
                sum += (own - known) * class.per_white_squared / 12.0;
            }
        }
        patches += count;
    }
    sum / patches
}

#[test]
fn the_closed_form_is_wiener_estimation() {
    for camera in [camera(), with_crosstalk()] {
        let classes = LightClasses { luminance_cuts: vec![0.8], ..LightClasses::default() };
        let statistics = statistics(
            &camera,
            &[leaves(&camera, 1)],
            &LightSettings { side: 3, max_components: 6, ..settings(classes) },
        );
        let screen = Screen::new(&camera, &statistics, &[condition()]).unwrap();
        let expected = screen.expected(&bayer()).unwrap()[0];
        let mean_square = textbook(&screen, &statistics, &camera, &bayer());
        let found = libm::pow(10.0, -0.1 * expected.cpsnr_db);
        assert!((found / mean_square - 1.0).abs() < 1e-9, "{found} and {mean_square}");
    }
}

/// Kernels fitted to the samples of the same patches in a capture have the expected error to 1 %: with the crosstalk and the binning
/// of the simulator, too.
#[test]
fn the_closed_form_is_what_kernels_of_drawn_samples_reach() {
    for camera in [camera(), with_crosstalk(), binned(BinningMode::Charge), binned(BinningMode::Digital)] {
        fitted_kernels_have_the_expected_error(&camera);
    }
    for mode in [BinningMode::Charge, BinningMode::Digital] {
        fitted_kernels_have_the_expected_error(&binned_with_crosstalk(mode));
    }
}

fn fitted_kernels_have_the_expected_error(camera: &Camera) {
    let classes = LightClasses { contrast_cuts: Vec::new(), ..LightClasses::default() };
    let scene = leaves(camera, 2);
    let statistics =
        statistics(camera, std::slice::from_ref(&scene), &LightSettings { side: 3, ..settings(classes) });
    let screen = Screen::new(camera, &statistics, &[condition()]).unwrap();
    let cfa = bayer();
    let expected = screen.expected(&cfa).unwrap()[0];
    // The same scene, captured in the light of the condition.
    let lit = scene.with_mean_luminance(LUMINANCE).unwrap();
    let camera = camera.with_size(180, 180).with_cfa(cfa.clone());
    let image = camera.optics.image(&lit).unwrap();
    let exposure = camera.exposure(&image).unwrap();
    let reference = camera.reference(&image).unwrap();
    let raw = camera.sensor.capture(&image, &exposure, NoiseMode::All, 3).unwrap();
    let samples = raw.normalized();
    let xyz = reference.channels();
    let mut sorted: Vec<f32> = xyz[1].to_vec();
    sorted.sort_by(f32::total_cmp);
    let white = f64::from(sorted[(sorted.len() as f64 * 0.995) as usize]);
    // With crosstalk, the statistics are of patches of light that are one ring of pixels wider.
    let border = 1 + usize::from(camera.sensor.crosstalk.is_some());
    let inner = border..180 - border;
    let (mut sum, mut count) = (0.0, 0usize);
    for position in 0..4 {
        // Normal equations of z = (1, nine samples) against X, Y, Z.
        let (mut gram, mut against) = (vec![vec![0.0; 10]; 10], vec![vec![0.0; 3]; 10]);
        let mut squares = 0.0;
        let mut patches = 0usize;
        for row in inner.clone().filter(|r| r % 2 == position / 2) {
            for col in inner.clone().filter(|c| c % 2 == position % 2) {
                let mut z = vec![1.0];
                z.extend((0..9).map(|t| f64::from(samples[(row + t / 3 - 1) * 180 + col + t % 3 - 1])));
                let y: Vec<f64> = (0..3).map(|c| f64::from(xyz[c][row * 180 + col]) / white).collect();
                for i in 0..10 {
                    for j in 0..10 {
                        gram[i][j] += z[i] * z[j];
                    }
                    for c in 0..3 {
                        against[i][c] += z[i] * y[c];
                    }
                }
                squares += y.iter().map(|v| v * v).sum::<f64>();
                patches += 1;
            }
        }
        let kernels = solve(gram, against.clone());
        let explained: f64 =
            kernels.iter().zip(&against).map(|(w, r)| w.iter().zip(r).map(|(w, r)| w * r).sum::<f64>()).sum();
        // Ten fitted numbers explain a share of the noise.
        sum += (squares - explained) * patches as f64 / (patches as f64 - 10.0);
        count += patches;
    }
    let sampled = sum / count as f64 / 3.0;
    let found = libm::pow(10.0, -0.1 * expected.cpsnr_db);
    assert!((found / sampled - 1.0).abs() < 0.01, "{found} and {sampled}");
}
