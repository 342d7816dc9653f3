//! What a camera sees beyond the wavelengths of its simulation.

use std::collections::BTreeMap;

use smalti::camera::description::PatternDescription;
use smalti::camera::{Camera, CameraError};
use smalti::sensor::{Filter, cfa};
use smalti::spectrum::{Spectrum, WavelengthGrid};

/// The share of its largest value from which on a channel counts as sensitive.
const SENSITIVE: f64 = 0.1;
/// Where the sensitivity of silicon ends, nm.
const LAST_NM: f64 = 1100.0;

/// What a channel sees beyond the wavelengths of the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Infrared {
    /// Little, compared with its maximum.
    Blocked,
    /// Much, by the curves that are stated.
    Seen {
        /// Where it responds most.
        nm: f64,
        /// Its response there, percent of its maximum, which may lie there too.
        percent: f64,
    },
    /// Some of its curves are not stated there, and the others do not block it.
    Unknown,
}

/// The curves of a camera beyond the wavelengths of its simulation, as they are stated there.
pub(super) struct Beyond {
    /// `None` where the simulation ends with the sensitivity of silicon.
    grid: Option<WavelengthGrid>,
    /// Quantum efficiency, lens and infrared-cut filter.
    common: Vec<Option<Spectrum>>,
    filters: BTreeMap<String, Spectrum>,
}

impl Beyond {
    pub(super) fn new(camera: &Camera) -> Result<Self, CameraError> {
        let (own, description) = (camera.grid(), camera.description());
        let (start, step) = (own.end_nm() + own.step_nm(), own.step_nm());
        let count = ((LAST_NM - start) / step).floor() + 1.0;
        if count < 1.0 {
            return Ok(Self { grid: None, common: Vec::new(), filters: BTreeMap::new() });
        }
        let grid = WavelengthGrid::new(start, step, count as usize)?;
        // A table that ends before does not state what follows.
        let stated = |filter: &Filter| filter.spectrum(grid).ok();
        let optics = &description.optics;
        let common = [&description.sensor.quantum_efficiency, &optics.transmittance];
        let array = &description.sensor.cfa;
        let mut filters = BTreeMap::new();
        if let PatternDescription::Name(name) = &array.pattern {
            for (letter, name) in cfa::default_filters(name).map_err(CameraError::from)? {
                filters.extend(stated(&Filter::Builtin(name)).map(|s| (letter.to_string(), s)));
            }
        }
        for (letter, filter) in &array.filters {
            filters.remove(letter);
            filters.extend(stated(filter).map(|s| (letter.clone(), s)));
        }
        Ok(Self {
            grid: Some(grid),
            common: common.into_iter().chain(&optics.ir_cut).map(stated).collect(),
            filters,
        })
    }

    /// What a channel sees whose response within the simulation is `own`.
    pub(super) fn response(&self, channel: &str, own: &Spectrum) -> Infrared {
        let Some(grid) = self.grid else { return Infrared::Blocked };
        let curves = || self.common.iter().map(Option::as_ref).chain([self.filters.get(channel)]);
        // Curves that are not stated may transmit everything.
        let most = |i: usize| {
            curves().flatten().map(|c| c.values().get(i).copied().unwrap_or(1.0)).product::<f64>().max(0.0)
        };
        let (nm, most) = grid
            .wavelengths_nm()
            .enumerate()
            .map(|(i, nm)| (nm, most(i)))
            .fold((grid.start_nm(), 0.0), |best, found| if found.1 > best.1 { found } else { best });
        if most <= SENSITIVE * own.max() {
            Infrared::Blocked
        } else if curves().all(|c| c.is_some()) {
            Infrared::Seen { nm, percent: 100.0 * most / own.max().max(most) }
        } else {
            Infrared::Unknown
        }
    }
}
