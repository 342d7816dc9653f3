//! Small files that would take much memory when decoded.

use std::path::Path;

use parquet::data_type::ByteArray;
use parquet::file::reader::ChunkReader;
use serde_json::json;

use super::super::{
    Column, ColumnKind, ColumnSpec, DatasetError, MAX_LIST_VALUES, MAX_TEXT_BYTES, Manifest, Plan,
};
use super::{decode, encode, marks};

#[test]
fn the_size_of_a_page_is_read_from_its_header() {
    // Zigzag encoding turns 64 into 128, which is 0x80 0x01 in groups of seven bits.
    assert_eq!(decode::uncompressed_size(&[0x15, 0x06, 0x15, 0x80, 0x01, 0x15]), Some(64));
    for header in [&[][..], &[0x15, 0x06, 0x25, 0x02], &[0x15, 0x06, 0x15, 0x80], &[0x15, 0x06, 0x15, 0x01]] {
        assert_eq!(decode::uncompressed_size(header), None, "{header:?}");
    }
    let huge = [0x15, 0x06, 0x15, 0xfe, 0xff, 0xff, 0xff, 0x0f, 0x15, 0x10];
    let error = decode::Source(huge.to_vec().into()).get_read(0).err().unwrap().to_string();
    assert!(error.ends_with("a page declares 2147483647 bytes; expected at most 220"), "{error}");
}

#[test]
fn a_long_run_of_nulls_in_a_list_is_refused() {
    let spec =
        ColumnSpec { name: "x".into(), kind: ColumnKind::Floats, unit: String::new(), doc: String::new() };
    let plan = Plan { study: json!(null), schema: vec![spec], trials: 1, chunk: 1 };
    let manifest = Manifest::new(&plan).unwrap();
    let column = [Column::Floats(vec![vec![f64::NAN; MAX_LIST_VALUES + 1]])];
    assert!(matches!(encode::encode(&manifest, 0, &column), Err(DatasetError::Columns { .. })));
    let mut bytes = encode::file(&manifest, 0, &column).unwrap();
    marks::seal(&mut bytes).unwrap();
    assert!(bytes.len() < MAX_LIST_VALUES / 10, "{}", bytes.len());
    let error = decode::part_from_bytes(bytes, Path::new("x"), &manifest, 0, &[0]).unwrap_err().to_string();
    assert!(error.contains("values exceeds the limit"), "{error}");
}

#[test]
fn one_long_text_many_times_is_refused() {
    let text = ByteArray::from(vec![b'a'; 1 << 20]);
    let times = MAX_TEXT_BYTES >> 20;
    let error = decode::texts(vec![text; times + 1]).unwrap_err().to_string();
    assert!(error.ends_with("269484032 bytes of text; expected at most 268435456"), "{error}");
}
