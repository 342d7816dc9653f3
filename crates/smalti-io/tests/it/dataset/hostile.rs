//! Damaged parts, and malicious parts with a correct hash.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use smalti_io::dataset::{Dataset, DatasetError, Manifest, PartProblem, part_from_bytes};

use super::fixtures::{plan, whole};

const HASH: &[u8] = b"smalti.blake3\x18\x40";

fn sample() -> (Vec<u8>, Manifest) {
    let dir = tempfile::tempdir().unwrap();
    whole(dir.path(), &plan(20, 20));
    let bytes = fs::read(dir.path().join("trials/part-000000.parquet")).unwrap();
    (bytes, Dataset::open(dir.path()).unwrap().manifest().clone())
}

/// Writes the correct hash into a part.
fn seal(bytes: &mut [u8]) {
    let Some(at) = bytes.windows(HASH.len()).rposition(|w| w == HASH) else { return };
    let at = at + HASH.len();
    let Some(place) = bytes.get_mut(at..at + 64) else { return };
    place.fill(b'0');
    let hash = blake3::hash(bytes).to_hex();
    bytes[at..at + 64].copy_from_slice(hash.as_bytes());
}

fn read(bytes: Vec<u8>, manifest: &Manifest) -> Result<(), DatasetError> {
    part_from_bytes(bytes, Path::new("x"), manifest, 0, &[0, 1, 2, 3, 4]).map(drop)
}

#[test]
fn every_flipped_bit_is_found() {
    let (good, manifest) = sample();
    read(good.clone(), &manifest).unwrap();
    let mut sealed = good.clone();
    seal(&mut sealed);
    assert!(sealed == good);
    for i in 0..good.len() {
        let mut bytes = good.clone();
        bytes[i] ^= 1 << (i % 8);
        let error = read(bytes, &manifest).unwrap_err();
        assert!(matches!(error, DatasetError::Part { .. }), "{i}: {error}");
    }
}

#[test]
fn parts_of_other_programs_are_told() {
    let (good, manifest) = sample();
    let at = good.windows(HASH.len()).rposition(|w| w == HASH).unwrap();
    let mut bytes = good;
    bytes[at] = b'x';
    let error = read(bytes, &manifest).unwrap_err();
    let expected = PartProblem::NotOurs { key: "smalti.blake3" };
    assert!(matches!(&error, DatasetError::Part { problem, .. } if *problem == expected), "{error}");
}

#[test]
fn huge_counts_in_the_footer_take_no_memory() {
    let (good, manifest) = sample();
    let length = u32::from_le_bytes(good[good.len() - 8..good.len() - 4].try_into().unwrap()) as usize;
    let footer = good.len() - 8 - length;
    // Replaces the head of each list of structures by one that declares 2³¹ − 1 elements in Thrift's compact protocol.
    let mut tried = 0;
    for i in footer..good.len() - 13 {
        if good[i] == 0x19 && good[i + 1] & 0x0f == 0x0c {
            let mut bytes = good.clone();
            bytes[i + 1..i + 7].copy_from_slice(&[0xfc, 0xff, 0xff, 0xff, 0xff, 0x07]);
            seal(&mut bytes);
            assert!(read(bytes, &manifest).is_err());
            tried += 1;
        }
    }
    assert!(tried >= 3, "{tried}");
    // The footer declares more bytes than the file has.
    let mut bytes = good;
    let end = bytes.len();
    bytes[end - 8..end - 4].fill(0xff);
    seal(&mut bytes);
    assert!(read(bytes, &manifest).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    #[test]
    fn bytes_changed_under_a_right_hash_neither_panic_nor_fill_the_memory(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        thread_local!(static SAMPLE: (Vec<u8>, Manifest) = {
            // Hides the messages of panics in the Parquet library, which the reader catches.
            std::panic::set_hook(Box::new(|_| {}));
            sample()
        });
        SAMPLE.with(|(good, manifest)| {
            let mut bytes = good.clone();
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            seal(&mut bytes);
            // Reading may fail, but must return.
            let _ = read(bytes, manifest);
        });
    }
}
