//! Checks that the processing of a study suits its designs and conditions.

use smalti::design::{Condition, Study, TrialProcessing, Trials};

use super::file::StudyFile;
use crate::diagnostic::Diagnostic;
use crate::toml_source::TomlSource;

/// The key of the demosaicking method.
const DEMOSAIC: &str = "isp.demosaic";

/// Checks that classic processing is defined for a mosaic of the study under a condition. `notes` receives what a condition does not do.
pub(super) fn check(
    trials: &Trials,
    file: &StudyFile,
    source: &TomlSource,
    notes: &mut Vec<String>,
) -> Result<(), Box<Diagnostic>> {
    let study = trials.study();
    if study.processing.contains(&TrialProcessing::Classic) {
        demosaicking(trials, file, source, notes)?;
    }
    notes.extend(same_light(study));
    Ok(())
}

fn demosaicking(
    trials: &Trials,
    file: &StudyFile,
    source: &TomlSource,
    notes: &mut Vec<String>,
) -> Result<(), Box<Diagnostic>> {
    let conditions = &trials.study().conditions;
    let mut methods: Vec<_> = conditions.iter().map(|c| c.camera.isp.demosaic).collect();
    methods.dedup();
    // The mosaics that a method is not defined for, and all mosaics.
    let undefined = |method: smalti::isp::Demosaic| {
        trials.mosaics().fold((0, 0), |(undefined, all), mosaic| {
            (undefined + usize::from(!method.is_defined_for(mosaic)), all + 1)
        })
    };
    let counts: Vec<(usize, usize)> = methods.iter().map(|&method| undefined(method)).collect();
    let Some(worst) = counts.iter().position(|(undefined, _)| *undefined > 0) else { return Ok(()) };
    let (method, (undefined, all)) = (methods[worst].name(), counts[worst]);
    let cure = format!("set = {{ \"{DEMOSAIC}\" = \"bilinear\" }} selects a method for any mosaic");
    let learned = trials.study().processing.contains(&TrialProcessing::L3);
    if !learned && counts.iter().all(|(undefined, all)| undefined == all) {
        let key =
            if file.set.contains_key(DEMOSAIC) { format!("set.{DEMOSAIC}") } else { "camera".to_owned() };
        let message = format!(
            "its demosaicking {method} is defined for Bayer mosaics only, and the study has no such mosaic"
        );
        let shown = source.about_key(&key, &message);
        return Err(Box::new(Diagnostic { help: Some(cure), ..shown }));
    }
    notes.push(format!(
        "the demosaicking {method} is defined for Bayer mosaics only: trials of {undefined} of {all} mosaics will have no scores with classic \
         processing; {cure}"
    ));
    Ok(())
}

/// A note where conditions differ in luminance alone and the camera exposes automatically.
fn same_light(study: &Study) -> Option<String> {
    let is_automatic = |c: &Condition| c.camera.exposure.time_ms.is_none();
    let same = |a: &Condition, b: &Condition| {
        a.luminance_cd_m2 != b.luminance_cd_m2 && a.illuminant == b.illuminant && a.camera == b.camera
    };
    // In a grid, each condition has one of every other luminance.
    let first = study.conditions.iter().find(|c| is_automatic(c))?;
    let has_same = study.conditions.iter().any(|other| same(first, other));
    has_same.then(|| {
        "the conditions differ in luminance, but the camera exposes automatically: every condition collects the same light, in another time. \
         set = { \"exposure.time_ms\" = 33 } states one time for all of them"
            .to_owned()
    })
}
