use proptest::prelude::*;

use super::*;
use crate::file::Negative;

const PLAIN: Values<'static> = Values { gains: &[], ignore: None, negative: Negative::Refuse };

const ORDERS: [[Axis; 3]; 6] = [
    [Axis::Band, Axis::Row, Axis::Col],
    [Axis::Band, Axis::Col, Axis::Row],
    [Axis::Row, Axis::Band, Axis::Col],
    [Axis::Row, Axis::Col, Axis::Band],
    [Axis::Col, Axis::Row, Axis::Band],
    [Axis::Col, Axis::Band, Axis::Row],
];

/// A sample that tells where it belongs.
fn value(band: usize, row: usize, col: usize) -> u16 {
    (band * 7919 + row * 104_729 + col * 31 + 1) as u16
}

fn bytes_of(r: &Raster) -> Vec<u8> {
    let mut out = vec![0xee; r.offset as usize];
    let [a, b, c] = r.order;
    for i in 0..r.len(a) {
        for j in 0..r.len(b) {
            for k in 0..r.len(c) {
                let at = |axis| [(a, i), (b, j), (c, k)].into_iter().find(|p| p.0 == axis).unwrap().1;
                let v = value(at(Axis::Band), at(Axis::Row), at(Axis::Col));
                out.extend(if r.big_endian { v.to_be_bytes() } else { v.to_le_bytes() });
            }
        }
    }
    out
}

proptest! {
    #[test]
    fn every_order_and_window_is_read(
        order in 0usize..6, big_endian: bool, offset in 0u64..9,
        (bands, rows, cols) in (1usize..6, 1usize..70, 1usize..70),
        cut in prop::array::uniform4(any::<prop::sample::Index>()), picked in any::<prop::sample::Index>(),
    ) {
        let raster = Raster { offset, kind: Kind::U16, big_endian, bands, rows, cols, order: ORDERS[order] };
        let bytes = bytes_of(&raster);
        let range = |n: usize, a: prop::sample::Index, b: prop::sample::Index| {
            let first = a.index(n);
            first..first + 1 + b.index(n - first)
        };
        // Bands backwards, and one of them left out.
        let wanted: Vec<usize> = (0..bands).rev().filter(|b| bands == 1 || *b != picked.index(bands)).collect();
        let part = Part { bands: &wanted, rows: range(rows, cut[0], cut[1]), cols: range(cols, cut[2], cut[3]) };
        let data = raster.read(&&bytes[..], &part, &PLAIN).unwrap();
        let mut expected = Vec::new();
        for b in &wanted {
            for r in part.rows.clone() {
                expected.extend(part.cols.clone().map(|c| f32::from(value(*b, r, c))));
            }
        }
        prop_assert_eq!(data, expected);
    }
}

#[test]
fn the_first_bad_sample_is_named_with_its_place() {
    let samples = [1.0f32, 2.0, 3.0, f32::NAN, 5.0, -6.0];
    let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_le_bytes()).collect();
    let order = ORDERS[0];
    let raster = Raster { offset: 0, kind: Kind::F32, big_endian: false, bands: 2, rows: 1, cols: 3, order };
    let part = |bands| Part { bands, rows: 0..1, cols: 0..3 };
    let of = |bands, values| raster.read(&&bytes[..], &part(bands), &values);
    let Err(Bad::Sample(bad)) = of(&[0, 1], PLAIN) else { panic!("NaN is read") };
    assert_eq!((bad.band, bad.row, bad.col, bad.expected), (1, 0, 0, "a finite number"));
    assert!(bad.value.is_nan());
    assert_eq!(of(&[0], PLAIN).unwrap(), [1.0, 2.0, 3.0]);
    let nothing = Values { ignore: Some(f32::NAN), negative: Negative::Clamp, gains: &[] };
    assert_eq!(of(&[1], nothing).unwrap(), [0.0, 5.0, 0.0]);
    let refused = of(&[1], Values { negative: Negative::Refuse, ..nothing });
    assert!(matches!(refused, Err(Bad::Sample(BadSample { col: 0, expected: values::MEASURED, .. }))));
    let scaled = Values { gains: &[(2.0, 0.5)], ..PLAIN };
    assert_eq!(of(&[0], scaled).unwrap(), [2.5, 4.5, 6.5]);
}

#[test]
fn types_keep_their_values() {
    let order = ORDERS[0];
    let read = |kind: Kind, big_endian: bool, bytes: &[u8]| {
        let cols = bytes.len() / kind.size();
        let raster = Raster { offset: 0, kind, big_endian, bands: 1, rows: 1, cols, order };
        let values = Values { negative: Negative::Keep, ..PLAIN };
        raster.read(&bytes, &Part { bands: &[0], rows: 0..1, cols: 0..cols }, &values).unwrap()
    };
    assert_eq!(read(Kind::I8, false, &[255, 7]), [-1.0, 7.0]);
    assert_eq!(read(Kind::I16, true, &(-300i16).to_be_bytes()), [-300.0]);
    assert_eq!(read(Kind::U32, true, &4_000_000_000u32.to_be_bytes()), [4e9]);
    assert_eq!(read(Kind::I64, false, &(-5i64).to_le_bytes()), [-5.0]);
    assert_eq!(read(Kind::U64, false, &(1u64 << 63).to_le_bytes()), [9.223_372e18]);
    assert_eq!(read(Kind::F64, true, &0.1f64.to_be_bytes()), [0.1]);
    assert_eq!(read(Kind::F16, true, &0x3c00u16.to_be_bytes()), [1.0]);
}
