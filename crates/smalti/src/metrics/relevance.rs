//! The smallest relevant difference of each metric. Smaller ones count as none in verdicts and in the marks of tables.
//!
//! The limits are this program's choice. Colour differences of 1 are just noticeable between patches side by side; a twentieth of it
//! in the mean over a picture is not. 0.1 dB are 2 % of the squared error. Scores of one chart or edge vary by some percent between
//! captures and between positions of the edge.

use std::fmt;

/// The smallest relevant difference of a metric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Relevance {
    /// In the unit of the metric.
    Absolute(f64),
    /// As a share of the smaller value.
    Relative(f64),
}

impl Relevance {
    /// Whether two values differ by at least the smallest relevant difference. Values that are not finite differ if they are not equal.
    #[must_use]
    pub fn is_relevant(self, a: f64, b: f64) -> bool {
        let difference = (a - b).abs();
        match self {
            _ if a == b => false,
            Self::Absolute(least) => difference.is_nan() || difference >= least,
            Self::Relative(share) => difference.is_nan() || difference >= share * a.abs().min(b.abs()),
        }
    }
}

impl fmt::Display for Relevance {
    /// `0.1` or `5 %`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absolute(least) => write!(f, "{least}"),
            Self::Relative(share) => write!(f, "{} %", (share * 1e4).round() / 100.0),
        }
    }
}

/// The smallest relevant difference of a metric of the [catalogue](super::CATALOG).
#[must_use]
pub fn smallest_relevant(metric: &str) -> Relevance {
    match metric {
        "cpsnr_db" => Relevance::Absolute(0.1),
        "dynamic_range_db" => Relevance::Absolute(0.5),
        "delta_e_76" | "delta_e_94" | "delta_e_2000" | "scielab_mean" => Relevance::Absolute(0.05),
        "pixel_delta_e_2000_mean" | "pixel_delta_e_2000_p95" => Relevance::Absolute(0.05),
        "vora_value" => Relevance::Absolute(0.005),
        "sensitivity_metamerism_index" => Relevance::Absolute(0.5),
        "saturated_percent" => Relevance::Absolute(0.1),
        "luminance_noise_percent" | "visual_snr" | "aliasing_percent" => Relevance::Relative(0.1),
        _ => Relevance::Relative(0.05),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_differences_are_not_relevant() {
        let cpsnr = smallest_relevant("cpsnr_db");
        assert!(!cpsnr.is_relevant(26.38, 26.37) && cpsnr.is_relevant(36.86, 36.43));
        assert!(!smallest_relevant("scielab_mean").is_relevant(1.83, 1.84));
        let noise = smallest_relevant("luminance_noise_percent");
        assert!(!noise.is_relevant(1.0, 1.03) && noise.is_relevant(1.2, 1.0));
        assert!(cpsnr.is_relevant(f64::NAN, 1.0) && !cpsnr.is_relevant(f64::INFINITY, f64::INFINITY));
        assert_eq!((cpsnr.to_string(), noise.to_string()), ("0.1".into(), "10 %".into()));
    }
    /// A share of a value near 0 is nothing: what may be 0 or less, and what is near 0 for a good camera, has a limit in its own unit.
    #[test]
    fn metrics_that_may_be_zero_have_an_absolute_limit() {
        let named = |name: &str| crate::metrics::CATALOG.iter().any(|m| m.name == name);
        for (name, none, some) in [
            ("cpsnr_db", 0.09, 0.11),
            ("dynamic_range_db", 0.4, 0.6),
            ("delta_e_76", 0.04, 0.06),
            ("delta_e_94", 0.04, 0.06),
            ("delta_e_2000", 0.04, 0.06),
            ("scielab_mean", 0.04, 0.06),
            ("pixel_delta_e_2000_mean", 0.04, 0.06),
            ("pixel_delta_e_2000_p95", 0.04, 0.06),
            ("vora_value", 0.004, 0.006),
            ("sensitivity_metamerism_index", 0.4, 0.6),
            ("saturated_percent", 0.09, 0.11),
        ] {
            let limit = smallest_relevant(name);
            assert!(named(name), "{name}");
            for at in [0.0, -2.0, 80.0] {
                assert!(!limit.is_relevant(at, at + none) && limit.is_relevant(at + some, at), "{name}");
            }
        }
        // All others, such as resolutions and noise, are compared by their ratio.
        for name in ["luminance_noise_percent", "visual_snr", "aliasing_percent", "mtf50_cy_per_px"] {
            let limit = smallest_relevant(name);
            assert!(!limit.is_relevant(1e-3, 1.04e-3) && limit.is_relevant(1e-3, 1.11e-3), "{name}");
        }
    }
}
