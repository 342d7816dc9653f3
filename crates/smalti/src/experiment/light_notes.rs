//! What is to be told of the light that cameras see, in words.

use super::SceneLight;
use crate::camera::{
    Camera, CameraError, DarkChannel, NOTABLE_INFRARED_SHARE, NOTABLE_UNSHARED_SHARE, TestScene,
    UnsharedLight,
};
use crate::spectrum::{Illuminant, Spectrum};

/// What a clear channel of a camera sees and the colour channels do not, under an illuminant (photons), in words with what would mend
/// it; empty when that is little. The name of the camera is not in them.
fn clear_channel_warnings(camera: &Camera, light: &Spectrum) -> Result<Vec<String>, CameraError> {
    let notable = |u: &UnsharedLight| u.share >= NOTABLE_UNSHARED_SHARE;
    let words = |u: UnsharedLight| {
        let [first, last] = u.seen_nm;
        let (range, mend) = if u.share_above >= u.share / 2.0 {
            let set = "--set 'optics.ir_cut={ builtin = \"hot-mirror\" }'";
            (format!("above {last:.0} nm"), format!("Add an infrared-cut filter: {set}"))
        } else {
            let mend = format!(
                "A lens or a filter that blocks light below {first:.0} nm avoids them (optics.transmittance)"
            );
            (format!("below {first:.0} nm"), mend)
        };
        format!(
            "{:.0} % of the response of the clear channel {} is to light {range}, to which no colour channel responds; this may cause \
             colour errors. {mend}",
            100.0 * u.share,
            u.channel,
        )
    };
    Ok(camera.unshared_light(light)?.into_iter().filter(notable).map(words).collect())
}

/// That all channels of a camera see near infrared under an illuminant (photons); `None` for a camera for visible light.
fn infrared_note(camera: &Camera, light: &Spectrum) -> Result<Option<String>, CameraError> {
    let share = camera.infrared_share(light)?;
    Ok((share >= NOTABLE_INFRARED_SHARE).then(|| {
        format!(
            "at least {:.0} % of the response of every channel is to light above 700 nm. The camera captures near infrared beside colour, and its \
             colours are wrong where objects reflect infrared",
            100.0 * share
        )
    }))
}

/// The channels of a camera that see almost nothing of an illuminant (photons), in words; empty when all see it.
fn dark_channel_warnings(camera: &Camera, light: &Spectrum) -> Result<Vec<String>, CameraError> {
    let words = |DarkChannel { channel, percent }| {
        format!(
            "the channel {channel} sees almost nothing of the illuminant: its response to white is {percent:.2} % of that of the brightest channel. Choose a \
             broader illuminant, or another filter (sensor.cfa.filters.{channel})"
        )
    };
    Ok(camera.dark_channels(light)?.into_iter().map(words).collect())
}

/// What is to be told of the light that a camera sees and does not see, under an illuminant (photons), in words that name keys of camera files. The name of
/// the camera is not in them.
///
/// # Errors
/// When a curve does not cover the wavelengths of the illuminant.
pub fn light_notes(camera: &Camera, light: &Spectrum) -> Result<Vec<String>, CameraError> {
    let dark = dark_channel_warnings(camera, light)?;
    let beside = clear_channel_warnings(camera, light)?.into_iter().chain(infrared_note(camera, light)?);
    Ok(dark.into_iter().chain(beside).collect())
}

/// The cameras for near infrared on scenes that contain none, in words; `None` without such cameras or scenes. `illuminant` is that of
/// the comparison.
///
/// # Errors
/// When a curve does not cover the wavelengths of a camera.
pub fn without_infrared(
    cameras: &[Camera],
    scenes: &[TestScene],
    illuminant: &Illuminant,
) -> Result<Option<String>, CameraError> {
    let ends_nm = scenes.iter().filter_map(TestScene::grid).filter_map(|grid| grid.wavelengths_nm().last());
    let (count, last_nm) = ends_nm.fold((0, 0.0f64), |(n, last), nm| (n + 1, last.max(nm)));
    let mut names = Vec::new();
    for camera in cameras {
        let light = illuminant.photons(camera.grid())?;
        let sees_more = camera.grid().wavelengths_nm().any(|nm| nm > last_nm);
        if sees_more && infrared_note(camera, &light)?.is_some() {
            names.push(camera.description().name.as_str());
        }
    }
    Ok((count > 0 && !names.is_empty()).then(|| {
        let which = match (count, scenes.len()) {
            (1, 1) => "the scene contains".to_owned(),
            (count, all) if count == all => "the scenes contain".to_owned(),
            (count, all) => format!("{count} of {all} scenes contain"),
        };
        format!(
            "{}: {which} no light above {last_nm:.0} nm, so that these figures leave out what near infrared does to colours; those of \
             --scenes charts include it",
            names.join(", "),
        )
    }))
}

/// What is to be told of scenes at other wavelengths than those of a camera whose pipeline was given, in words; `None` without such scenes. The name of
/// the camera is not in it.
#[must_use]
pub fn other_wavelengths_note(camera: &Camera, lights: &[SceneLight]) -> Option<String> {
    let own = camera.grid();
    let other = lights.iter().filter_map(|light| light.grid).find(|grid| *grid != own)?;
    Some(format!(
        "the table is for the wavelengths of the camera, {own}, and scenes have {other}. Pictures of these and their references differ in scale, which all scores include. \
         'smalti convert --wavelengths' gives a scene file other wavelengths"
    ))
}
