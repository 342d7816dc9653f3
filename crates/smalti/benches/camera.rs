//! One design: sensor, processing and metrics on all three targets, with and without making the optical images.
#![allow(missing_docs)]

use std::collections::HashMap;
use std::hint::black_box;
use std::sync::Mutex;

use criterion::{Criterion, criterion_group, criterion_main};
use smalti::camera::{Camera, CameraDescription, EvaluationSettings, evaluate};
use smalti::optics::OpticalImage;
use smalti::spectrum::WavelengthGrid;

fn benches(c: &mut Criterion) {
    let Ok(camera) = Camera::new(CameraDescription::default(), WavelengthGrid::VISIBLE) else { return };
    let settings = EvaluationSettings::default();
    let mut group = c.benchmark_group("evaluate");
    group.sample_size(20);
    group.bench_function("optics made anew", |b| {
        b.iter(|| black_box(evaluate(&camera, &settings, &|_, make| make())));
    });
    let kept: Mutex<HashMap<String, OpticalImage>> = Mutex::default();
    group.bench_function("optics kept", |b| {
        b.iter(|| {
            let images = |key: &str, make: &dyn Fn() -> _| {
                let found = kept.lock().ok().and_then(|k| k.get(key).cloned());
                if let Some(image) = found {
                    return Ok(image);
                }
                let image: OpticalImage = make()?;
                if let Ok(mut kept) = kept.lock() {
                    kept.insert(key.to_owned(), image.clone());
                }
                Ok(image)
            };
            black_box(evaluate(&camera, &settings, &images))
        });
    });
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
