//! A design that becomes better step by step.

use serde::Serialize;
use smalti::camera::description::{CfaDescription, PatternDescription};
use smalti::camera::{Camera, CameraDescription};
use smalti::design::light::LightStatistics;
use smalti::design::live::{live_conditions, live_objective};
use smalti::design::screen::Screen;
use smalti::design::search::{Improvement, Locks};
use smalti::sensor::Filter;

use super::EngineError;
use super::figures::{self, Expected};
use super::request::{ImproveRequest, space};

/// A design on its way to a better one.
pub(super) struct Improving {
    design: CameraDescription,
    camera: Camera,
    luminances_cd_m2: Vec<f64>,
    kept: Vec<bool>,
    improvement: Improvement,
}

/// What a step says.
#[derive(Debug, Serialize)]
pub(super) struct Step {
    design: CameraDescription,
    step: usize,
    cost: f64,
    own_cost: f64,
    expected: Vec<Expected>,
    is_done: bool,
}

impl Improving {
    pub(super) fn new(
        design: CameraDescription,
        statistics: &LightStatistics,
        request: &ImproveRequest,
    ) -> Result<Self, EngineError> {
        let camera = Camera::new(design.clone(), design.grid()?)?;
        let cfa = &camera.sensor.cfa;
        let mosaic = cfa.mosaic();
        let mut kept = vec![false; cfa.channels().len()];
        for letter in &request.locks.filters {
            let Some(at) = cfa.channels().iter().position(|c| c.name == *letter) else {
                return Err(EngineError::NoLock(format!("the array has no filter '{letter}'")));
            };
            kept[at] = true;
        }
        let mut cells = vec![request.locks.mosaic; mosaic.cells().len()];
        for &[row, col] in &request.locks.cells {
            if row >= mosaic.rows() || col >= mosaic.cols() {
                let (rows, cols) = (mosaic.rows(), mosaic.cols());
                let message = format!("the cell {row}, {col} is not in the tile of {rows} × {cols}");
                return Err(EngineError::NoLock(message));
            }
            cells[row * mosaic.cols() + col] = true;
        }
        let conditions = live_conditions(&camera, &request.luminances_cd_m2);
        let screen = Screen::new(&camera, statistics, &conditions)?;
        let locks = Locks { filters: kept.clone(), cells };
        let improvement = Improvement::new(
            vec![screen],
            space(request.family).sampled(camera.grid())?,
            &live_objective(),
            cfa,
            locks,
        )?;
        let luminances_cd_m2 = request.luminances_cd_m2.clone();
        Ok(Self { design, camera, luminances_cd_m2, kept, improvement })
    }

    pub(super) fn step(&mut self) {
        self.improvement.step();
    }

    pub(super) fn said(&self) -> Result<Step, EngineError> {
        Ok(Step {
            design: self.design()?,
            step: self.improvement.steps(),
            cost: self.improvement.cost(),
            own_cost: self.improvement.own_cost(),
            expected: figures::expected(&self.improvement.expected()?, &self.luminances_cd_m2),
            is_done: self.improvement.is_done(),
        })
    }

    /// The design so far. Filters that are kept stay as they were stated.
    fn design(&self) -> Result<CameraDescription, EngineError> {
        let cfa = &self.camera.sensor.cfa;
        let letter = |channel: usize| cfa.channels().get(channel).map_or("", |c| c.name.as_str());
        let mosaic = self.improvement.mosaic();
        let line = |row| (0..mosaic.cols()).map(|col| letter(mosaic.channel_at(row, col))).collect();
        let stated = &self.design.sensor.cfa.filters;
        let filter = |(channel, spectrum): (usize, smalti::spectrum::Spectrum)| {
            let name = letter(channel).to_owned();
            let grid = spectrum.grid();
            let samples = || Filter::Samples {
                start_nm: grid.start_nm(),
                step_nm: grid.step_nm(),
                values: spectrum.values().to_vec(),
            };
            let is_kept = self.kept.get(channel).copied().unwrap_or(false);
            let kept = stated.get(&name).filter(|_| is_kept).cloned();
            (name, kept.unwrap_or_else(samples))
        };
        let filters = self.improvement.transmittances()?.into_iter().enumerate().map(filter).collect();
        let mut design = self.design.clone();
        design.sensor.cfa = CfaDescription {
            pattern: PatternDescription::Letters((0..mosaic.rows()).map(line).collect()),
            filters,
            ..CfaDescription::default()
        };
        Ok(design)
    }
}
