//! The built-in cameras.

use crate::toml_source::{BuiltinFile, builtin};

/// Their files, in the order of lists.
pub(super) static CAMERAS: &[BuiltinFile] = &[
    builtin!("cameras", "bayer", "The L³ slides' camera, Bayer"),
    builtin!("cameras", "rgbw", "The L³ slides' camera, RGBW 2 × 2"),
    builtin!("cameras", "clarity", "The L³ slides' camera, RCCB as in Aptina Clarity+"),
    builtin!("cameras", "kodak", "The L³ slides' camera, Kodak's panchromatic 4 × 4"),
    builtin!("cameras", "wang", "The L³ slides' camera, Wang et al. 2011, 5 × 5"),
    builtin!(
        "cameras",
        "rgbx",
        "The L³ slides' camera for near infrared, RGB and infrared without infrared cut"
    ),
    builtin!("cameras", "rgbcmy", "The L³ slides' camera, six colours in 3 × 2"),
    builtin!("cameras", "medical", "The L³ slides' camera, RGB and a narrow band for medical imaging"),
    builtin!("cameras", "table1", "\"Resolution in Color Filter Array Images\", table 1"),
    builtin!("cameras", "phone", "A phone of 2020: 1 µm pixels at f/1.8"),
    builtin!("cameras", "phone-quad", "Main camera of a phone, 1/1.31-inch type: quad-Bayer, 1.2 µm"),
    builtin!(
        "cameras",
        "phone-quad-binned",
        "The camera of phone-quad with the charge of 2 × 2 pixels in one sample of 2.4 µm"
    ),
    builtin!("cameras", "automotive", "Automotive, OmniVision's 2.8 µm pixel: RCCB"),
    builtin!("cameras", "machine-vision", "Machine vision, Sony IMX250: global shutter, 3.45 µm, Bayer"),
    builtin!("cameras", "cmv12000", "Cinema and machine vision, ams CMV12000: global shutter, 5.5 µm, Bayer"),
    builtin!("cameras", "full-frame", "Full-frame stills, Sony A7R II at ISO 100: 4.51 µm, Bayer"),
];
