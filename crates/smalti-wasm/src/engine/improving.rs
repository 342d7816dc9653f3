//! A design that becomes better step by step.

use serde::Serialize;
use smalti::camera::{Camera, CameraDescription};
use smalti::design::light::LightStatistics;
use smalti::design::live::{FoundChannel, live_conditions, live_objective, with_array};
use smalti::design::screen::Screen;
use smalti::design::search::Improvement;

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
        let locks = request.locks.of(&camera)?;
        let kept = locks.filters.clone();
        let conditions = live_conditions(&camera, &request.luminances_cd_m2);
        let screen = Screen::new(&camera, statistics, &conditions)?;
        let improvement = Improvement::new(
            vec![screen],
            space(request.family).sampled(camera.grid())?,
            &live_objective(),
            &camera.sensor.cfa,
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

    /// The design so far.
    fn design(&self) -> Result<CameraDescription, EngineError> {
        let channels = self.camera.sensor.cfa.channels().iter().zip(&self.kept);
        let found: Vec<FoundChannel> = channels
            .zip(self.improvement.transmittances()?)
            .map(|((channel, stays), transmittance)| FoundChannel {
                letter: channel.name.clone(),
                transmittance,
                stays: *stays,
            })
            .collect();
        Ok(with_array(&self.design, self.improvement.mosaic(), &found))
    }
}
