use proptest::prelude::*;

use super::*;

/// A frame by hand: 12 bits, 2 × 2, one component, predictor 1. Code 0 is size 0, code 10 size 2.
fn by_hand(predictor: u8, scan: &[u8]) -> Vec<u8> {
    let mut b = vec![0xff, 0xd8];
    b.extend([0xff, 0xc4, 0, 2 + 17 + 2, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2]);
    b.extend([0xff, 0xc3, 0, 11, 12, 0, 2, 0, 2, 1, 0, 0x11, 0]);
    b.extend([0xff, 0xda, 0, 8, 1, 0, 0, predictor, 0, 0]);
    b.extend(scan);
    b.extend([0xff, 0xd9]);
    b
}

#[test]
fn a_frame_by_hand_is_as_the_standard_says() {
    // Differences 0, +3, -2, 0: 0, 10 11, 10 01, 0, then ones.
    let samples = decode(&by_hand(1, &[0b0101_1100, 0b1011_1111]), 4..=4).unwrap();
    assert_eq!(samples, [2048, 2051, 2046, 2046]);
    // Above the last sample stands 2051.
    assert_eq!(decode(&by_hand(2, &[0b0101_1100, 0b1011_1111]), 4..=4).unwrap()[3], 2051);
}

#[test]
fn what_is_wrong_is_said() {
    let good = by_hand(1, &[0b0101_1100, 0b1011_1111]);
    let said = |bytes: &[u8]| decode(bytes, 4..=4).unwrap_err();
    assert_eq!(said(&good[..10]), "a segment ends after the data");
    assert_eq!(said(&by_hand(1, &[])), "it ends too early");
    assert_eq!(said(&by_hand(1, &[0xfe])), "it has a code of no table");
    assert_eq!(said(&by_hand(8, &[0])), "it has predictor 8, point transform 0");
    assert_eq!(decode(&good, 5..=9).unwrap_err(), "it has 4 samples; the strip or tile 5 to 9");
    let mut lossy = good.clone();
    lossy[26] = 0xc0;
    assert_eq!(said(&lossy), "it is lossy JPEG; expected lossless (SOF3)");
}

proptest! {
    #[test]
    fn every_predictor_and_layout_reads_back(
        predictor in 1u8..=7, components in 1usize..=4, cols in 1usize..12, restart in 0usize..4,
        rows in prop::collection::vec(prop::collection::vec(any::<u16>(), 48), 1..10), shift in 0u32..16,
    ) {
        let len = cols * components;
        let samples: Vec<u16> = rows.iter().flat_map(|r| r.iter().take(len)).map(|v| v >> shift).collect();
        let coded = encode(&samples, cols, components, predictor, restart).unwrap();
        prop_assert_eq!(decode(&coded, samples.len()..=samples.len()).unwrap(), samples);
    }

    #[test]
    fn mutated_frames_are_read_or_refused(
        at in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut in any::<prop::sample::Index>(), restart in 0usize..3,
    ) {
        let samples: Vec<u16> = (0..96).map(|i| i * 677).collect();
        let mut coded = encode(&samples, 8, 2, 7, restart).unwrap();
        for (index, value) in at {
            let i = index.index(coded.len());
            coded[i] = value;
        }
        coded.truncate(coded.len().min(40 + cut.index(200)));
        if let Ok(samples) = decode(&coded, 1..=96) {
            prop_assert!(samples.len() <= 96);
        }
    }
}
