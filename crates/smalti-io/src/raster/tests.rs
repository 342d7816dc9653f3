use std::io::{Cursor, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use proptest::prelude::*;

use super::values::BadSample;
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
fn value([band, row, col]: [usize; 3]) -> u16 {
    (band * 7919 + row * 104_729 + col * 31 + 1) as u16
}

/// Samples of a block that begins at a place, in the order of a cube; zeros beyond its end.
fn samples(cube: &Raster, block: Raster, [band, row, col]: [usize; 3]) -> Vec<u8> {
    let mut out = Vec::new();
    let [a, b, c] = block.order;
    for i in 0..block.len(a) {
        for j in 0..block.len(b) {
            for k in 0..block.len(c) {
                let at = |axis| [(a, i), (b, j), (c, k)].into_iter().find(|p| p.0 == axis).unwrap().1;
                let place = [band + at(Axis::Band), row + at(Axis::Row), col + at(Axis::Col)];
                let inside = place[0] < cube.bands && place[1] < cube.rows && place[2] < cube.cols;
                let v = if inside { value(place) } else { 0 };
                out.extend(if block.big_endian { v.to_be_bytes() } else { v.to_le_bytes() });
            }
        }
    }
    out
}

/// A file that does not say that it is in memory, as a file on disk, and counts how often it is read.
struct OnDisk(Vec<u8>, Arc<AtomicUsize>);

impl Source for OnDisk {
    fn len(&self) -> u64 {
        Source::len(&self.0)
    }

    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.1.fetch_add(1, Relaxed);
        self.0.read_at(offset, out)
    }
}

fn in_run(raster: Raster, offset: usize, on_disk: bool) -> Cube<'static> {
    let mut bytes = vec![0xee; offset];
    bytes.extend(samples(&raster, raster, [0; 3]));
    let source: Shared<'static> =
        if on_disk { Arc::new(OnDisk(bytes, Arc::default())) } else { Arc::new(bytes) };
    Cube { source, raster, storage: Storage::Run { offset: offset as u64 } }
}

/// As a stream, which counts how often it is begun.
fn in_stream(raster: Raster, offset: usize, begun: &Arc<AtomicUsize>) -> Cube<'static> {
    let mut bytes = vec![0xee; offset];
    bytes.extend(samples(&raster, raster, [0; 3]));
    let (len, begun) = (bytes.len() as u64, Arc::clone(begun));
    let begin = move || {
        begun.fetch_add(1, Relaxed);
        Ok(Box::new(Cursor::new(bytes.clone())) as _)
    };
    let source = Arc::new(Stream::new("s", len, begin));
    Cube { source, raster, storage: Storage::Run { offset: offset as u64 } }
}

fn in_blocks(raster: Raster, size: [usize; 3], packed: bool, cut: bool) -> Cube<'static> {
    let counts =
        [raster.bands.div_ceil(size[0]), raster.rows.div_ceil(size[1]), raster.cols.div_ceil(size[2])];
    let (mut bytes, mut places) = (vec![0xee; 3], Vec::new());
    let filters = if packed { vec![Filter::Shuffle, Filter::Deflate] } else { Vec::new() };
    for band in (0..counts[0]).map(|i| i * size[0]) {
        for row in (0..counts[1]).map(|i| i * size[1]) {
            for col in (0..counts[2]).map(|i| i * size[2]) {
                let rows = if cut { size[1].min(raster.rows - row) } else { size[1] };
                let block = Raster { bands: size[0], rows, cols: size[2], ..raster };
                let plain = samples(&raster, block, [band, row, col]);
                // Every third is stored as it is.
                let skipped = if packed && places.len() % 3 == 2 { 3 } else { 0 };
                let stored = if packed && skipped == 0 {
                    let (first, second): (Vec<u8>, Vec<u8>) = plain.chunks(2).map(|c| (c[0], c[1])).unzip();
                    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
                    encoder.write_all(&[first, second].concat()).unwrap();
                    encoder.finish().unwrap()
                } else {
                    plain
                };
                places.push(Place { offset: bytes.len() as u64, bytes: stored.len() as u64, skipped });
                bytes.extend(stored);
            }
        }
    }
    let strides = [counts[1] * counts[2], counts[2], 1];
    let blocks =
        Blocks { size, strides, places: places.into(), filters, heads: Arc::default(), unpack: None, cut };
    let cube =
        Cube { source: Arc::new(OnDisk(bytes, Arc::default())), raster, storage: Storage::Blocks(blocks) };
    cube.check(Path::new("f"), "a block", Limits::default()).unwrap();
    cube
}

/// Lines with something before each of them, of which the second has more where they are not at equal distances.
fn in_lines(raster: Raster, head: usize, equal: bool, reads: &Arc<AtomicUsize>) -> Cube<'static> {
    let (mut bytes, mut places, mut heads) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..raster.rows {
        if !equal && row == 1 {
            bytes.extend([0xee; 2]);
        }
        let own = vec![row as u8; head];
        bytes.extend(&own);
        heads.extend(own);
        let line = samples(&raster, Raster { rows: 1, ..raster }, [0, row, 0]);
        places.push(Place { offset: bytes.len() as u64, bytes: line.len() as u64, skipped: 0 });
        bytes.extend(line);
    }
    let blocks = Blocks {
        size: [raster.bands, 1, raster.cols],
        strides: [0, 1, 1],
        places: places.into(),
        heads: heads.into(),
        filters: Vec::new(),
        unpack: None,
        cut: false,
    };
    let source = Arc::new(OnDisk(bytes, Arc::clone(reads)));
    Cube { source, raster, storage: Storage::Blocks(blocks) }
}

/// What the samples of a part are.
fn expected(bands: &[usize], rows: Range<usize>, cols: Range<usize>) -> Vec<f32> {
    let mut expected = Vec::new();
    for b in bands {
        for r in rows.clone() {
            expected.extend(cols.clone().map(|c| f32::from(value([*b, r, c]))));
        }
    }
    expected
}

fn range(n: usize, a: prop::sample::Index, b: prop::sample::Index) -> Range<usize> {
    let first = a.index(n);
    first..first + 1 + b.index(n - first)
}

fn read_plain(cubes: &[Cube<'_>], bands: &[(usize, usize)], part: (Range<usize>, Range<usize>)) -> Vec<f32> {
    read(cubes, bands, part, |_, _, _| Ok(())).unwrap()
}

proptest! {
    #[test]
    fn every_order_and_window_is_read(
        order in 0usize..6, big_endian: bool, offset in 0usize..9, storage in 0usize..9,
        (bands, rows, cols) in (1usize..40, 1usize..70, 1usize..70), block in prop::array::uniform3(1usize..50),
        cut in prop::array::uniform4(any::<prop::sample::Index>()), picked in any::<prop::sample::Index>(), backwards: bool,
    ) {
        let raster = Raster { kind: Kind::U16, big_endian, bands, rows, cols, order: ORDERS[order] };
        let begun = Arc::new(AtomicUsize::new(0));
        let cube = match storage {
            0 | 1 => in_run(raster, offset, storage == 0),
            6 => in_stream(raster, offset, &begun),
            7 | 8 => in_lines(raster, offset, storage == 7, &Arc::default()),
            _ => in_blocks(raster, block, storage % 2 == 0, storage > 3),
        };
        // One of the bands left out.
        let mut wanted: Vec<usize> = (0..bands).filter(|b| bands == 1 || *b != picked.index(bands)).collect();
        if backwards {
            wanted.reverse();
        }
        let (rows, cols) = (range(rows, cut[0], cut[1]), range(cols, cut[2], cut[3]));
        let places: Vec<(usize, usize)> = wanted.iter().map(|b| (0, *b)).collect();
        let data = read_plain(&[cube], &places, (rows.clone(), cols.clone()));
        prop_assert_eq!(data, expected(&wanted, rows, cols));
        // Whatever the order, a stream is unpacked once.
        prop_assert_eq!(begun.load(Relaxed), usize::from(storage == 6));
    }
}

#[test]
fn a_stream_by_rows_is_unpacked_once_for_all_of_them() {
    let begun = Arc::new(AtomicUsize::new(0));
    let read_by_rows = |order: usize| {
        let raster =
            Raster { kind: Kind::U16, big_endian: false, bands: 3, rows: 40, cols: 6, order: ORDERS[order] };
        let cubes = [in_stream(raster, 3, &begun)];
        begun.store(0, Relaxed);
        for row in (0..40).step_by(10) {
            let data = read_plain(&cubes, &[(0, 0), (0, 1), (0, 2)], (row..row + 10, 0..6));
            assert_eq!(data, expected(&[0, 1, 2], row..row + 10, 0..6));
        }
        (cubes[0].rows_at_once(), begun.load(Relaxed))
    };
    assert_eq!((read_by_rows(2), read_by_rows(3)), ((1, 1), (1, 1)));
    // Where rows lie apart, once for each part.
    for order in [0, 1, 4, 5] {
        assert_eq!(read_by_rows(order), (40, 4));
    }
}

#[test]
fn lines_at_equal_distances_are_read_together() {
    let raster = Raster { kind: Kind::U16, big_endian: false, bands: 3, rows: 40, cols: 6, order: ORDERS[2] };
    let reads = |head: usize, equal: bool, bands: &[usize]| {
        let reads = Arc::default();
        let places: Vec<(usize, usize)> = bands.iter().map(|b| (0, *b)).collect();
        let data = read_plain(&[in_lines(raster, head, equal, &reads)], &places, (3..40, 1..5));
        assert_eq!(data, expected(bands, 3..40, 1..5));
        reads.load(Relaxed)
    };
    assert_eq!(reads(8, true, &[2, 0, 1]), 1);
    // Not where little is wanted, where what stands between is no number of samples, or much.
    for (head, bands) in [(8, &[1][..]), (7, &[0, 1, 2]), (200, &[0, 1, 2])] {
        assert_eq!(reads(head, true, bands), 2 * 37);
    }
    // A line behind another one's head.
    for bands in [&[(0, 0), (0, 1)][..], &[(0, 0)]] {
        let mut cube = in_lines(raster, 8, true, &Arc::default());
        if let Storage::Blocks(blocks) = &mut cube.storage {
            blocks.heads = blocks.heads.iter().rev().copied().collect();
        }
        let done: Result<Vec<f32>, Bad> = read(&[cube], bands, (5..7, 0..6), |_, _, _| Ok(()));
        assert!(
            matches!(done, Err(Bad::Block(message)) if message == "the header of block 5 is that of another block")
        );
    }
    let cube = |equal| in_lines(Raster { rows: 3, ..raster }, 8, equal, &Arc::default());
    let whole = |equal| read_plain(&[cube(equal)], &[(0, 0), (0, 1), (0, 2)], (0..3, 0..6));
    assert_eq!(whole(false), whole(true));
}

#[test]
fn what_a_stream_lacks_is_an_error_about_the_file() {
    let raster = Raster { kind: Kind::U16, big_endian: false, bands: 1, rows: 4, cols: 6, order: ORDERS[0] };
    type Begin = fn() -> io::Result<Box<dyn io::Read + Send>>;
    let cases: [(Begin, &str); 3] = [
        (|| Ok(Box::new(Cursor::new(vec![0; 47]))), "s: failed to fill whole buffer"),
        (|| panic!("of a decoder"), "s: the decoder failed on it"),
        (|| Err(io::Error::other("no")), "s: no"),
    ];
    for (begin, expected) in cases {
        let source: Shared<'static> = Arc::new(Stream::new("s", 48, begin));
        let cube = Cube { source, raster, storage: Storage::Run { offset: 0 } };
        let done: Result<Vec<f32>, Bad> = read(&[cube], &[(0, 0)], (0..4, 0..6), |_, _, _| Ok(()));
        let Err(Bad::Block(message)) = done else { panic!("{done:?}") };
        assert_eq!(message, expected);
    }
}

#[test]
fn bands_of_several_cubes_are_told_apart() {
    let of = |bands, order: usize| Raster {
        kind: Kind::U16,
        big_endian: false,
        bands,
        rows: 5,
        cols: 6,
        order: ORDERS[order],
    };
    let cubes = [in_run(of(2, 3), 0, true), in_blocks(of(3, 0), [2, 2, 4], true, false)];
    let bands = [(1, 2), (0, 1), (1, 0), (0, 0)];
    assert_eq!(read_plain(&cubes, &bands, (1..4, 2..6)), expected(&[2, 1, 0, 0], 1..4, 2..6));
}

#[test]
fn a_large_window_is_read_in_pieces() {
    // Two bands of a mebibyte and a half each, which run down the columns.
    let (rows, cols) = (1024, 768);
    let raster = Raster { kind: Kind::U16, big_endian: false, bands: 2, rows, cols, order: ORDERS[1] };
    let cube = in_run(raster, 5, true);
    let data = read_plain(&[cube], &[(0, 0), (0, 1)], (3..rows, 0..cols));
    assert!(data == expected(&[0, 1], 3..rows, 0..cols));
}

#[test]
fn what_is_declared_is_compared_with_the_file() {
    let raster = Raster { kind: Kind::U16, big_endian: false, bands: 4, rows: 5, cols: 6, order: ORDERS[0] };
    let error =
        |cube: &Cube<'_>| cube.check(Path::new("f"), "a block", Limits::default()).unwrap_err().to_string();
    let mut run = in_run(raster, 7, true);
    run.raster.rows = 6;
    assert!(error(&run).starts_with("f: a block needs 295 bytes, but the file has 247;"));
    run.raster.rows = usize::MAX;
    assert!(error(&run).contains("needs 18446744073709551615 bytes"));
    let change = |packed, change: &dyn Fn(&mut Place)| {
        let mut cube = in_blocks(raster, [1, 5, 6], packed, false);
        if let Storage::Blocks(blocks) = &mut cube.storage {
            let mut places = blocks.places.to_vec();
            change(&mut places[1]);
            blocks.places = places.into();
        }
        cube
    };
    assert!(error(&change(false, &|p| p.offset += 10_000)).contains("but the file has 243"));
    assert!(error(&change(false, &|p| p.bytes -= 1)).contains("a block needs 60 bytes, but the file has 59"));
    assert!(error(&change(true, &|p| p.bytes = u64::MAX)).contains("but the file has"));
    // Blocks that do not unpack to what they should hold.
    for cube in
        [change(true, &|p| p.bytes /= 2), change(true, &|p| p.offset += 1), change(true, &|p| p.skipped = 3)]
    {
        cube.check(Path::new("f"), "a block", Limits::default()).unwrap();
        let done: Result<Vec<f32>, Bad> = read(&[cube], &[(0, 0), (0, 1)], (0..5, 0..6), |_, _, _| Ok(()));
        assert!(matches!(done, Err(Bad::Block(_))));
    }
}

fn of_values(kind: Kind, big_endian: bool, bands: usize, bytes: Vec<u8>) -> Cube<'static> {
    let cols = bytes.len() / kind.size() / bands;
    let raster = Raster { kind, big_endian, bands, rows: 1, cols, order: ORDERS[0] };
    Cube { source: Arc::new(bytes), raster, storage: Storage::Run { offset: 0 } }
}

#[test]
fn the_first_bad_sample_is_named_with_its_place() {
    let samples = [1.0f32, 2.0, 3.0, f32::NAN, 5.0, -6.0];
    let cube = of_values(Kind::F32, false, 2, samples.iter().flat_map(|v| v.to_le_bytes()).collect());
    let of = |bands: &[usize], values: Values<'_>| -> Result<Vec<f32>, Bad> {
        let places: Vec<(usize, usize)> = bands.iter().map(|b| (0, *b)).collect();
        let check = |plane: usize, samples: &mut [f32], row: usize| {
            values.check(bands[plane], samples, (row, 0, 3)).map_err(Bad::Sample)
        };
        read(std::slice::from_ref(&cube), &places, (0..1, 0..3), check)
    };
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
    let read = |kind: Kind, big_endian: bool, bytes: &[u8]| {
        let cube = of_values(kind, big_endian, 1, bytes.to_vec());
        let whole = (0..1, 0..cube.raster.cols);
        read_plain(&[cube], &[(0, 0)], whole)
    };
    assert_eq!(read(Kind::I8, false, &[255, 7]), [-1.0, 7.0]);
    assert_eq!(read(Kind::I16, true, &(-300i16).to_be_bytes()), [-300.0]);
    assert_eq!(read(Kind::U32, true, &4_000_000_000u32.to_be_bytes()), [4e9]);
    assert_eq!(read(Kind::I64, false, &(-5i64).to_le_bytes()), [-5.0]);
    assert_eq!(read(Kind::U64, false, &(1u64 << 63).to_le_bytes()), [9.223_372e18]);
    assert_eq!(read(Kind::F64, true, &0.1f64.to_be_bytes()), [0.1]);
    assert_eq!(read(Kind::F16, true, &0x3c00u16.to_be_bytes()), [1.0]);
}
