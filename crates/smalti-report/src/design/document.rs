//! The results of a search as the command writes them.

use serde::Deserialize;
use smalti::spectrum::Illuminant;

/// `results.json` of a search, as far as its page shows it.
#[derive(Debug, Clone, Deserialize)]
pub struct Document {
    pub(super) name: String,
    pub(super) camera: String,
    pub(super) illuminants: Vec<Illuminant>,
    pub(super) wavelengths_nm: Vec<f64>,
    pub(super) quantum_efficiency: Vec<f64>,
    pub(super) lens_and_ir_cut: Vec<f64>,
    pub(super) light: Vec<Light>,
    pub(super) seconds: f64,
    pub(super) own: Array,
    pub(super) searched: Vec<Array>,
    pub(super) rivals: Vec<Array>,
    pub(super) analysis: Analysis,
    #[serde(default)]
    pub(super) front: Front,
}

impl Document {
    /// The names of the illuminants.
    pub(super) fn illuminants(&self) -> String {
        crate::words::listed(&self.illuminants.iter().map(Illuminant::name).collect::<Vec<_>>())
    }
}

/// The statistics of the light under an illuminant.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Light {
    pub(super) scenes: u64,
    pub(super) patches: u64,
}

/// An array with its expected errors.
#[derive(Debug, Clone, Deserialize)]
pub struct Array {
    pub(super) name: String,
    /// Rows of letters, separated by slashes; `a` is the first filter.
    pub(super) tile: Option<String>,
    pub(super) filters: usize,
    /// Names of the filters; without them, the capital letters of the tile.
    pub(super) letters: Option<Vec<String>>,
    pub(super) cost: Option<f64>,
    pub(super) expected: Vec<Expected>,
    #[serde(default)]
    pub(super) costs_of_starts: Vec<f64>,
    pub(super) transmittances: Option<Vec<Vec<f64>>>,
    /// Absent in results of earlier versions.
    pub(super) figures: Option<ArrayFigures>,
}

impl Array {
    /// The name of a filter.
    pub(super) fn letter(&self, filter: usize) -> String {
        let named = self.letters.as_ref().and_then(|letters| letters.get(filter)).cloned();
        named.unwrap_or_else(|| char::from(b'A' + (filter % 26) as u8).to_string())
    }

    /// The columns of the tile, and its filters row by row.
    pub(super) fn cells(&self) -> (usize, Vec<usize>) {
        let rows: Vec<&str> = self.tile.as_deref().unwrap_or_default().split('/').collect();
        let cols = rows.first().map_or(0, |row| row.len());
        (cols, rows.concat().bytes().map(|b| usize::from(b.wrapping_sub(b'a'))).collect())
    }
}

/// What an array makes of light and colour under the first illuminant, from its spectra alone.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(super) struct ArrayFigures {
    pub(super) photon_efficiency: f64,
    pub(super) vora_value: f64,
    pub(super) sensitivity_metamerism_index: f64,
    pub(super) metamer_mismatch_percent: f64,
    pub(super) condition_number: Option<f64>,
    pub(super) luminance_noise_gain: f64,
}

/// Expected figures under an illuminant at a luminance.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Expected {
    pub(super) illuminant: String,
    pub(super) luminance_cd_m2: f64,
    pub(super) cpsnr_db: f64,
    pub(super) delta_e_2000: f64,
    pub(super) time_s: f64,
}

/// The means of CPSNR, dB, and CIEDE2000 over the luminances.
pub(super) fn means(expected: &[Expected]) -> [f64; 2] {
    let n = expected.len().max(1) as f64;
    let mean = |of: fn(&Expected) -> f64| expected.iter().map(of).sum::<f64>() / n;
    [mean(|e| e.cpsnr_db), mean(|e| e.delta_e_2000)]
}

/// What the array that was found depends on and what limits it.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Analysis {
    pub(super) expected: Vec<Expected>,
    pub(super) sensitivities: Vec<Sensitivity>,
    pub(super) limits: Vec<Limits>,
}

/// The expected errors when a filter deviates, or all alike.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Sensitivity {
    pub(super) filter: Option<String>,
    pub(super) words: String,
    pub(super) expected: Vec<Expected>,
}

/// The causes of the error at a luminance.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Limits {
    pub(super) luminance_cd_m2: f64,
    pub(super) classes: Vec<ClassLimits>,
}

/// The causes of the error of a class.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct ClassLimits {
    pub(super) class: String,
    pub(super) patches: f64,
    pub(super) noise: Cause,
    pub(super) sampling: Cause,
    pub(super) color: Cause,
}

/// A cause's part of an error.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(super) struct Cause {
    pub(super) squared_error: f64,
    pub(super) delta_e_2000: f64,
}

/// The best compromises between several aims, if they were asked for.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Front {
    pub(super) aims: Option<Vec<FrontAim>>,
    /// Whether the number of filters is an aim as well.
    #[serde(default)]
    pub(super) filters: bool,
    pub(super) points: Vec<FrontPoint>,
}

/// What a front is between.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct FrontAim {
    pub(super) name: String,
}

/// A compromise: the cost of each aim, and of its filters if they are one, and its array.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct FrontPoint {
    pub(super) costs: Vec<f64>,
    pub(super) design: Array,
}
