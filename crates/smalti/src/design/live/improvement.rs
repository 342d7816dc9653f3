//! What better designs are to the studio, whether its page or the native library searches them.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::camera::Camera;
use crate::camera::description::{CameraDescription, CfaDescription, PatternDescription};
use crate::design::screen::ScreenCondition;
use crate::design::search::{Dichroic, FilterSpace, FreeCurves, Locks, Objective, Over, Pigments};
use crate::sensor::{Filter, Mosaic};
use crate::spectrum::Spectrum;

/// The longest exposure of cameras that state no time, s, as in the built-in designs.
const LONGEST_S: f64 = 0.033;
/// Weight of a unit of CIEDE2000 beside a decibel, as in the built-in designs.
const DELTA_E_2000: f64 = 2.0;

/// The filters that can be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LiveFamily {
    /// Any smooth curve.
    #[default]
    Free,
    /// Layers of pigments.
    Pigments,
    /// Bands between two edges.
    Dichroic,
}

impl LiveFamily {
    /// The filters of the family; `free` are the smooth curves.
    #[must_use]
    pub fn space(self, free: FreeCurves) -> FilterSpace {
        match self {
            Self::Free => FilterSpace::Free(free),
            Self::Pigments => FilterSpace::Pigments(Pigments::default()),
            Self::Dichroic => FilterSpace::Dichroic(Dichroic::default()),
        }
    }
}

/// The conditions of a camera at some mean luminances, cd/m².
#[must_use]
pub fn live_conditions(camera: &Camera, luminances_cd_m2: &[f64]) -> Vec<ScreenCondition> {
    luminances_cd_m2.iter().map(|l| ScreenCondition::of_camera(camera, *l, LONGEST_S)).collect()
}

/// What is minimised: the worst of the conditions.
#[must_use]
pub fn live_objective() -> Objective {
    Objective { delta_e_2000: DELTA_E_2000, over: Over::Worst, ..Objective::default() }
}

/// What stays of an array, as a designer states it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiveLocks {
    /// Letters of filters. A filter that has no cell stays in any case.
    pub filters: Vec<String>,
    /// Row and column of cells, counted from 0.
    pub cells: Vec<[usize; 2]>,
    /// Whether all cells stay.
    pub mosaic: bool,
}

/// A lock of something that the array does not have.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LiveLockError {
    /// The design has no filter of this letter.
    #[error("the array has no filter {0:?}")]
    NoFilter(String),
    /// The cell is outside the tile.
    #[error("the cell {row}, {col} is not in the tile of {rows} × {cols}")]
    NoCell {
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
        /// Rows of the tile.
        rows: usize,
        /// Columns of the tile.
        cols: usize,
    },
}

impl LiveLocks {
    /// What stays of the array of a camera, by channel and by cell.
    ///
    /// # Errors
    /// When a filter is none of the design, or a cell is outside the tile.
    pub fn of(&self, camera: &Camera) -> Result<Locks, LiveLockError> {
        let (cfa, stated) = (&camera.sensor.cfa, &camera.description().sensor.cfa.filters);
        let (mosaic, channels) = (cfa.mosaic(), cfa.channels());
        let is_known =
            |letter: &String| stated.contains_key(letter) || channels.iter().any(|c| c.name == *letter);
        if let Some(unknown) = self.filters.iter().find(|letter| !is_known(letter)) {
            return Err(LiveLockError::NoFilter(unknown.clone()));
        }
        let mut cells = vec![self.mosaic; mosaic.cells().len()];
        let (rows, cols) = (mosaic.rows(), mosaic.cols());
        for &[row, col] in &self.cells {
            if row >= rows || col >= cols {
                return Err(LiveLockError::NoCell { row, col, rows, cols });
            }
            cells[row * cols + col] = true;
        }
        Ok(Locks { filters: channels.iter().map(|c| self.filters.contains(&c.name)).collect(), cells })
    }
}

/// A channel of an array that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundChannel {
    /// Its letter in the camera file.
    pub letter: String,
    /// Its transmittance.
    pub transmittance: Spectrum,
    /// Whether it is as it was.
    pub stays: bool,
}

/// A design with an array that was found. Filters that stay, and those that have no cell, remain as they were stated; the others are samples.
#[must_use]
pub fn with_array(design: &CameraDescription, mosaic: &Mosaic, found: &[FoundChannel]) -> CameraDescription {
    let mut filters = design.sensor.cfa.filters.clone();
    for FoundChannel { letter, transmittance, stays } in found {
        if !(*stays && filters.contains_key(letter)) {
            filters.insert(letter.clone(), Filter::sampled(transmittance));
        }
    }
    let letter = |row, col| found.get(mosaic.channel_at(row, col)).map_or("", |f| f.letter.as_str());
    let line = |row| (0..mosaic.cols()).map(|col| letter(row, col)).collect();
    let pattern = PatternDescription::Letters((0..mosaic.rows()).map(line).collect());
    let mut design = design.clone();
    design.sensor.cfa = CfaDescription { pattern, filters, ..CfaDescription::default() };
    design
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::WavelengthGrid;

    /// A tile of 2 × 3 cells, and a filter that has no cell.
    fn camera() -> Camera {
        let mut description = CameraDescription::default();
        let name = |letter: char| (letter.to_string(), Filter::Builtin(format!("pigment/{letter}")));
        description.sensor.cfa = CfaDescription {
            pattern: PatternDescription::Letters(vec!["RGB".into(), "GBG".into()]),
            filters: "RGBY".chars().map(name).collect(),
            ..CfaDescription::default()
        };
        Camera::new(description, WavelengthGrid::VISIBLE).unwrap()
    }

    #[test]
    fn locks_are_those_of_their_cells_and_letters() {
        let camera = camera();
        let of = |filters: &[&str], cells: &[[usize; 2]], mosaic: bool| {
            let filters = filters.iter().map(|f| (*f).to_owned()).collect();
            LiveLocks { filters, cells: cells.to_vec(), mosaic }.of(&camera)
        };
        for row in 0..2 {
            for col in 0..3 {
                let mut cells = [false; 6];
                cells[3 * row + col] = true;
                assert_eq!(of(&[], &[[row, col]], false).unwrap().cells, cells);
            }
        }
        let names: Vec<&str> = camera.sensor.cfa.channels().iter().map(|c| c.name.as_str()).collect();
        for letter in ["R", "G", "B"] {
            let expected: Vec<bool> = names.iter().map(|name| *name == letter).collect();
            assert!(expected.contains(&true));
            assert_eq!(of(&[letter], &[], false).unwrap().filters, expected);
        }
        let all = of(&["B", "R", "G", "Y"], &[], true).unwrap();
        assert!(all.filters.iter().chain(&all.cells).all(|kept| *kept));
        assert_eq!(of(&["G", "X"], &[], false), Err(LiveLockError::NoFilter("X".into())));
        for [row, col] in [[2, 0], [0, 3]] {
            let beyond = LiveLockError::NoCell { row, col, rows: 2, cols: 3 };
            assert_eq!(of(&[], &[[1, 2], [row, col]], false), Err(beyond));
        }
    }

    /// The design with an array that was found is a camera with that array, and filters that stay are stated as before.
    #[test]
    fn a_design_has_the_array_that_was_found() {
        let camera = camera();
        let clear = Spectrum::constant(WavelengthGrid::VISIBLE, 0.75).unwrap();
        let found: Vec<FoundChannel> = camera
            .sensor
            .cfa
            .channels()
            .iter()
            .map(|c| {
                let stays = c.name != "G";
                let transmittance = if stays { c.transmittance.clone() } else { clear.clone() };
                FoundChannel { letter: c.name.clone(), transmittance, stays }
            })
            .collect();
        let mosaic = Mosaic::new(1, 4, vec![1, 0, 2, 1]).unwrap();
        let design = with_array(camera.description(), &mosaic, &found);
        let stated = |letter: &str| design.sensor.cfa.filters.get(letter);
        for letter in ["R", "B", "Y"] {
            assert_eq!(stated(letter), Some(&Filter::Builtin(format!("pigment/{letter}"))));
        }
        assert_eq!(stated("G"), Some(&Filter::sampled(&clear)));
        let made = Camera::new(design, WavelengthGrid::VISIBLE).unwrap();
        let (array, cells) = (&made.sensor.cfa, made.sensor.cfa.mosaic().cells());
        assert_eq!((array.mosaic().rows(), array.mosaic().cols()), (1, 4));
        for (cell, channel) in cells.iter().zip(mosaic.cells()) {
            let (made, found) = (&array.channels()[usize::from(*cell)], &found[usize::from(*channel)]);
            assert_eq!(made.name, found.letter);
            // Samples are interpolated at their own wavelengths.
            let apart = made.transmittance.values().iter().zip(found.transmittance.values());
            assert!(apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12);
        }
    }

    #[test]
    fn conditions_are_those_of_the_camera_and_the_worst_counts() {
        let conditions = live_conditions(&camera(), &[1.0, 30.0]);
        assert_eq!(conditions.iter().map(|c| c.luminance_cd_m2).collect::<Vec<_>>(), [1.0, 30.0]);
        assert_eq!(live_objective().over, Over::Worst);
        assert!(live_objective().validate().is_ok());
        let free = FreeCurves::default();
        assert!(matches!(LiveFamily::Free.space(free.clone()), FilterSpace::Free(f) if f == free));
        assert!(matches!(LiveFamily::Pigments.space(free.clone()), FilterSpace::Pigments(_)));
        assert!(matches!(LiveFamily::Dichroic.space(free), FilterSpace::Dichroic(_)));
    }
}
