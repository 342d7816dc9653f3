//! Bad input: exit code 1, a message that names what is wrong, and nothing left behind.

use smalti_io::npy;

use crate::Place;

/// Runs what must fail; the message must hold every word and name no cause twice.
fn fails(place: &Place, args: &[&str], words: &[&str]) {
    let run = place.run(args);
    assert_eq!((run.code, run.out.as_str()), (1, ""), "{args:?}: {}", run.err);
    assert!(run.err.starts_with("error: "), "{args:?}: {}", run.err);
    for word in words {
        assert!(run.err.contains(word), "{args:?}: no {word} in: {}", run.err);
    }
    assert!(run.err.matches("os error").count() <= 1, "{}", run.err);
    // Names of Rust types are no help.
    for type_name in ["f64", "usize", "u32", "struct", "Some(", "Err("] {
        assert!(!run.err.contains(type_name), "{args:?}: {}", run.err);
    }
    assert!(place.names("out").is_empty(), "{args:?} left {:?}", place.names("out"));
}

fn scene(place: &Place, name: &str, words: &[&str]) {
    fails(place, &["simulate", "bayer", "--scene", name, "-o", "out"], words);
}

fn set(place: &Place, overrides: &[&str], words: &[&str]) {
    let mut args = vec!["simulate", "bayer", "--scene", "uniform?size=8", "-o", "out"];
    overrides.iter().for_each(|o| args.extend(["--set", o]));
    fails(place, &args, words);
}

fn camera(place: &Place, toml: &str, words: &[&str]) {
    place.write("camera.toml", toml);
    fails(place, &["simulate", "camera.toml", "--scene", "uniform?size=8", "-o", "out"], words);
}

#[test]
fn pictures_and_spectra_that_are_broken() {
    let place = Place::new();
    for name in ["a.exr", "a.png", "a.tif", "a.npy"] {
        place.ok(&format!("convert macbeth?patch=8 -o {name}"));
    }
    for extension in ["exr", "png", "tif"] {
        let whole = place.read(&format!("a.{extension}"));
        for (name, content) in [
            ("cut", &whole[..whole.len() * 2 / 3]),
            ("head", &whole[..20]),
            ("empty", &[]),
            ("other", &place.read("a.npy")),
        ] {
            let name = format!("{name}.{extension}");
            place.write(&name, content);
            scene(&place, &name, &[&name]);
        }
        // A picture under another name is known by its content, but for spectra: there the name decides.
        let mut flipped = whole.clone();
        (8..whole.len().min(64)).for_each(|i| flipped[i] ^= 0xff);
        let name = format!("flipped.{extension}");
        place.write(&name, flipped);
        scene(&place, &name, &[&name]);
    }
    place.write("picture.exr", place.read("a.png"));
    scene(&place, "picture.exr", &["picture.exr", "not a valid OpenEXR file"]);
    place.write("spectrum.png", place.read("a.exr"));
    scene(&place, "spectrum.png", &["spectrum.png", "expected an RGB or grey picture"]);
    // Dimensions of two thousand million in the header of a few bytes.
    let mut huge = place.read("a.png");
    huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    place.write("huge.png", huge);
    scene(&place, "huge.png", &["huge.png"]);
    scene(&place, "a.npy", &["a.npy", "the wavelengths is not stated: a single array"]);
    scene(&place, "absent.exr", &["cannot read absent.exr"]);
    std::fs::create_dir(place.path("folder.png")).unwrap();
    scene(&place, "folder.png", &["cannot read folder.png"]);
}

#[test]
fn radiance_that_is_none() {
    use smalti_io::exr::{self, Layout};
    use smalti_io::{ReadOptions, scene_file};
    let place = Place::new();
    place.ok("convert macbeth?patch=4 -o good.exr --layout pbrt");
    // The third value of a band, found by its bytes: the writer itself refuses such values.
    let good = scene_file::read_spectral(&place.path("good.exr"), &ReadOptions::default()).unwrap().unwrap();
    for (name, value, words) in [
        ("nan.exr", f32::NAN, "NaN; expected a finite number"),
        ("infinite.exr", f32::INFINITY, "inf; expected a finite number"),
        ("negative.exr", -1.0, "-1; expected a finite number, not negative"),
    ] {
        write_rgbless_exr(&place.path(name), value);
        scene(&place, name, &[name, "Radiance.C04, row 2, column 5", words]);
    }
    let mut black = good;
    let grid = black.cube.grid();
    let planes = smalti::numeric::Planes::zeros(8, 8, grid.len());
    black.cube = smalti::spectrum::SpectralCube::new(grid, planes).unwrap();
    black.quantity = smalti_io::Quantity::RelativeEnergy;
    exr::write(&place.path("black.exr"), &black, Layout::Pbrt).unwrap();
    scene(&place, "black.exr", &["black.exr: the mean luminance is 0"]);
}

/// An uncompressed OpenEXR of 8 × 8 × 31 ones with one value of its fourth channel replaced, written here byte by byte
/// as in the OpenEXR file layout document: the writers of this project refuse to.
fn write_rgbless_exr(path: &std::path::Path, value: f32) {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, bytes: &[u8]| {
        for text in [name, kind] {
            file.extend(text.bytes());
            file.push(0);
        }
        file.extend((bytes.len() as i32).to_le_bytes());
        file.extend(bytes);
    };
    let mut channels = Vec::new();
    for band in 1..=31 {
        channels.extend(format!("Radiance.C{band:02}").bytes());
        channels.push(0);
        // Float, linear flag and reserved, sampling 1 × 1.
        for v in [2i32, 0, 1, 1] {
            channels.extend(v.to_le_bytes());
        }
    }
    channels.push(0);
    let window: Vec<u8> = [0i32, 0, 7, 7].iter().flat_map(|v| v.to_le_bytes()).collect();
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    file.push(0);
    let line_bytes = 31 * 8 * 4;
    let first = file.len() + 8 * 8;
    (0..8).for_each(|row| file.extend(((first + row * (8 + line_bytes)) as u64).to_le_bytes()));
    for row in 0..8i32 {
        file.extend(row.to_le_bytes());
        file.extend((line_bytes as i32).to_le_bytes());
        for (band, col) in (0..31).flat_map(|band| (0..8).map(move |col| (band, col))) {
            let v = if (band, row, col) == (3, 2, 5) { value } else { 1.0 };
            file.extend(v.to_le_bytes());
        }
    }
    std::fs::write(path, file).unwrap();
}

#[test]
fn filters_that_do_not_fit() {
    let place = Place::new();
    let toml = "name = \"c\"\n[sensor.cfa]\npattern = [\"RG\", \"GB\"]\n[sensor.cfa.filters]\nR = { file = \"f.csv\" }\n\
                G = { flat = 0.5 }\nB = { flat = 0.2 }\n";
    place.write("f.csv", "400,0.1\n700,0.9\n");
    place.write("camera.toml", toml);
    place.ok("simulate camera.toml --scene uniform?size=8 -o good --set sensor.rows=30 --set sensor.cols=40");
    for (csv, words) in [
        ("500,0.1\n510,0.9\n600,0.8\n", "the data cover 500–600 nm, but 400–700 nm are needed"),
        ("400,0.1\n550,abc\n700,0.9\n", "f.csv: line 2: found 'abc'; expected a finite number"),
        ("400,0.1\n390,0.9\n", "f.csv: line 2: found wavelength 390 after 400; expected ascending"),
        ("", "f.csv: the file is empty; expected lines wavelength_nm,value"),
        (
            "400,2\n700,2\n",
            "f.csv: line 1: found 2 in column '1'; expected a transmittance from 0 to 1, or percent",
        ),
        ("400,-1\n700,0\n", "-1 at 400 nm; expected 0 to 1"),
        ("400,nan\n700,0\n", "line 1: found 'nan'; expected a finite number"),
        ("400\n700\n", "line 1: found one column"),
        ("400,0,1\n700,0,1\n", "expected f.csv#1 or f.csv#2"),
        ("400,0.1\n700", "line 2"),
    ] {
        place.write("f.csv", csv);
        camera(&place, toml, &["camera.toml:5:5", "sensor.cfa.filters.R", "R = { file = \"f.csv\" }", words]);
    }
    place.write("f.csv", [0x34, 0xff, 0xfe]);
    camera(&place, toml, &["camera.toml:5", "f.csv", "not UTF-8"]);
    std::fs::remove_file(place.path("f.csv")).unwrap();
    camera(&place, toml, &["camera.toml:5", "cannot read f.csv"]);
    set(
        &place,
        &["sensor.cfa.filters.R={file=\"no.csv\"}"],
        &["--set sensor.cfa.filters.R", "cannot read no.csv"],
    );
    set(&place, &["sensor.cfa.filters.R={builtin=\"nikon-d5100/Q\"}"], &["did you mean 'nikon-d5100/"]);
    set(&place, &["sensor.cfa.filters.R={gauss={center_nm=5}}"], &["unknown value `gauss`", "`gaussian`"]);
    set(
        &place,
        &["sensor.quantum_efficiency=silicon"],
        &["unknown value `silicon`", "{ builtin = \"silicon\" }"],
    );
    set(&place, &["sensor.cfa.filters.R={gaussian={center_nm=500}}"], &["missing key `sigma_nm`"]);
    set(&place, &["sensor.cfa.filters.R={flat=2}"], &["`sensor.cfa.filters.R`", "2; expected 0 to 1"]);
    set(
        &place,
        &["sensor.cfa.filters.Q={flat=0.5}"],
        &["--set sensor.cfa.filters.Q", "letter of this CFA", "'Q'"],
    );
}

#[test]
fn cameras_that_cannot_be() {
    let place = Place::new();
    for (toml, words) in [
        (
            "[sensor.pixel]\nfill_factor = 1.5\n",
            ["camera.toml:2:15", "`sensor.pixel.fill_factor`", "expected 0.000001 to 1"],
        ),
        (
            "[sensor.pixel]\nfill_factor = 0\n",
            ["camera.toml:2:15", "`sensor.pixel.fill_factor`", "0 is out of range"],
        ),
        (
            "[sensor.pixel]\nvoltage_swing_v = 0\n",
            ["camera.toml:2:19", "voltage_swing_v", "0 is out of range"],
        ),
        ("[sensor.pixel]\nread_noise_mv = -1\n", ["camera.toml:2:17", "read_noise_mv", "-1 is out of range"]),
        ("[sensor.pixel]\npitch_um = inf\n", ["camera.toml:2:12", "pitch_um", "inf is out of range"]),
        ("[sensor.pixel]\npitch_um = nan\n", ["camera.toml:2:12", "pitch_um", "NaN is out of range"]),
        (
            "[sensor]\nadc_bits = 17\n",
            ["camera.toml:2:12", "adc_bits", "17 is out of range; expected 0 to 16"],
        ),
        ("[sensor]\nadc_bits = -1\n", ["camera.toml:2:12", "adc_bits", "expected a whole number"]),
        (
            "[sensor]\nrows = 10000000\n",
            ["camera.toml:2:8", "`sensor.rows`", "exceed the limit of 536870912 samples"],
        ),
        ("[sensor]\ncols = 0\n", ["camera.toml:2:8", "`sensor.cols`", "at least one row and one column"]),
        ("[sensor]\nrows = \"many\"\n", ["camera.toml:2:8", "rows = \"many\"", "expected a whole number"]),
        ("[optics]\nf_number = \"wide\"\n", ["camera.toml:2:12", "f_number", "expected a number"]),
        ("sensor = 3\n", ["camera.toml:1:10", "sensor = 3", "expected a table"]),
        (
            "name = \"x\"\n[sensor.pixel]\npich_um = 2\n",
            ["camera.toml:3:1", "unknown key `pich_um`", "did you mean `pitch_um`?"],
        ),
        ("[optic]\n", ["camera.toml:1", "unknown key `optic`", "did you mean `optics`?"]),
        (
            "[exposure]\ntime_ms = 1\nauto = \"mean\"\n",
            ["camera.toml:3:8", "`exposure.auto`", "either time_ms or auto"],
        ),
        ("[exposure]\nauto = \"spekular\"\n", ["camera.toml:2:8", "spekular", "did you mean `specular`?"]),
        (
            "[optics]\nzernike_um = { 4 = 0.1 }\n",
            ["camera.toml:2:14", "`optics.zernike_um`", "need model = \"zernike\""],
        ),
        (
            "[optics]\nmodel = \"zernike\"\nzernike_um = { x = 1 }\n",
            ["camera.toml:3:20", "zernike_um.x", "number of a Zernike mode"],
        ),
        ("[optics]\nmodel = \"psf\"\n", ["camera.toml", "`optics.psf`", "needs a table [optics.psf]"]),
        (
            "[sensor.cfa]\npattern = \"bayr\"\n",
            ["camera.toml:2:11", "no built-in CFA is called 'bayr'", "did you mean 'bayer'?"],
        ),
        (
            "[sensor.cfa]\npattern = 3\n",
            ["camera.toml:2:11", "pattern = 3", "the name of a CFA, or its lines"],
        ),
        (
            "[sensor.cfa]\npattern = []\n",
            ["camera.toml:2:11", "`sensor.cfa.pattern`", "rectangle of 1 to 65536 cells"],
        ),
        (
            "[sensor.cfa]\npattern = [\"RG\"]\n",
            ["camera.toml:2:11", "'R' at row 0, column 0", "filters: none"],
        ),
        ("[optics\n", ["camera.toml:1:8", "[optics", "expected `]`"]),
        ("name = \"a\"\nname = \"b\"\n", ["camera.toml:2:1", "name", "duplicate key"]),
    ] {
        camera(&place, toml, &words);
    }
    let filters = "filters = { R = { flat = 1 }, G = { flat = 1 }, B = { flat = 1 } }\n";
    for (pattern, words) in [
        (
            "[\"RG\", \"ZB\"]",
            "'Z' at row 1, column 0 (counted from 0), but no filter has that name (filters: B, G, R); add one or change the pattern",
        ),
        ("[\"RG\", \"B\"]", "a mosaic tile is a rectangle"),
        ("[\"\"]", "a mosaic tile is a rectangle"),
    ] {
        camera(
            &place,
            &format!("[sensor.cfa]\npattern = {pattern}\n{filters}"),
            &["camera.toml:2:11", words],
        );
    }
    place.write("camera.toml", [b'a', b'\n', 0xff]);
    fails(&place, &["simulate", "camera.toml"], &["camera.toml: line 2 is not UTF-8"]);
    fails(&place, &["simulate", "absent.toml"], &["cannot read absent.toml"]);
    fails(&place, &["simulate", "bayr"], &["bayr: no such camera", "did you mean 'bayer'?", "built in:"]);
}

#[test]
fn overrides_that_do_not_fit_are_shown_as_typed() {
    let place = Place::new();
    set(
        &place,
        &["sensor.pixel.fill_factor=1.5"],
        &["--set sensor.pixel.fill_factor=1.5:", "expected 0.000001 to 1"],
    );
    set(
        &place,
        &["sensor.rows=10000000", "sensor.cols=10000"],
        &["--set sensor.rows=10000000:", "10000000 × 10000"],
    );
    set(&place, &["sensr.rows=1"], &["--set sensr.rows=1:", "did you mean `sensor`?"]);
    set(
        &place,
        &["sensor.pixel.pich_um=1", "name=x"],
        &["--set sensor.pixel.pich_um=1:", "did you mean `pitch_um`?"],
    );
    set(&place, &["sensor.pixel=1"], &["--set sensor.pixel=1:", "expected a table"]);
    set(
        &place,
        &["sensor.pixel.pitch_um=big"],
        &["--set sensor.pixel.pitch_um=big:", "found string \"big\"; expected a number"],
    );
    set(&place, &["sensor.adc_bits=12.5"], &["12.5", "expected a whole number"]);
    set(&place, &["optics.zernike_um.4=1"], &["--set optics.zernike_um.4=1:", "need model = \"zernike\""]);
    set(&place, &["sensor.cfa.pattern=[\"RG\""], &["no built-in CFA is called '[\"RG\"'"]);
    set(
        &place,
        &["isp.demosaic=malvar2004", "sensor.cfa.pattern=rgbw"],
        &["malvar2004 is defined for Bayer", "bilinear takes any"],
    );
}

#[test]
fn point_spreads_that_do_not_fit() {
    let place = Place::new();
    let psf = |file: &str, words: &[&str]| {
        let file = format!("optics.psf.file={file}");
        set(&place, &["optics.model=psf", &file, "optics.psf.spacing_um=1"], words);
    };
    psf("no.npy", &["--set optics.psf.file=no.npy:", "cannot read no.npy"]);
    place.write("text.npy", "hello");
    psf("text.npy", &["`optics.psf.file`", "text.npy: expected a NumPy .npy file"]);
    npy::write(&place.path("line.npy"), &[9], &[1f32; 9]).unwrap();
    psf("line.npy", &["`optics.psf.file`", "expected 2 or 3 dimensions, got 1"]);
    npy::write(&place.path("zero.npy"), &[3, 3], &[0f32; 9]).unwrap();
    psf("zero.npy", &["`optics.psf.file`"]);
    npy::write(&place.path("nan.npy"), &[3, 3], &[f32::NAN; 9]).unwrap();
    psf("nan.npy", &["`optics.psf.file`"]);
    npy::write(&place.path("few.npy"), &[2, 3, 3], &[1f32; 18]).unwrap();
    psf("few.npy", &["nm"]);
    let whole = std::fs::read(place.path("line.npy")).unwrap();
    place.write("cut.npy", &whole[..whole.len() - 4]);
    psf("cut.npy", &["cut.npy"]);
    set(&place, &["optics.model=psf", "optics.psf.file=no.npy"], &["missing key `spacing_um`"]);
}

#[test]
fn scenes_and_settings_that_cannot_be() {
    let place = Place::new();
    for (name, words) in [
        ("zone-plat", "did you mean 'zone-plate'?"),
        ("zone-plate?freq=0.1", "no parameter 'freq'; did you mean 'frequency'?"),
        ("zone-plate?frequency=abc", "expected a number from"),
        (
            "zone-plate?frequency=100",
            "frequency=100 for the scene 'zone-plate'; expected a number from 1e-3 to 2",
        ),
        ("zone-plate?frequency", "frequency"),
        ("uniform?size=100000", "size=100000"),
        ("", "there is no scene named ''"),
    ] {
        scene(&place, name, &[words]);
    }
    for (option, value, words) in [
        ("--luminance", "nan", "luminance_cd_m2 is NaN; expected 1e-6 to 1e12"),
        ("--luminance", "0", "luminance_cd_m2 is 0; expected 1e-6 to 1e12"),
        ("--luminance", "1e-30", "luminance_cd_m2 is 1e-30; expected 1e-6 to 1e12"),
        ("--fov", "190", "horizontal_fov_deg is 190; expected 1e-6 to 170"),
        ("--fov", "179.9999", "horizontal_fov_deg is 179.9999; expected 1e-6 to 170"),
        ("--distance", "0", "distance_m is 0; expected 1e-6 to 1e12"),
        ("--distance", "1e308", "distance_m is 1e308; expected 1e-6 to 1e12"),
        ("--wavelengths", "400:10:400", "expected an end above the start"),
        ("--distance", "0.001", "0.001 m from the lens; expected more than the focal length of 0.003863 m"),
        ("--illuminant", "D66", "did you mean 'D65'?"),
        ("--illuminant", "D:100", "100"),
    ] {
        fails(
            &place,
            &["simulate", "bayer", option, value, "--scene", "uniform?size=8", "-o", "out"],
            &[words],
        );
    }
}

/// What cannot be measured is refused, and the message blames the key that is wrong, in few digits.
#[test]
fn nonsense_is_refused_by_its_own_key() {
    let place = Place::new();
    for (words, expected) in [
        ("evaluate bayer --luminance 1e-30", "luminance_cd_m2 is 1e-30; expected 1e-6 to 1e12"),
        ("evaluate bayer --luminance 1e308", "bayer at 1e308 cd/m²"),
        ("evaluate bayer --set sensor.rows=1e308", "found floating point `1e308`; expected a whole number"),
        (
            "evaluate bayer --set sensor.pixel.full_well_e=1",
            "full_well_e is 1; expected as many electrons as give",
        ),
        (
            "evaluate bayer --set optics.f_number=1e-300",
            "`optics.f_number`: 1e-300 is out of range; expected 0.5",
        ),
        ("evaluate bayer --set sensor.dsnu_e=1e6", "`sensor.dsnu_e`: 1000000 electrons are too many"),
    ] {
        fails(&place, &words.split(' ').collect::<Vec<_>>(), &[expected]);
    }
    // Also where another rule or a fixed time makes the key idle.
    for set in ["auto_target=nan", "auto_percentile=-1", "auto_percentile=nan", "auto_percentile=200"] {
        let key = format!("exposure.{}", set.split('=').next().unwrap());
        for idle in ["exposure.time_ms=10", "exposure.auto=mean"] {
            self::set(&place, &[idle, &format!("exposure.{set}")], &[&format!("`{key}`"), "is out of range"]);
        }
    }
    // An array without rows is no image.
    place.write("empty.npz", without_rows());
    fails(
        &place,
        &["convert", "empty.npz", "-o", "a.exr"],
        &["empty.npz: the image is of 0 rows and 4 columns; expected at least one row and one column"],
    );
}

/// An archive of NumPy with a cube of 0 × 4 × 2 samples and its wavelengths.
fn without_rows() -> Vec<u8> {
    let place = Place::new();
    npy::write::<f32>(&place.path("cube.npy"), &[2, 0, 4], &[]).unwrap();
    npy::write(&place.path("nm.npy"), &[2], &[400.0, 500.0]).unwrap();
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, file) in [("cube.npy", "cube.npy"), ("wavelengths_nm.npy", "nm.npy")] {
        let content = place.read(file);
        let (offset, len) = (out.len() as u32, content.len() as u32);
        // PKWARE's APPNOTE 4.3.7 and 4.3.12: stored, without flags.
        let mut common = [20u16, 0, 0, 0, 0].map(u16::to_le_bytes).concat();
        common.extend(crc32(&content).to_le_bytes());
        common.extend([len, len].map(u32::to_le_bytes).concat());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend(0u16.to_le_bytes());
        out.extend([b"PK\x03\x04", common.as_slice(), name.as_bytes(), &content].concat());
        directory.extend([b"PK\x01\x02\x14\0", common.as_slice(), &[0; 10]].concat());
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (at, len) = (out.len() as u32, directory.len() as u32);
    out.extend([directory.as_slice(), b"PK\x05\x06\0\0\0\0\x02\0\x02\0"].concat());
    out.extend([len, at].map(u32::to_le_bytes).concat());
    out.extend(0u16.to_le_bytes());
    out
}

/// CRC-32 of ISO 3309.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |s, _| if s & 1 == 1 { s >> 1 ^ 0xedb8_8320 } else { s >> 1 })
    })
}

#[test]
fn numbers_that_are_none_and_files_of_another_kind() {
    let place = Place::new();
    for command in ["simulate", "evaluate", "compare"] {
        let run = place.run(&[command, "bayer", "--luminance", "abc"]);
        assert!(
            run.code == 2 && run.err.contains("'abc' for '--luminance <CD_M2>': expected a number"),
            "{}",
            run.err
        );
    }
    place.write(
        "study.toml",
        "camera = \"bayer\"\ncolors = [3]\nfilters = { gaussian_grid = {} }\nmosaics = \"catalogue\"\n",
    );
    fails(
        &place,
        &["evaluate", "study.toml"],
        &["study.toml:1:1", "this is the file of a study: smalti sweep"],
    );
}

#[test]
fn folders_that_cannot_be_written() {
    let place = Place::new();
    place.write("file", "kept");
    let simulate = |out: &str, words: &[&str]| {
        fails(
            &place,
            &["simulate", "bayer", "--scene", "uniform?size=8", "--set", "sensor.rows=30", "-o", out],
            words,
        );
    };
    simulate("file", &["file: it is a file; expected a folder"]);
    simulate("file/in", &["cannot write file/in"]);
    assert_eq!(place.read("file"), b"kept");
    // A folder in the place of a result: what was written before stays whole, and no metrics.json claims the rest.
    std::fs::create_dir_all(place.path("half/raw.dng")).unwrap();
    place.write("half/metrics.json", "of an earlier run");
    simulate("half", &["cannot write half/raw.dng"]);
    assert_eq!(place.names("half"), ["raw.dng", "rendered.png"]);
    #[cfg(target_os = "linux")]
    simulate("/proc/out", &["cannot write /proc/out"]);
}

/// The largest sensor that can be counted takes 60 GiB to photograph with: an error on most machines.
#[test]
fn a_sensor_larger_than_memory() {
    let place = Place::new();
    if smalti_io::memory::available_bytes().is_none_or(|bytes| bytes > 55 << 30) {
        eprintln!("skipped: memory of unknown size, or enough");
        return;
    }
    let large = ["--full-frame", "--set", "sensor.rows=23000", "--set", "sensor.cols=23000"];
    let args: Vec<&str> =
        ["simulate", "bayer", "--scene", "uniform?size=8", "-o", "out"].into_iter().chain(large).collect();
    fails(&place, &args, &["`sensor.rows` × `sensor.cols`", "23000 × 23000 pixels", "MiB of memory"]);
}

#[test]
fn tables_that_do_not_go_with_the_cameras() {
    let place = Place::new();
    let one = ["compare", "bayer", "rgbw", "--pipeline", "one.l3", "-o", "out"];
    fails(&place, &one, &["--pipeline", "1 given for 2 cameras", "--pipeline FILE.l3 --pipeline FILE.l3"]);
    place.write("broken.l3", "no table");
    fails(&place, &["compare", "bayer", "--pipeline", "broken.l3", "-o", "out"], &["broken.l3"]);
}

/// A black picture is no scene, rather than a white one: its darkest reflectance is above 0, and a mean luminance would scale it.
#[test]
fn a_black_picture_is_no_scene() {
    use smalti::color::{ColorSpace, Image};
    use smalti_io::picture::{Depth, write_png};
    let place = Place::new();
    let of = |value: f32| {
        let planes = smalti::numeric::Planes::new(40, 60, 3, vec![value; 40 * 60 * 3]).unwrap();
        Image::new(ColorSpace::Srgb, planes).unwrap()
    };
    write_png(&place.path("black.png"), &of(0.0), Depth::Eight).unwrap();
    write_png(&place.path("dark.png"), &of(1.0 / 255.0), Depth::Eight).unwrap();
    for words in [
        "compare bayer rgbw --scene black.png --luminance 10 --seeds 1 --processing bilinear -o out",
        "simulate bayer --scene black.png -o out",
        "show black.png -o out/black.png",
        "convert black.png -o out/black.exr",
    ] {
        let args: Vec<&str> = words.split(' ').collect();
        fails(&place, &args, &["black.png: every pixel of the picture is 0", "a scene without light"]);
    }
    // The darkest grey is light.
    place.ok("simulate bayer --scene dark.png -o dark");
}

/// Comparisons that no exposure time or illuminant makes possible say what would.
#[test]
fn a_comparison_without_light_says_what_to_change() {
    let place = Place::new();
    place.write("line.csv", "400,0\n570,0\n580,1\n590,1\n600,0\n700,0\n");
    let small = "--scene dead-leaves?rows=32&cols=32 --luminance 5 -o o";
    let coarse = "--set wavelengths_nm=[400,50,700]";
    for (words, expected) in [
        (
            format!(
                "compare phone table1 --exposure equal --set exposure.analog_offset_mv=1900 --processing bilinear {small}"
            ),
            "below the voltage swing and the full well (keys exposure.analog_offset_mv, sensor.pixel.voltage_swing_v, sensor.pixel.full_well_e)",
        ),
        (
            format!("compare bayer rgbw --illuminant line.csv {coarse} {small}"),
            "with power at the wavelengths of the channel",
        ),
        (
            format!("compare bayer rgbw --illuminant line.csv --processing bilinear {small}"),
            "choose a broader illuminant",
        ),
    ] {
        fails(&place, &words.split_whitespace().collect::<Vec<_>>(), &[expected]);
        assert!(!place.path("o/results.json").exists());
    }
}

/// The option that the error states is one with which the command succeeds.
#[test]
fn a_scene_without_the_infrared_that_a_camera_sees() {
    let place = Place::new();
    let words = ["simulate", "rgbx", "--scene", "photo-fig", "-o", "out"];
    fails(&place, &words, &["400–830 nm are needed", "--wavelengths 400:10:700 leaves it out"]);
    place.ok("simulate rgbx --scene photo-fig --wavelengths 400:10:700 -o out -q");
}

/// Scores of colours that cannot be measured are not printed.
#[test]
fn a_channel_without_light_and_a_light_without_blue() {
    let place = Place::new();
    place.write("red.csv", "400,0\n590,0\n600,1\n700,1\n");
    let compare = ["compare", "bayer", "--processing", "bilinear", "--luminance", "80", "-o", "out"];
    let leaves = ["--scene", "dead-leaves?rows=48&cols=48&largest=30"];
    let blind = ["--set", "sensor.cfa.filters.B={flat=0}"];
    let channel = ["bayer under D65", "the channel B gets no light", "sensor.cfa.filters.B"];
    fails(&place, &[&compare[..], &leaves, &blind].concat(), &channel);
    fails(&place, &[&["evaluate", "bayer", "-o", "out"][..], &blind].concat(), &channel);
    // A picture needs no colour, and three other channels suffice for scores; it is told all the same.
    let told = "the channel B sees almost nothing of the illuminant: its response to white is 0.00 %";
    for words in [
        &["simulate", "bayer", "--scene", "macbeth?patch=8", "-o", "picture"][..],
        &["evaluate", "rgbw", "--luminance", "80"],
        &["show", "rgbw"],
    ] {
        let run = place.run(&[words, &blind].concat());
        assert!(
            run.code == 0 && (run.err.contains(told) || run.out.contains(told)),
            "{words:?}: {}",
            run.err
        );
    }
    let lamps = ["simulate", "bayer", "--scene", "natural-street", "--illuminant", "A", "-o", "out"];
    fails(&place, &lamps, &["natural-street: the scene keeps its own light", "expected no illuminant"]);
    for words in [&["evaluate", "rgbw", "-o", "out"][..], &["compare", "rgbw", "-o", "out"]] {
        let scene = if words[0] == "compare" { &leaves[..] } else { &[] };
        let light = ["rgbw under", "red", "choose "];
        fails(&place, &[words, scene, &["--illuminant", "red.csv"]].concat(), &light);
    }
}
