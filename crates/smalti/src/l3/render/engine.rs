//! Parallel rendering of bands of rows.

use rayon::prelude::*;

use super::super::classify::{Classifier, RowClasses};
use super::super::vectors::PIXELS;
use super::super::window::Window;
use super::super::{L3Error, MAX_SIDE, Pipeline};
use super::fixed::{Entry, FixedKernels};
use super::index::{Index, OutsideCounts};
use super::simd::Rendering;
use super::table::{Place, Run, Table};
use crate::isp::demosaic::{BAND_ROWS, bands};
use crate::isp::source::Source;
use crate::numeric::Planes;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::RawImage;

/// Columns that are processed together: their samples stay in the L1 cache through all steps.
const STRIP: usize = 512;

/// A pipeline with everything precomputed that does not depend on the image.
#[derive(Debug, Clone)]
pub(super) struct Engine<'a, S: Rendering> {
    pub(super) pipeline: &'a Pipeline,
    classifier: Classifier,
    index: Index,
    table: Table<S>,
}

/// Memory that a thread reuses.
#[derive(Debug, Default)]
struct Scratch<S> {
    window: Window,
    own: Window<S>,
    classes: RowClasses,
    kernels: Vec<u32>,
    patches: Vec<S>,
}

impl<'a> Engine<'a, f32> {
    pub(super) fn float(pipeline: &'a Pipeline) -> Self {
        let (kernels, [side, outputs]) = (pipeline.kernels(), shape(pipeline));
        let (table, places) = Table::new(&kernels.weights, |i| vec![kernels.offsets[i]], side, outputs, 1.0);
        Self::new(pipeline, table, places)
    }
}

impl<'a> Engine<'a, i16> {
    pub(super) fn fixed(pipeline: &'a Pipeline, kernels: &FixedKernels) -> Result<Self, L3Error> {
        let [side, outputs] = shape(pipeline);
        let offsets = |i: usize| FixedKernels::parts(kernels.offsets[i]).to_vec();
        let (table, places) = Table::new(&kernels.weights, offsets, side, outputs, kernels.scale);
        let entry = |(&place, &shift)| Entry::new(place, shift).map(|entry| entry.0);
        let entries = places.iter().zip(&kernels.shifts).map(entry).collect::<Option<_>>();
        let too_many = L3Error::NoFixedPoint("it has too many kernels");
        Ok(Self::new(pipeline, table, entries.ok_or(too_many)?))
    }
}

/// Side of the patch and number of outputs.
fn shape(pipeline: &Pipeline) -> [usize; 2] {
    [pipeline.axes().side(), pipeline.outputs().len()]
}

impl<'a, S: Rendering> Engine<'a, S> {
    fn new(pipeline: &'a Pipeline, table: Table<S>, kernels: Vec<u32>) -> Self {
        Self {
            pipeline,
            classifier: Classifier::new(pipeline.axes()),
            index: Index::new(pipeline, kernels),
            table,
        }
    }

    /// Renders an image into planes; the caller has checked both. `phase` is the position of the first pixel
    /// in the tile.
    pub(super) fn render(
        &self,
        raw: &RawImage,
        reader: &S::Reader<'_>,
        phase: [usize; 2],
        planes: &mut Planes,
    ) -> OutsideCounts {
        let (rows, cols) = (raw.rows(), raw.cols());
        let (source, mosaic) = (Source::of(raw), self.pipeline.axes().mosaic());
        bands(planes.data_mut(), rows, cols)
            .into_par_iter()
            .enumerate()
            .map_init(Scratch::default, |scratch, (i, mut band)| {
                let place = Place {
                    size: [rows, cols],
                    first: i * BAND_ROWS,
                    rows: BAND_ROWS.min(rows - i * BAND_ROWS),
                    half: self.pipeline.axes().side() / 2,
                    tile: [mosaic.rows(), mosaic.cols()],
                };
                self.band(source, reader, phase, &place, scratch, &mut band)
            })
            .reduce(OutsideCounts::default, |a, b| a + b)
    }

    fn band(
        &self,
        source: Source<'_>,
        reader: &S::Reader<'_>,
        phase: [usize; 2],
        place: &Place,
        scratch: &mut Scratch<S>,
        planes: &mut [&mut [f32]],
    ) -> OutsideCounts {
        let (cols, half, side) = (place.size[1], place.half, 2 * place.half + 1);
        let Scratch { window, own, classes, kernels, patches } = scratch;
        dispatch(Read { source, window, margin: self.classifier.margin(), place });
        let samples = S::window(reader, window, own, place);
        let mut outside = OutsideCounts::default();
        for row in 0..place.rows {
            let down = (phase[0] + place.first + row) % place.tile[0];
            for first in (0..cols).step_by(STRIP) {
                let count = STRIP.min(cols - first);
                self.classifier.row(window, row, [down, phase[1]], first..first + count, classes);
                kernels.resize(count.next_multiple_of(PIXELS), 0);
                let phase = [down, (phase[1] + first) % place.tile[1]];
                outside = outside + self.index.row(self.pipeline, classes, phase, count, kernels);
                let mut lines = [&[] as &[S]; MAX_SIDE];
                for (r, line) in lines[..side].iter_mut().enumerate() {
                    let from = samples.margin[1] - half + first;
                    *line = &samples.line((row + r) as isize - half as isize)[from..];
                }
                S::interleave(&lines[..side], kernels.len() + 2 * half, patches);
                let run = Run { table: &self.table, patches, kernels, at: row * cols + first, count };
                S::products(&run, planes);
            }
        }
        outside
    }
}

struct Read<'a> {
    source: Source<'a>,
    window: &'a mut Window,
    margin: [usize; 2],
    place: &'a Place,
}

impl Kernel for Read<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { source, window, margin, place } = self;
        window.read(source, place.first, place.rows, margin, place.tile);
    }
}
