//! Studies, the setup at work and the last trial.

use std::fmt;
use std::sync::Arc;

use smalti::camera::CameraError;
use smalti::design::{DesignError, Preview, PreviewDesign, PreviewLight, Study, TrialProcessing, Trials};
use smalti::sensor::NoiseMode;

/// Why there is no picture.
#[derive(Debug)]
#[non_exhaustive]
pub enum StudyPictureError {
    /// The input cannot be read.
    Input(serde_json::Error),
    /// The number of values of the planes is not that which their text states.
    Planes,
    /// There is no such study.
    NoStudy(usize),
    /// No setup was made.
    NoSetup,
    /// The study refused.
    Design(DesignError),
    /// A stage refused.
    Camera(CameraError),
}

impl fmt::Display for StudyPictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => write!(f, "the input cannot be read: {error}"),
            Self::Planes => f.write_str("the light has more or fewer samples than its description says"),
            Self::NoStudy(index) => write!(f, "there is no study {index}"),
            Self::NoSetup => f.write_str("no setup was made"),
            Self::Design(error) => error.fmt(f),
            Self::Camera(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for StudyPictureError {}

impl From<serde_json::Error> for StudyPictureError {
    fn from(error: serde_json::Error) -> Self {
        Self::Input(error)
    }
}

impl From<DesignError> for StudyPictureError {
    fn from(error: DesignError) -> Self {
        Self::Design(error)
    }
}

impl From<CameraError> for StudyPictureError {
    fn from(error: CameraError) -> Self {
        Self::Camera(error)
    }
}

/// What a page draws with.
#[derive(Default)]
pub struct StudyPictures {
    studies: Vec<Trials>,
    setup: Option<(usize, Preview)>,
    trial: Option<(u64, PreviewDesign)>,
}

impl StudyPictures {
    /// Adds a study, as JSON; returns its index.
    ///
    /// # Errors
    /// When it cannot be read or has no designs.
    pub fn study(&mut self, json: &[u8]) -> Result<usize, StudyPictureError> {
        let study: Study = serde_json::from_slice(json)?;
        self.studies.push(Trials::new(study)?);
        Ok(self.studies.len() - 1)
    }

    /// Makes a condition of a study with a processing ready, in place of what was there before. `light` is a
    /// [`PreviewLight`] as JSON, `codes` the numbers of its planes, 32 bits each, little-endian.
    ///
    /// # Errors
    /// When there is no such study or condition, or the light does not fit.
    pub fn setup(
        &mut self,
        study: usize,
        condition: usize,
        processing: TrialProcessing,
        light: &[u8],
        codes: &[u8],
    ) -> Result<(), StudyPictureError> {
        (self.setup, self.trial) = (None, None);
        let trials = self.studies.get(study).ok_or(StudyPictureError::NoStudy(study))?;
        let mut light: PreviewLight = serde_json::from_slice(light)?;
        let (mut numbers, []) = codes.as_chunks() else { return Err(StudyPictureError::Planes) };
        for planes in light.planes_mut() {
            let samples = planes.rows.checked_mul(planes.cols).and_then(|n| n.checked_mul(planes.count));
            let (here, rest) =
                samples.and_then(|n| numbers.split_at_checked(n)).ok_or(StudyPictureError::Planes)?;
            planes.codes = Arc::new(here.iter().map(|&bytes| i32::from_le_bytes(bytes)).collect());
            numbers = rest;
        }
        if !numbers.is_empty() {
            return Err(StudyPictureError::Planes);
        }
        self.setup = Some((study, Preview::new(trials.study(), condition, processing, &light)?));
        Ok(())
    }

    /// What a trial of the study makes of a scene: RGBA, row by row.
    ///
    /// # Errors
    /// When there is no such trial or scene, or a stage refuses.
    pub fn draw(
        &mut self,
        number: u64,
        scene: usize,
        noise: NoiseMode,
    ) -> Result<Vec<u8>, StudyPictureError> {
        let (study, preview) = self.setup.as_ref().ok_or(StudyPictureError::NoSetup)?;
        let trials = self.studies.get(*study).ok_or(StudyPictureError::NoStudy(*study))?;
        if self.trial.as_ref().is_none_or(|(kept, _)| *kept != number) {
            self.trial = Some((number, preview.design(&trials.trial(number)?.design)?));
        }
        let (_, design) = self.trial.as_ref().ok_or(StudyPictureError::NoSetup)?;
        Ok(preview.picture(design, scene, noise)?.rgba8())
    }
}
