//! The profiles are made again from their sources.

use smalti::color::ColorSpace;

use super::profile;

// Colorants (X, Y, Z of red, green, blue) relative to D50, from the primaries of IEC 61966-2-1 and of SMPTE
// EG 432-1 with white x = 0.3127, y = 0.3290, adapted by the Bradford transform of ICC.1:2022 annex E.
const SRGB: [[f64; 3]; 3] =
    [[0.43604, 0.22248, 0.01392], [0.38511, 0.71691, 0.09707], [0.14305, 0.06061, 0.71391]];
const DISPLAY_P3: [[f64; 3]; 3] =
    [[0.51512, 0.24119, -0.00105], [0.29198, 0.69224, 0.04188], [0.15710, 0.06657, 0.78407]];
const D50: [f64; 3] = [0.9642, 1.0, 0.8249];
const ADAPTATION: [f64; 9] =
    [1.04789, 0.02292, -0.05022, 0.02958, 0.99048, -0.01708, -0.00925, 0.01507, 0.75168];
// g, a, b, c, d of the sRGB curve: ((x + 0.055) / 1.055)^2.4 from 0.04045 on, x / 12.92 below.
const SRGB_CURVE: [f64; 5] = [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045];

/// The profile (ICC.1:2022, version 4.4) of an encoded space.
fn made(name: &str, colorants: [[f64; 3]; 3]) -> Vec<u8> {
    let curve = parametric_curve();
    let tags: [(&[u8; 4], Vec<u8>); 10] = [
        (b"desc", localized(name)),
        (b"cprt", localized("Public domain")),
        (b"wtpt", numbers(b"XYZ ", &D50)),
        (b"chad", numbers(b"sf32", &ADAPTATION)),
        (b"rXYZ", numbers(b"XYZ ", &colorants[0])),
        (b"gXYZ", numbers(b"XYZ ", &colorants[1])),
        (b"bXYZ", numbers(b"XYZ ", &colorants[2])),
        (b"rTRC", curve.clone()),
        (b"gTRC", curve.clone()),
        (b"bTRC", curve),
    ];
    let mut table = (tags.len() as u32).to_be_bytes().to_vec();
    let mut data = Vec::new();
    let data_start = 128 + 4 + 12 * tags.len();
    for (signature, value) in tags {
        table.extend(signature);
        table.extend(((data_start + data.len()) as u32).to_be_bytes());
        table.extend((value.len() as u32).to_be_bytes());
        data.extend(value);
        data.resize(data.len().next_multiple_of(4), 0);
    }
    let mut out = header((data_start + data.len()) as u32);
    out.extend(table);
    out.extend(data);
    out
}

/// The 128 bytes of ICC.1:2022 section 7.2: a display profile, RGB to XYZ.
fn header(size: u32) -> Vec<u8> {
    let mut out = vec![0; 128];
    let mut put = |at: usize, bytes: &[u8]| {
        for (to, from) in out.iter_mut().skip(at).zip(bytes) {
            *to = *from;
        }
    };
    put(0, &size.to_be_bytes());
    put(8, &[4, 0x40]);
    put(12, b"mntrRGB XYZ ");
    // A fixed date: equal pictures make equal files.
    for (i, part) in [2025u16, 1, 1].into_iter().enumerate() {
        put(24 + 2 * i, &part.to_be_bytes());
    }
    put(36, b"acsp");
    put(68, &D50.map(fixed).concat());
    out
}

/// s15Fixed16Number.
fn fixed(v: f64) -> [u8; 4] {
    ((v * 65536.0).round() as i32).to_be_bytes()
}

fn numbers(kind: &[u8; 4], values: &[f64]) -> Vec<u8> {
    let mut out = kind.to_vec();
    out.extend([0; 4]);
    out.extend(values.iter().flat_map(|&v| fixed(v)));
    out
}

fn parametric_curve() -> Vec<u8> {
    let mut out = b"para\0\0\0\0\0\x03\0\0".to_vec();
    out.extend(SRGB_CURVE.iter().flat_map(|&v| fixed(v)));
    out
}

/// multiLocalizedUnicodeType with one English record.
fn localized(text: &str) -> Vec<u8> {
    let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let mut out = b"mluc\0\0\0\0\0\0\0\x01\0\0\0\x0cenUS".to_vec();
    out.extend((utf16.len() as u32).to_be_bytes());
    out.extend(28u32.to_be_bytes());
    out.extend(utf16);
    out
}

#[test]
fn the_profiles_follow_from_their_colorants() {
    assert_eq!(profile(ColorSpace::Srgb).unwrap(), made("sRGB", SRGB));
    assert_eq!(profile(ColorSpace::DisplayP3).unwrap(), made("Display P3", DISPLAY_P3));
}

#[test]
fn the_colorants_add_up_to_the_white_of_the_connection_space() {
    for colorants in [SRGB, DISPLAY_P3] {
        for (i, white) in D50.iter().enumerate() {
            let sum: f64 = colorants.iter().map(|c| c[i]).sum();
            assert!((sum - white).abs() < 2e-5, "{sum} {white}");
        }
    }
}

#[test]
fn the_size_is_stated_and_tags_lie_inside() {
    let p = profile(ColorSpace::DisplayP3).unwrap();
    let u32_at = |i: usize| u32::from_be_bytes(p[i..i + 4].try_into().unwrap()) as usize;
    assert_eq!(u32_at(0), p.len());
    for i in 0..u32_at(128) {
        assert!(u32_at(136 + 12 * i) + u32_at(140 + 12 * i) <= p.len());
    }
    assert!(profile(ColorSpace::Xyz).is_none());
}
