//! The expected figures of colour filter arrays.

use rayon::prelude::*;

use super::condition::Level;
use super::figures::Figures;
use super::kernel::{self, ErrorCovariances};
use super::lanes::{LANES, Lanes};
use super::model::Screen;
use super::responses::FilterResponses;
use crate::design::error::DesignError;
use crate::sensor::{Cfa, Mosaic};
use crate::spectrum::Spectrum;

/// Expected figures of a colour filter array under one condition, averaged over classes and positions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ExpectedError {
    /// Peak signal-to-noise ratio over X, Y, Z together, peak at display white, dB.
    pub cpsnr_db: f64,
    /// Peak signal-to-noise ratio of Y in the patches of the highest contrast, peak at display white, dB.
    pub detail_db: f64,
    /// Mean CIEDE2000 of the pixels; NaN unless asked for.
    pub delta_e_2000: f64,
    /// Mean difference that the eye sees: CIEDE2000 of what the opponent filters of S-CIELAB pass of the error, at the viewing distance
    /// of [`ScoreSettings`](crate::camera::ScoreSettings). NaN unless asked for. CIEDE2000 stands for the CIE 1976 formula of S-CIELAB, as in G. M. Johnson and
    /// M. D. Fairchild (2003), "A top down description of S-CIELAB and CIEDE2000", *Color Res. Appl.* 28.
    pub scielab: f64,
    /// Exposure time, s.
    pub time_s: f64,
}

impl Screen {
    /// The expected errors of a colour filter array, one for each condition.
    ///
    /// # Errors
    /// [`DesignError::Camera`] when its filters pass no light or are on other wavelengths.
    pub fn expected(&self, cfa: &Cfa) -> Result<Vec<ExpectedError>, DesignError> {
        let grid = self.electrons.first().map(Spectrum::grid).unwrap_or_default();
        let cfa = cfa.on_grid(grid)?;
        let transmittances: Vec<Spectrum> = cfa.channels().iter().map(|c| c.transmittance.clone()).collect();
        let responses = self.responses(&transmittances);
        let mut all = self.expected_of(cfa.mosaic(), std::slice::from_ref(&responses), Figures::All);
        Ok(all.pop().unwrap_or_default())
    }

    /// The expected errors of several sets of filters in one mosaic, for each set and condition. A set has a filter for each
    /// channel of the mosaic; those that it lacks see no light.
    #[must_use]
    pub fn expected_of(
        &self,
        mosaic: &Mosaic,
        sets: &[FilterResponses],
        figures: Figures,
    ) -> Vec<Vec<ExpectedError>> {
        let layout = self.layout(mosaic);
        let fitted: Vec<FilterResponses> =
            sets.iter().map(|s| s.fitted(layout.filters(), self.components).into_owned()).collect();
        let of_set = |(responses, errors): (&FilterResponses, Vec<ErrorCovariances>)| {
            let of_level = |(level, errors): (&Level, &ErrorCovariances)| {
                let time_s = level.time_s(&self.white, responses);
                self.figures(errors, layout.positions(), figures, time_s)
            };
            self.levels.iter().zip(&errors).map(of_level).collect()
        };
        let chunks = fitted.par_chunks(kernel::SETS).flat_map_iter(|chunk| {
            let errors = kernel::errors(self, &layout, chunk, figures);
            chunk.iter().zip(errors).map(of_set).collect::<Vec<_>>()
        });
        chunks.collect()
    }

    /// Figures from the error covariances of a condition, by position and group.
    pub(super) fn figures(
        &self,
        errors: &ErrorCovariances,
        positions: usize,
        figures: Figures,
        time_s: f64,
    ) -> ExpectedError {
        let (mut squares, mut detail, mut delta_e) = (0.0, 0.0, 0.0);
        for (at, error) in errors.pixels.iter().enumerate() {
            let group = at % self.groups;
            for lane in 0..LANES {
                let share = self.shares[group][lane];
                if share <= 0.0 {
                    continue;
                }
                let [square, difference] = self.figures_of(error, group, lane, figures);
                squares += share * square;
                detail += self.detailed[group][lane] * error[2][lane] * self.per_white_squared[group][lane];
                delta_e += share * difference;
            }
        }
        let n = positions as f64;
        let delta_e_2000 = if figures == Figures::Cpsnr { f64::NAN } else { delta_e / n };
        let scielab = if figures == Figures::All { self.seen(errors) / n } else { f64::NAN };
        let decibels = |mean_square: f64| -10.0 * libm::log10(mean_square);
        let detail_db = decibels(detail / n / self.detailed_share);
        ExpectedError { cpsnr_db: decibels(squares / n), detail_db, delta_e_2000, scielab, time_s }
    }

    /// The sum over positions of the mean difference that the eye sees.
    fn seen(&self, errors: &ErrorCovariances) -> f64 {
        let mut sum = 0.0;
        for (at, error) in errors.seen.iter().enumerate() {
            let group = at % self.groups;
            for lane in (0..LANES).filter(|lane| self.shares[group][*lane] > 0.0) {
                sum += self.shares[group][lane] * self.figures_of(error, group, lane, Figures::Color)[1];
            }
        }
        sum
    }

    /// The mean squared error, relative to display white, and CIEDE2000 of a class at one position.
    pub(super) fn figures_of(
        &self,
        error: &[Lanes; 6],
        group: usize,
        lane: usize,
        figures: Figures,
    ) -> [f64; 2] {
        let scaled = error.map(|e| e[lane] * self.per_white_squared[group][lane]);
        let difference = match (figures, self.colors.get(group * LANES + lane)) {
            (Figures::Color | Figures::All, Some(color)) => color.mean(&scaled),
            _ => 0.0,
        };
        [(scaled[0] + scaled[2] + scaled[5]) / 3.0, difference]
    }
}
