//! Classes of patches in words.

use super::LightClasses;

const DIRECTIONS: [&str; 3] = ["", "varying along rows", "varying along columns"];
const HUES: [&str; 5] = ["neutral", "red", "yellow", "green", "blue"];

impl LightClasses {
    /// A class in words, such as `contrast below 0.15`. Luminance is relative to the mean of the scene.
    #[must_use]
    pub fn name(&self, class: usize) -> String {
        let hues = if self.hues { HUES.len() } else { 1 };
        let textures = self.contrast_cuts.len() + if self.directions { DIRECTIONS.len() } else { 1 };
        let (hue, texture, level) = (class % hues, class / hues % textures, class / hues / textures);
        let contrast = texture.min(self.contrast_cuts.len());
        let words = [
            range("luminance", &self.luminance_cuts, level),
            range("contrast", &self.contrast_cuts, contrast),
            DIRECTIONS.get(texture - contrast).copied().unwrap_or_default().to_owned(),
            if self.hues { HUES[hue].to_owned() } else { String::new() },
        ];
        let stated: Vec<String> = words.into_iter().filter(|w| !w.is_empty()).collect();
        if stated.is_empty() { "all patches".to_owned() } else { stated.join(", ") }
    }
}

/// The range between two cuts; empty without any.
fn range(what: &str, cuts: &[f64], at: usize) -> String {
    match (at.checked_sub(1).and_then(|low| cuts.get(low)), cuts.get(at)) {
        (None, None) => String::new(),
        (None, Some(high)) => format!("{what} below {high}"),
        (Some(low), None) => format!("{what} from {low}"),
        (Some(low), Some(high)) => format!("{what} {low} to {high}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_names() {
        let plain = LightClasses::default();
        assert_eq!([0, 1].map(|c| plain.name(c)), ["contrast below 0.15", "contrast from 0.15"]);
        let none = LightClasses { contrast_cuts: Vec::new(), ..LightClasses::default() };
        assert_eq!(none.name(0), "all patches");
        let fine = LightClasses {
            luminance_cuts: vec![0.4, 1.8],
            directions: true,
            hues: true,
            ..LightClasses::default()
        };
        let names: std::collections::BTreeSet<String> = (0..fine.count()).map(|c| fine.name(c)).collect();
        assert_eq!(names.len(), fine.count());
        assert!(
            names.contains("luminance 0.4 to 1.8, contrast from 0.15, varying along rows, green"),
            "{names:?}"
        );
    }
}
