//! What lies beyond the border of the scene.

use serde::{Deserialize, Serialize};

use crate::numeric::fft::fast_len;
use crate::numeric::mirror::about_border;
use crate::numeric::{OutOfRange, require};

/// What the lens sees beyond the border of the scene. The optical image has the size of the scene, but with dark surroundings
/// it is larger by the margin on every side, and holds the light that spreads there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// Nothing, as in ISETCam: the border of the picture darkens.
    Dark,
    /// The outermost samples are repeated.
    Edge,
    /// The scene mirrored at its border.
    Mirror,
}

/// Room around the scene for light that spreads over its border.
///
/// The image is convolved as a torus, slightly larger than the padded scene where that transforms faster. It is
/// always large enough for the geometrical blur, but the tails of diffraction have no end, and what they spread beyond
/// the margin comes back in on the other side. That is little light: it shows only where the image is darker than
/// about 1 % of its brightest part (there by up to some ten per cent next to the border, with the margin of 1/8 at
/// f/4 and 0.7 µm samples). A wider margin, such as 1.0, removes it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Padding {
    /// What is beyond the border.
    pub boundary: Boundary,
    /// Width of the margin on each side, as a fraction (0–4) of the rows above and below and of the columns left
    /// and right; rounded to whole samples. Training (`Camera::train_on`, the default training set) uses at most 1/16.
    pub margin: f64,
}

impl Default for Padding {
    fn default() -> Self {
        Self { boundary: Boundary::Dark, margin: 0.125 }
    }
}

impl Padding {
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        require((0.0..=4.0).contains(&self.margin), "padding.margin", self.margin, "0 to 4")
    }

    /// How `len` samples are laid out for a blur that reaches `blur` samples far.
    pub(super) fn extent(&self, len: usize, blur: usize) -> Extent {
        let margin = (len as f64 * self.margin).round() as usize;
        let (offset, out, least) = match self.boundary {
            Boundary::Dark => (margin, len + 2 * margin, len + margin + margin.max(blur)),
            Boundary::Edge | Boundary::Mirror => (0, len, len + 2 * margin.max(blur)),
        };
        Extent { boundary: self.boundary, len, offset, out, total: fast_len(least) }
    }
}

/// One direction of a padded image: scene samples at `offset..offset + len` of a torus of `total` samples, whose
/// first `out` are the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extent {
    boundary: Boundary,
    pub(super) len: usize,
    pub(super) offset: usize,
    pub(super) out: usize,
    pub(super) total: usize,
}

impl Extent {
    /// The same torus, of which only the scene is the result.
    pub(super) fn without_margin(self) -> Self {
        Self { offset: 0, out: self.len, ..self }
    }

    /// Fills the places of a line of the torus around the samples of the scene, which stand in it, as [`Extent::source`] does place by place.
    pub(super) fn surround(&self, line: &mut [f32]) {
        if self.boundary == Boundary::Dark {
            line[..self.offset].fill(0.0);
            line[self.offset + self.len..].fill(0.0);
            return;
        }
        // Only a dark scene has an offset.
        let (scene, gap) = line.split_at_mut(self.len);
        let (after, before) = gap.split_at_mut(self.continued());
        if self.boundary == Boundary::Edge {
            after.fill(scene[self.len - 1]);
            before.fill(scene[0]);
            return;
        }
        let from_end = scene.iter().rev().chain(scene.iter()).cycle();
        after.iter_mut().zip(from_end).for_each(|(to, v)| *to = *v);
        let from_start = scene.iter().chain(scene.iter().rev()).cycle();
        before.iter_mut().rev().zip(from_start).for_each(|(to, v)| *to = *v);
    }

    /// How many places of the gap behind a scene continue its end. The others lead up to its start.
    fn continued(&self) -> usize {
        (self.total - self.len) / 2
    }

    /// The scene sample that stands at place `i` of the torus; `None` where it is dark.
    pub(super) fn source(&self, i: usize) -> Option<usize> {
        if (self.offset..self.offset + self.len).contains(&i) {
            return Some(i - self.offset);
        }
        // Only a scene without offset is continued.
        let beyond = i.saturating_sub(self.len);
        let before = self.total.saturating_sub(i + 1);
        let from_end = beyond < self.continued();
        match self.boundary {
            Boundary::Dark => None,
            Boundary::Edge => Some(if from_end { self.len - 1 } else { 0 }),
            Boundary::Mirror => {
                let at = if from_end { self.len + beyond } else { before };
                // A mirror on the border has the same at −1 − i as at i.
                Some(about_border(at as isize, self.len))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn dark_padding_is_that_of_isetcam() {
        let p = Padding::default();
        for (len, out, total) in [(128, 160, 160), (192, 240, 240), (513, 641, 648)] {
            let e = p.extent(len, 0);
            assert_eq!((e.out, e.total), (out, total));
            assert_eq!(e.source(e.offset), Some(0));
            assert_eq!((e.source(0), e.source(e.out)), (None, None));
        }
    }

    #[test]
    fn mirror_and_edge_go_on_from_both_ends() {
        let sources = |boundary| {
            let e = Extent { boundary, len: 3, offset: 0, out: 3, total: 12 };
            (0..12).map(|i| e.source(i).unwrap()).collect::<Vec<_>>()
        };
        assert_eq!(sources(Boundary::Edge), [0, 1, 2, 2, 2, 2, 2, 0, 0, 0, 0, 0]);
        assert_eq!(sources(Boundary::Mirror), [0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0]);
    }

    proptest! {
        #[test]
        fn every_place_of_the_torus_has_a_sample_of_the_scene_or_is_dark(
            len in 1usize..60, blur in 0usize..300, margin in 0.0..4.0f64, kind in 0..3
        ) {
            let boundary = [Boundary::Dark, Boundary::Edge, Boundary::Mirror][kind as usize];
            let e = Padding { boundary, margin }.extent(len, blur);
            assert!(e.out <= e.total && e.offset + e.len <= e.total);
            let mut line = vec![f32::NAN; e.total];
            (0..len).for_each(|s| line[e.offset + s] = 1.0 + s as f32);
            e.surround(&mut line);
            for (i, found) in line.into_iter().enumerate() {
                let inside = (e.offset..e.offset + len).contains(&i);
                prop_assert_eq!(found, e.source(i).map_or(0.0, |s| 1.0 + s as f32));
                match e.source(i) {
                    Some(s) if inside => assert_eq!(s, i - e.offset),
                    Some(s) => assert!(s < len && boundary != Boundary::Dark),
                    None => assert!(!inside && boundary == Boundary::Dark),
                }
            }
        }
    }

    #[test]
    fn a_wide_blur_widens_the_torus_but_not_the_image() {
        let e = Padding::default().extent(80, 50);
        assert_eq!((e.out, e.offset), (100, 10));
        assert!(e.total >= 80 + 10 + 50);
        let e = Padding { boundary: Boundary::Edge, margin: 0.0 }.extent(80, 50);
        assert!(e.out == 80 && e.total >= 180);
    }
}
