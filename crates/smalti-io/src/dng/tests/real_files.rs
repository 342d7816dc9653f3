//! What real files state: mosaics, clear channels, opcodes.

use super::*;

/// The codes of the pattern stand for themselves where no planes, or too few, are listed; a stated mosaic takes the place of the file's.
#[test]
fn mosaics_are_read_as_real_files_state_them() {
    let big = |samples: &[u32]| samples.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect::<Vec<u8>>();
    let file = |pattern: [u32; 4], more: &[(u16, bool, Vec<u32>)]| {
        let mut bytes = tiled(16, more, big);
        let at = bytes.windows(4).position(|w| w == [0, 1, 1, 2]).unwrap();
        bytes[at..at + 4].copy_from_slice(&pattern.map(|v| v as u8));
        bytes
    };
    let planes = |list: &[u32]| (50710, true, list.to_vec());
    let unlisted = "CFAPattern has colours that CFAPlaneColor does not list: ";
    for (pattern, more, letters, cells, note) in [
        ([0, 6, 6, 2], vec![], "RBW", [0, 2, 2, 1], None),
        ([0, 6, 6, 2], vec![planes(&[0, 6, 2])], "RWB", [0, 1, 1, 2], None),
        ([0, 1, 6, 2], vec![planes(&[0, 1, 2])], "RGBW", [0, 1, 3, 2], Some("W")),
        ([3, 5, 5, 4], vec![], "CMY", [0, 2, 2, 1], None),
        ([0, 1, 1, 2], vec![planes(&[0, 1, 2, 6])], "RGB", [0, 1, 1, 2], None),
    ] {
        let dng = parse(&file(pattern, &more)).unwrap();
        let expected: Vec<String> = letters.chars().map(String::from).collect();
        assert_eq!(dng.raw.channel_names(), expected, "{pattern:?}");
        assert_eq!(dng.raw.sampling(), &Sampling::Mosaic(Mosaic::new(2, 2, cells.to_vec()).unwrap()));
        assert_eq!(dng.notes, note.map(|n| format!("{unlisted}{n}")).into_iter().collect::<Vec<_>>());
    }
    // A code without a meaning keeps its number.
    let dng = parse(&file([0, 255, 255, 2], &[planes(&[0, 255, 2])])).unwrap();
    assert_eq!(dng.raw.channel_names(), ["R", "code 255", "B"]);

    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("f.dng");
    let stated: StatedMosaic = "RC/CB".parse().unwrap();
    std::fs::write(&path, file([0, 255, 255, 2], &[(50711, false, vec![3])])).unwrap();
    assert!(read(&path, Limits::default()).unwrap_err().to_string().contains("CFALayout is 3"));
    let dng = read_as(&path, Limits::default(), Some(&stated)).unwrap();
    assert_eq!(
        (dng.raw.sampling(), dng.raw.channel_names()),
        (&Sampling::Mosaic(stated.mosaic), &stated.names[..])
    );
    assert_eq!("xtrans".parse::<StatedMosaic>().unwrap().mosaic.rows(), 6);
}

/// Clear is white to DNG, unless the colours beside C show that it is cyan. Earlier versions wrote it as cyan.
#[test]
fn clear_is_white_and_cyan_is_cyan() {
    let codes =
        |names: &str| mosaic::color_codes(&names.chars().map(String::from).collect::<Vec<_>>()).unwrap();
    assert_eq!(codes("RCB"), [0, 6, 2]);
    assert_eq!(codes("RC"), [0, 6]);
    assert_eq!(codes("CYGM"), [3, 5, 1, 4]);
    assert_eq!(codes("CWR"), [3, 6, 0]);
    let rccb = digital(4, 4, Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap(), &["R", "C", "B"]);
    let bytes = bytes_of(&rccb, &DngInfo::default());
    let pattern = bytes.windows(4).position(|w| w == [0, 6, 6, 2]).unwrap();
    let planes = bytes.windows(3).position(|w| w == [0, 2, 6]).unwrap();
    let mut former = bytes;
    former[pattern..pattern + 4].copy_from_slice(&[0, 3, 3, 2]);
    former[planes..planes + 3].copy_from_slice(&[0, 2, 3]);
    assert_eq!(parse(&former).unwrap().raw, rccb);
    // In the order of a camera with another name for it.
    let renamed = parse(&former).unwrap().raw.with_channels(&names(&["W", "B", "R"]));
    assert_eq!(renamed.channel_names(), ["W", "B", "R"]);
    assert_eq!(renamed.sampling(), &Sampling::Mosaic(Mosaic::new(2, 2, vec![2, 0, 0, 1]).unwrap()));
}

/// A list with a gain map for every second row from the second on, after an opcode that is not carried out.
#[test]
fn gain_maps_are_applied_and_other_opcodes_are_told() {
    let mut map: Vec<u8> = [1u32, 0, 4, 5, 0, 1, 2, 1, 2, 2].iter().flat_map(|v| v.to_be_bytes()).collect();
    map.extend([1.0f64, 0.5, 0.0, 0.25].iter().flat_map(|v| v.to_be_bytes()));
    map.extend(1u32.to_be_bytes());
    map.extend([1.0f32, 2.0, 3.0, 4.0].iter().flat_map(|v| v.to_be_bytes()));
    let opcode = |number: u32, data: &[u8]| {
        let head = [number, 0x0103_0000, 0, data.len() as u32];
        [&head.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<u8>>()[..], data].concat()
    };
    let list = |opcodes: &[Vec<u8>]| {
        let bytes = [&(opcodes.len() as u32).to_be_bytes()[..], &opcodes.concat()].concat();
        bytes.iter().map(|b| u32::from(*b)).collect::<Vec<u32>>()
    };
    let fields = [
        (50714, false, vec![50]),
        (51008, true, list(&[opcode(4, &[0; 8]), opcode(99, &[])])),
        (51009, true, list(&[opcode(9, &map), opcode(8, &[0; 4])])),
        (51022, true, list(&[opcode(1, &[]), opcode(1, &[])])),
    ];
    let dng =
        parse(&tiled(16, &fields, |s| s.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect())).unwrap();
    assert_eq!(
        dng.notes,
        [
            "OpcodeList1 is ignored, corrections of the samples as stored: FixBadPixelsConstant, opcode 99",
            "OpcodeList2: 1 gain map(s) for the shading of the lens are applied to the samples",
            "OpcodeList2 is ignored, corrections of the linear raw image: MapPolynomial",
            "OpcodeList3 is ignored, corrections of the demosaicked image: WarpRectilinear",
        ]
    );
    for (i, v) in samples_of(&dng.raw).iter().enumerate() {
        let (r, c) = (i / 5, i % 5);
        // Points lie at the upper and lower edges, and at a quarter and three quarters of the width.
        let (down, across) =
            ((r as f64 + 0.5) / 4.0, (((c as f64 + 0.5) / 5.0 - 0.25) / 0.5).clamp(0.0, 1.0));
        let gain = if r % 2 == 1 { 1.0 + across + 2.0 * down } else { 1.0 };
        let expected = 50.0 + gain * (f64::from(value(1 + r, 1 + c)) - 50.0);
        assert_eq!(f64::from(*v), expected.round(), "row {r}, column {c}");
    }
}
