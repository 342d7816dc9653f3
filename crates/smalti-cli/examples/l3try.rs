use smalti::camera::*;
use smalti::spectrum::*;
use std::time::Instant;
fn main() {
    let name = std::env::args().nth(1).unwrap_or("bayer".into());
    let camera = smalti_io::cameras::load(&name, &[], None).map_err(|e| e.to_string()).unwrap();
    let settings = TrainingSettings::default();
    let light = Illuminant::D65.photons(camera.grid()).unwrap();
    let mut s = camera.training_statistics(&settings, &light).unwrap();
    let t0 = Instant::now();
    for (i, ts) in training_scenes(&[Illuminant::D65]).iter().enumerate() {
        let t = Instant::now();
        let scene = ts.build(&camera).unwrap();
        let a = t.elapsed();
        camera.train_on(&mut s, &scene, &settings, i as u64).unwrap();
        eprintln!(
            "{} scene {:?} total {:?} patches {} classes {}",
            ts.spec,
            a,
            t.elapsed(),
            s.count(),
            s.classes().len()
        );
    }
    eprintln!("{:?}", t0.elapsed());
    let mut by: std::collections::BTreeMap<u32, (usize, u64)> = Default::default();
    for (k, m) in s.classes() {
        let e = by.entry(k.saturation).or_default();
        e.0 += 1;
        e.1 += m.count();
    }
    eprintln!("{by:?}");
    let mut by: std::collections::BTreeMap<(u16, u16), u64> = Default::default();
    for (k, m) in s.classes() {
        if k.position == 0 && k.saturation == 0 {
            *by.entry((k.level, k.texture)).or_default() += m.count();
        }
    }
    eprintln!("{by:?}\n{:?}", s.axes().levels_at(0));
}
