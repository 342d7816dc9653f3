//! The scenes of a report's pictures, and the camera that takes them.

use smalti::camera::Camera;
use smalti::design::{Condition, TrialPhotographer, TrialProcessing};

use super::sections::Section;
use crate::ReportError;

/// Rings up to the Nyquist frequency of the sensor in the middle of each side, on 256 × 256 pixels.
pub(super) const ZONE_PLATE: &str = "zone-plate?size=512&frequency=0.25";
/// Dead leaves with natural colours, on 288 × 384 pixels.
pub(super) const LEAVES: &str = "dead-leaves?rows=576&cols=768&least=2&largest=150&seed=1001";

/// Condition and processing of a section, and its camera.
pub(super) fn camera_of<'a>(
    section: &Section<'a>,
) -> Result<(&'a Condition, TrialProcessing, Camera), ReportError> {
    let (condition, processing) = setup_of(section)?;
    Ok((condition, processing, condition.camera()?))
}

/// What takes the pictures of a section.
pub(super) fn photographer_of(section: &Section<'_>) -> Result<TrialPhotographer, ReportError> {
    let (condition, processing) = setup_of(section)?;
    Ok(TrialPhotographer::new(section.results.study(), condition, processing)?)
}

fn setup_of<'a>(section: &Section<'a>) -> Result<(&'a Condition, TrialProcessing), ReportError> {
    section.results.setup(section.setup).ok_or(ReportError::Missing { what: "condition" })
}
