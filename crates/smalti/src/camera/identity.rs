//! Whether two cameras are the same but for their names.

use super::Camera;

impl Camera {
    /// Whether another camera gives the same pictures: all but the names of the cameras and of their colour filter arrays is equal.
    #[must_use]
    pub fn is_same_as(&self, other: &Self) -> bool {
        let (own, theirs) = (self.description(), other.description());
        let (a, b) = (&self.sensor, &other.sensor);
        let (own_cfa, their_cfa) = (&a.cfa, &b.cfa);
        self.grid() == other.grid()
            && own.exposure == theirs.exposure
            && own.isp == theirs.isp
            && self.optics == other.optics
            && (own_cfa.mosaic(), own_cfa.channels()) == (their_cfa.mosaic(), their_cfa.channels())
            && crate::sensor::Sensor { cfa: own_cfa.clone(), ..b.clone() } == *a
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::camera::CameraDescription;
    use crate::camera::description::PatternDescription;
    use crate::spectrum::WavelengthGrid;

    #[test]
    fn a_name_does_not_make_a_camera() {
        let of = |change: &dyn Fn(&mut CameraDescription)| {
            let mut d = CameraDescription::default();
            change(&mut d);
            Camera::new(d, WavelengthGrid::VISIBLE).unwrap()
        };
        let base = of(&|_| ());
        assert!(base.is_same_as(&of(&|d| d.name = "another".into())));
        // A mosaic of the catalogue and its letters.
        let letters = |d: &mut CameraDescription| {
            let cfa = crate::sensor::cfa::builtin("bayer", WavelengthGrid::VISIBLE).unwrap();
            let pattern = crate::sensor::cfa::pattern("bayer").unwrap();
            d.sensor.cfa.pattern = PatternDescription::Letters(pattern);
            let filters = crate::sensor::cfa::default_filters("bayer").unwrap();
            let named =
                |(letter, name): (char, String)| (letter.to_string(), crate::sensor::Filter::Builtin(name));
            d.sensor.cfa.filters = filters.into_iter().map(named).collect();
            assert_eq!(cfa.channels().len(), d.sensor.cfa.filters.len());
        };
        assert!(base.is_same_as(&of(&letters)));
        let changes: [&dyn Fn(&mut CameraDescription); 5] = [
            &|d| d.sensor.cfa.pattern = PatternDescription::Name("rgbw".into()),
            &|d| d.sensor.pixel.read_noise_mv = 2.0,
            &|d| d.optics.f_number = 2.8,
            &|d| d.exposure.time_ms = Some(10.0),
            &|d| d.isp.color_noise_percent = 1.0,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            assert!(!base.is_same_as(&of(change)), "change {i}");
        }
    }
}
