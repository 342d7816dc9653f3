//! Camera and study files with slips of the pen: an error or a camera, a study, never a panic.

use smalti::camera::Camera;
use smalti::numeric::philox::Stream;
use smalti::spectrum::WavelengthGrid;
use smalti_io::{TomlSource, cameras, studies};

/// One of the files with up to four bytes or short runs deleted, doubled, replaced or moved.
fn mutated(files: &[&str], case: u32) -> String {
    let mut random = Stream::new(1, 0, case);
    let mut below = |n: usize| random.next_u32() as usize % n.max(1);
    let mut bytes = files[below(files.len())].as_bytes().to_vec();
    for _ in 0..=below(4) {
        let at = below(bytes.len());
        let end = (at + 1 + below(12)).min(bytes.len());
        match below(6) {
            0 => drop(bytes.drain(at..end)),
            1 => bytes[at] ^= 1 << below(8),
            2 => bytes[at] = b"0123456789-+.eE=[]{}\"',#\n"[below(25)],
            3 => bytes
                .splice(
                    at..at,
                    [&b"nan"[..], b"1e308", b"-1", b"[", b"\"", b"inf", b"[a.b]\n"][below(7)].to_vec(),
                )
                .for_each(drop),
            4 => {
                let run = bytes[at..end].to_vec();
                let to = below(bytes.len());
                bytes.splice(to..to, run).for_each(drop);
            }
            _ => bytes.truncate(at),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn no_slip_of_the_pen_panics() {
    let (mut refused, mut taken) = (0, 0);
    let files: Vec<&str> = cameras::names().iter().map(|c| c.toml).collect();
    for case in 0..600 {
        let text = mutated(&files, case);
        let source = TomlSource { name: "mutated.toml".into(), folder: "nowhere".into(), text: text.clone() };
        let set = ["sensor.pixel.pitch_um=1", "optics=3"][..(case % 3) as usize]
            .iter()
            .map(|o| o.parse().unwrap())
            .collect::<Vec<_>>();
        let outcome = std::panic::catch_unwind(|| match source.describe(&set) {
            Err(e) => Err(e.to_string()),
            // A mutated number may ask for a mosaic or sensor of any size; making the camera takes no memory for it.
            Ok(description) => {
                Camera::new(description, WavelengthGrid::VISIBLE).map(drop).map_err(|e| e.to_string())
            }
        });
        match outcome {
            Ok(Ok(())) => taken += 1,
            Ok(Err(message)) => {
                assert!(!message.is_empty());
                refused += 1;
            }
            Err(_) => panic!("case {case}:\n{text}"),
        }
    }
    assert!(refused > 100 && taken > 50, "{refused} refused, {taken} taken: the mutations say little");
}

#[test]
fn nor_does_one_in_a_study() {
    let (mut refused, mut taken) = (0, 0);
    let files: Vec<&str> = studies::names().iter().map(|s| s.toml).collect();
    for case in 0..300 {
        // Without the comments, where a slip does nothing.
        let lines: Vec<String> = files
            .iter()
            .map(|f| f.lines().filter(|l| !l.starts_with('#')).collect::<Vec<_>>().join("\n"))
            .collect();
        let text = mutated(&lines.iter().map(String::as_str).collect::<Vec<_>>(), case);
        let source = TomlSource { name: "mutated.toml".into(), folder: "nowhere".into(), text: text.clone() };
        match std::panic::catch_unwind(|| studies::from_source(&source).map(drop).map_err(|e| e.to_string()))
        {
            Ok(Ok(())) => taken += 1,
            Ok(Err(message)) => {
                assert!(message.contains("mutated.toml") || message.contains("camera"), "{message}");
                refused += 1;
            }
            Err(_) => panic!("case {case}:\n{text}"),
        }
    }
    assert!(refused > 100 && taken > 20, "{refused} refused, {taken} taken: the mutations say little");
}
