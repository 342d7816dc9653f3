//! Uniform fields, which are learned from without images of them.

use std::collections::BTreeMap;

use super::{ClassKey, L3Error, Moments, Statistics};

/// Patches of a uniform field.
#[derive(Debug, Clone, PartialEq)]
pub struct EvenField {
    /// Its normalised samples without noise, one for each channel; they clip at 1.
    pub samples: Vec<f64>,
    /// Its target, one value for each output.
    pub target: Vec<f64>,
    /// The number of its patches at each position.
    pub times: u32,
}

impl Statistics {
    /// Adds patches of uniform fields at every position, as if from images of them. The patches count as flat.
    ///
    /// # Errors
    /// When a field has not one value per channel and output, or a value is not finite. Nothing is added then.
    pub fn add_even(&mut self, fields: &[EvenField]) -> Result<(), L3Error> {
        fields.iter().try_for_each(|field| self.ensure_even(field))?;
        let (taps, channels) = (self.axes().taps(), self.axes().mosaic().channels());
        for position in 0..self.axes().positions() {
            let channel_of: Vec<usize> = (0..taps).map(|tap| self.axes().channel_of(position, tap)).collect();
            let mut counts = vec![0.0; channels];
            channel_of.iter().for_each(|&channel| counts[channel] += 1.0);
            // A patch has one value for each channel, so that a class needs few moments until all fields are summed.
            let mut sums: BTreeMap<ClassKey, Moments> = BTreeMap::new();
            for EvenField { samples, target, times } in fields.iter().filter(|field| field.times > 0) {
                let clipped: Vec<f64> = samples.iter().map(|v| v.min(1.0)).collect();
                let (mut saturation, mut sum) = (0, 0.0);
                for (channel, (&v, &count)) in clipped.iter().zip(&counts).enumerate() {
                    saturation |= u32::from(count > 0.0 && v >= self.axes().clip()) << channel;
                    sum += count * v;
                }
                let mean = (sum / taps as f64) as f32;
                self.widen_trained(position, mean);
                let level = self.axes().levels_at(position).level_of(mean) as u16;
                let key = ClassKey { position: position as u32, saturation, level, texture: 0 };
                let z = [&[1.0], &*clipped, target].concat();
                let moments = sums.entry(key).or_insert_with(|| Moments::new(channels, self.outputs().len()));
                moments.add(&z, f64::from(*times));
            }
            let of_taps = channel_of.iter().map(|channel| 1 + channel);
            let of_outputs = (0..self.outputs().len()).map(|output| 1 + channels + output);
            let places: Vec<usize> = [0].into_iter().chain(of_taps).chain(of_outputs).collect();
            for (key, moments) in sums {
                self.class_mut(key).merge_repeated(&moments, &places);
            }
        }
        Ok(())
    }

    /// An error unless a field has a finite value for each channel and output.
    fn ensure_even(&self, EvenField { samples, target, .. }: &EvenField) -> Result<(), L3Error> {
        let channels = self.axes().mosaic().channels();
        if samples.len() != channels || samples.iter().any(|v| !v.is_finite()) {
            let reason = format!("an even field needs {channels} finite samples, one for each channel");
            return Err(L3Error::Table(reason));
        }
        if target.len() != self.outputs().len() {
            return Err(L3Error::Outputs { expected: self.outputs().len(), got: target.len() });
        }
        let Some(&value) = target.iter().find(|v| !v.is_finite()) else { return Ok(()) };
        Err(L3Error::Value {
            what: "the target of an even field".into(),
            row: 0,
            col: 0,
            value: value as f32,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::l3::Pair;
    use crate::l3::statistics::tests::axes;
    use crate::numeric::Planes;
    use crate::sensor::{Mosaic, RawImage, RawSamples, Sampling};

    /// A uniform field counts like an image of it, also where channels clip.
    #[test]
    fn even_fields_are_pictures_of_them() {
        for samples in [[0.31, 0.12, 0.45], [0.3, 1.6, 0.2], [1.2, 2.0, 1.1]] {
            an_even_field_is_a_picture_of_it(samples);
        }
    }

    fn an_even_field_is_a_picture_of_it(samples: [f64; 3]) {
        let target = [0.2, 0.7];
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let at = |i: usize| samples[mosaic.channel_at(i / 12, i % 12)].min(1.0) as f32;
        let names = ["R", "G", "B"].map(String::from).to_vec();
        let volts = RawSamples::Analog((0..144).map(at).collect());
        let raw = RawImage::new(12, 12, volts, Sampling::Mosaic(mosaic.clone()), names, 0.0, 1.0).unwrap();
        let plane = Planes::new(12, 12, 2, (0..288).map(|i| target[i / 144] as f32).collect()).unwrap();
        let empty = || Statistics::new(axes(), vec!["a".into(), "b".into()], false).unwrap();
        let (mut picture, mut field) = (empty(), empty());
        picture.add(&Pair { raw: &raw, seen: None, target: &plane }).unwrap();
        let even = |samples: &[f64], target: &[f64]| EvenField {
            samples: samples.to_vec(),
            target: target.to_vec(),
            times: 16,
        };
        field.add_even(&[even(&samples, &target)]).unwrap();
        // A quarter of the 8 × 8 patches within the image belongs to each position.
        assert!(picture.classes().keys().eq(field.classes().keys()) && field.count() == 64);
        for (a, b) in picture.classes().values().zip(field.classes().values()) {
            assert!(a.sums().iter().zip(b.sums()).all(|(a, b)| (a - b).abs() < 1e-6 * b.abs()));
        }
        for (a, b) in picture.trained().iter().flatten().zip(field.trained().iter().flatten()) {
            assert!((a - b).abs() < 1e-6);
        }
        let before = field.clone();
        for wrong in [
            even(&samples[1..], &target),
            even(&samples, &[0.1]),
            even(&[f64::NAN, 0.0, 0.0], &target),
            even(&samples, &[0.1, f64::INFINITY]),
        ] {
            assert!(field.add_even(&[even(&samples, &target), wrong]).is_err());
        }
        field.add_even(&[EvenField { times: 0, ..even(&samples, &target) }]).unwrap();
        assert_eq!(field, before);
    }

    /// Fields that are added at once, of one class and of others, are those that are added one by one.
    #[test]
    fn even_fields_add_up() {
        let fields: Vec<EvenField> = (1..40)
            .map(|i| EvenField {
                samples: vec![f64::from(i) / 30.0, f64::from(i * 7 % 11) / 10.0, f64::from(i * 5 % 13) / 9.0],
                target: vec![f64::from(i), 0.5],
                times: i as u32 % 4,
            })
            .collect();
        let empty = || Statistics::new(axes(), vec!["a".into(), "b".into()], false).unwrap();
        let (mut together, mut singly) = (empty(), empty());
        together.add_even(&fields).unwrap();
        fields.iter().for_each(|field| singly.add_even(std::slice::from_ref(field)).unwrap());
        assert_eq!(together.trained(), singly.trained());
        assert!(together.classes().keys().eq(singly.classes().keys()) && together.classes().len() > 8);
        for (a, b) in together.classes().values().zip(singly.classes().values()) {
            assert!(a.sums().iter().zip(b.sums()).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs()));
        }
    }
}
