//! The catalogue of metrics, for lists and reports.

/// The direction in which a metric improves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// Smaller is better.
    Lower,
    /// Larger is better.
    Higher,
    /// A property without a direction of improvement.
    Neither,
}

/// One metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MetricInfo {
    /// Its name in results.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The direction of improvement.
    pub better: Better,
    /// Its definition in one sentence.
    pub doc: &'static str,
    /// The standard or paper that defines it.
    pub source: &'static str,
}

const fn metric(
    name: &'static str,
    unit: &'static str,
    better: Better,
    doc: &'static str,
    source: &'static str,
) -> MetricInfo {
    MetricInfo { name, unit, better, doc, source }
}

use super::MetricError;
use Better::{Higher, Lower, Neither};

const EMVA_1288: &str = "EMVA 1288 release 4.0 Linear";
const OWN_ALIASING: &str = "defined by smalti, see metrics::aliasing";

/// All metrics, in the order colour, resolution, noise, differences from a reference, sensor.
pub const CATALOG: &[MetricInfo] = &[
    metric(
        "delta_e_76",
        "ΔE*ab",
        Lower,
        "Colour difference of chart patches, the distance in CIELAB; white patches scaled to Y = 100.",
        "ISO/CIE 11664-4:2019",
    ),
    metric(
        "delta_e_94",
        "ΔE*94",
        Lower,
        "Colour difference of chart patches, chroma and hue weighted for graphic arts.",
        "CIE 116-1995",
    ),
    metric(
        "delta_e_2000",
        "ΔE00",
        Lower,
        "Mean CIEDE2000 colour difference of the chart patches.",
        "ISO/CIE 11664-6:2014",
    ),
    metric(
        "vora_value",
        "0–1",
        Higher,
        "Share of the space of the CIE 1931 colour matching functions that the sensor's spectral sensitivities span.",
        "Vora & Trussell 1993",
    ),
    metric(
        "sensitivity_metamerism_index",
        "100 − 5.5 ΔE*ab",
        Higher,
        "Sensitivity metamerism index (SMI): 100 − 5.5 times the mean ΔE*ab of the ColorChecker's 18 colour patches after the matrix of least mean ΔE*ab, without noise.",
        "ISO 17321-1:2012",
    ),
    metric(
        "metamer_mismatch_percent",
        "%",
        Lower,
        "Range of X, Y, Z of the reflectances that the sensor cannot tell from a mid grey, over the range of all objects, mean of the three.",
        "Logvinenko et al. 2014",
    ),
    metric(
        "scielab_mean",
        "ΔE",
        Lower,
        "Mean colour difference from a reference picture after the blur of the eye at the viewing distance, adapted to the light of the scene.",
        "Zhang & Wandell 1997",
    ),
    metric(
        "mtf50_cy_per_px",
        "cycles/pixel",
        Higher,
        "Frequency at which a slanted edge keeps half of its contrast.",
        "ISO 12233 e-SFR",
    ),
    metric(
        "mtf50_cy_per_mm",
        "cycles/mm",
        Higher,
        "The same frequency on the sensor, from its pixel pitch.",
        "ISO 12233 e-SFR",
    ),
    metric(
        "mtf50_low_contrast_cy_per_px",
        "cycles/pixel",
        Higher,
        "The frequency for an edge of contrast 4:1, beside which `mtf50_cy_per_px` is that of an edge of 10⁶:1; they differ where processing depends on contrast.",
        "ISO 12233:2017 e-SFR",
    ),
    metric(
        "mtf50_low_contrast_cy_per_mm",
        "cycles/mm",
        Higher,
        "The same frequency on the sensor, from its pixel pitch.",
        "ISO 12233:2017 e-SFR",
    ),
    metric(
        "esfr_aliasing_percent",
        "%",
        Lower,
        "Area under the edge response from half a cycle per pixel upwards.",
        "ISETCam ISO12233",
    ),
    metric(
        "aliasing_percent",
        "%",
        Lower,
        "Energy of a picture that no linear transfer of an alias-free reference explains, luminance plus colour, over that of the picture, 0 to 100. In earlier results the energy of the reference was the base, without an upper limit: 971 % there is false colour of 3.1 times the contrast of the zone plate, a share of about 90 %.",
        OWN_ALIASING,
    ),
    metric("color_aliasing_percent", "%", Lower, "Chromatic part of `aliasing_percent`.", OWN_ALIASING),
    metric(
        "luminance_noise_percent",
        "%",
        Lower,
        "Standard deviation over mean of luminance on grey patches.",
        "ISETCam, after ISO 15739",
    ),
    metric("snr_db", "dB", Higher, "Mean over standard deviation of a uniform patch.", "ISO 15739:2023"),
    metric(
        "visual_snr",
        "1/ΔE*ab",
        Higher,
        "Reciprocal of the standard deviation of a uniform patch in S-CIELAB.",
        "Farrell et al. 2010",
    ),
    metric("psnr_db", "dB", Higher, "Peak over RMS difference from a reference, per plane.", "common use"),
    metric(
        "cpsnr_db",
        "dB",
        Higher,
        "Peak over RMS difference from a reference, over all planes.",
        "common use in demosaicking",
    ),
    metric(
        "pixel_delta_e_2000_mean",
        "ΔE00",
        Lower,
        "Mean CIEDE2000 between the pixels of a picture and of a reference, without a fit of the brightness.",
        "ISO/CIE 11664-6:2014",
    ),
    metric(
        "pixel_delta_e_2000_p95",
        "ΔE00",
        Lower,
        "95th percentile of CIEDE2000 over the pixels, against a reference.",
        "ISO/CIE 11664-6:2014",
    ),
    metric(
        "saturated_percent",
        "%",
        Lower,
        "Percentage of raw samples at the white level.",
        "defined by smalti, see sensor::RawImage::saturated_percent",
    ),
    metric(
        "light_gain_stops",
        "stops",
        Lower,
        "Additional light that a camera needs to equal another in one of the metrics, in powers of two.",
        "defined by smalti, see camera::light_gains",
    ),
    metric("dynamic_range_db", "dB", Higher, "Saturation over the signal that equals its noise.", EMVA_1288),
    metric("dynamic_range_stops", "stops", Higher, "The same in powers of two.", EMVA_1288),
    metric(
        "gain_dn_per_e",
        "DN/e⁻",
        Neither,
        "System gain, the slope of temporal variance over mean.",
        EMVA_1288,
    ),
    metric("dark_noise_e", "e⁻", Lower, "Temporal noise in the dark, without quantisation noise.", EMVA_1288),
    metric("saturation_e", "e⁻", Higher, "Signal at the largest temporal variance.", EMVA_1288),
    metric("prnu_percent", "%", Lower, "Spatial standard deviation of the photoresponse.", EMVA_1288),
    metric("dsnu_e", "e⁻", Lower, "Spatial standard deviation of the dark signal.", EMVA_1288),
    metric(
        "linearity_error_percent",
        "%",
        Lower,
        "Mean deviation of the signal from a straight line over exposure.",
        EMVA_1288,
    ),
];

/// The entry of a metric in the [catalogue](CATALOG).
///
/// # Errors
/// [`MetricError::UnknownMetric`] when no metric has this name.
pub fn metric_info(name: &str) -> Result<&'static MetricInfo, MetricError> {
    let found = CATALOG.iter().find(|m| m.name == name);
    found.ok_or_else(|| MetricError::UnknownMetric(name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_entries_are_complete() {
        for (i, m) in CATALOG.iter().enumerate() {
            assert!(CATALOG[..i].iter().all(|n| n.name != m.name), "{} appears twice", m.name);
            assert!(!m.name.is_empty() && !m.unit.is_empty() && m.doc.ends_with('.') && !m.source.is_empty());
            assert_eq!(metric_info(m.name), Ok(m));
        }
        assert_eq!(metric_info("psnr"), Err(MetricError::UnknownMetric("psnr".into())));
    }
}
