//! Names of cameras, scenes and keys in tables and as names of files.

use smalti::camera::Camera;
pub use smalti::experiment::numbered;

/// The largest number of characters of a name in the name of a file.
const MAX_CHARS: usize = 100;

/// The unit that the end of a key states. Longer ends come first.
const UNITS: [(&str, &str); 20] = [
    ("_uv_per_e", "µV/e⁻"),
    ("_v_per_s", "V/s"),
    ("_e_per_s", "e⁻/s"),
    ("_dioptres_per_um", "dioptres/µm"),
    ("_dioptres", "dioptres"),
    ("_cd_m2", "cd/m²"),
    ("_percent", "%"),
    ("_ppm", "10⁻⁶"),
    ("_bits", "bit"),
    ("_dn", "DN"),
    ("_um", "µm"),
    ("_mm", "mm"),
    ("_nm", "nm"),
    ("_mv", "mV"),
    ("_ms", "ms"),
    ("_c", "°C"),
    ("_v", "V"),
    ("_e", "e⁻"),
    ("rows", "pixels"),
    ("cols", "pixels"),
];

/// Words of keys that are abbreviations.
const ABBREVIATIONS: [&str; 8] = ["adc", "cfa", "dsnu", "ir", "isp", "prnu", "qe", "l3"];

/// The unit that the end of a key states. Empty for other keys.
#[must_use]
pub fn unit(key: &str) -> &'static str {
    UNITS.iter().find(|(end, _)| key.ends_with(end)).map_or("", |(_, unit)| unit)
}

/// A key as words, and its unit: `sensor.pixel.pitch_um` is `pitch` in µm. Where another of the `keys` ends with the same word, the name
/// of the table comes first.
pub(crate) fn said<'a>(key: &str, mut keys: impl Iterator<Item = &'a str>) -> (String, &'static str) {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let own = last(key);
    let stated = UNITS.iter().find_map(|(end, unit)| Some((own.strip_suffix(end)?, *unit)));
    let (name, unit) = stated.filter(|(name, _)| !name.is_empty()).unwrap_or((&own, ""));
    let table = key.rsplit('.').nth(1).filter(|_| keys.any(|k| k != key && last(k) == own));
    let name = table.map_or(name.to_owned(), |table| format!("{table}_{name}"));
    (in_words(&name), unit)
}

/// The words of a key as the trade writes them: `f-number`, and abbreviations in capitals.
fn in_words(name: &str) -> String {
    let words: Vec<String> = name
        .split('_')
        .map(|word| if ABBREVIATIONS.contains(&word) { word.to_uppercase() } else { word.to_owned() })
        .collect();
    words.join(" ").replace("f number", "f-number")
}

/// The names of cameras as names of files and folders; see [`file_names`].
#[must_use]
pub fn of_cameras(cameras: &[Camera]) -> Vec<String> {
    file_names(cameras.iter().map(|c| c.description().name.as_str()))
}

/// Names as names of files. Characters other than letters, digits, `-`, `_` and `.` are replaced, and names that would be equal are
/// numbered, also those that differ in capitals alone.
pub fn file_names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let keep = |c: char| match c {
        '²' => '2',
        c if c.is_alphanumeric() || "-_.".contains(c) => c,
        _ => '-',
    };
    let plain = |name: &str| name.chars().take(MAX_CHARS).map(keep).collect::<String>();
    numbered(names.map(|name| plain(name).trim_start_matches('.').to_owned()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(names: &[&str]) -> Vec<String> {
        file_names(names.iter().copied())
    }

    #[test]
    fn names_are_plain_and_each_its_own() {
        assert_eq!(all(&["bayer", "rgbw"]), ["bayer", "rgbw"]);
        assert_eq!(all(&["bayer", "rgbw", "Bayer"]), ["1-bayer", "rgbw", "3-Bayer"]);
        assert_eq!(all(&["../../etc", "a b/c", ".."]), ["-..-etc", "a-b-c", "3-"]);
        assert_eq!(all(&["a", "a", "2-a"]), ["1-a", "2-a", "3-2-a"]);
        assert_eq!(all(&["é".repeat(200).as_str()])[0].chars().count(), MAX_CHARS);
    }

    #[test]
    fn keys_are_said_with_their_units() {
        let alone = |key| said(key, [key].into_iter());
        assert_eq!(alone("luminance_cd_m2"), ("luminance".into(), "cd/m²"));
        assert_eq!(alone("sensor.pixel.pitch_um"), ("pitch".into(), "µm"));
        assert_eq!(alone("optics.f_number"), ("f-number".into(), ""));
        assert_eq!(alone("sensor.prnu_percent"), ("PRNU".into(), "%"));
        assert_eq!(alone("optics.ir_cut"), ("IR cut".into(), ""));
        assert_eq!(alone("sensor.rows"), ("rows".into(), ""));
        let keys = ["optics.transmittance.long_pass.edge_nm", "optics.transmittance.short_pass.edge_nm"];
        let both = keys.map(|key| said(key, keys.into_iter()).0);
        assert_eq!(both, ["long pass edge", "short pass edge"]);
    }
}
