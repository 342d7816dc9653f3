//! The functions of the modules, for a host that has numbers alone.

use std::cell::RefCell;
use std::fmt::Display;

/// The input, the output and what is kept between calls.
#[derive(Default)]
struct Module {
    #[cfg(not(feature = "engine"))]
    pictures: crate::StudyPictures,
    #[cfg(feature = "engine")]
    engine: crate::Engine,
    input: Vec<u8>,
    output: Vec<u8>,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
}

const FAILED: i32 = -1;

/// What every call says after one that trapped: what is kept may be half changed, and stays borrowed.
const TRAPPED: &str = "an earlier call to this module ended abnormally, as for want of memory; expected a new instance of the module";

/// Runs a function on what is kept; of an error the output is its message. After a call that trapped it refuses.
fn run<E: Display>(work: impl FnOnce(&mut Module) -> Result<i32, E>) -> i32 {
    MODULE.with(|module| match module.try_borrow_mut() {
        Ok(mut module) => work(&mut module).unwrap_or_else(|error| {
            module.output = error.to_string().into_bytes();
            FAILED
        }),
        Err(_) => FAILED,
    })
}

/// The output, that of a module that trapped being [`TRAPPED`].
fn with_output<T>(read: impl FnOnce(&[u8]) -> T) -> T {
    MODULE.with(|module| match module.try_borrow() {
        Ok(module) => read(&module.output),
        Err(_) => read(TRAPPED.as_bytes()),
    })
}

/// Makes room for an input; returns the address for it. After a call that trapped, the room is not read and not returned to the memory.
#[unsafe(no_mangle)]
extern "C" fn reserve(bytes: usize) -> *mut u8 {
    MODULE.with(|module| match module.try_borrow_mut() {
        Ok(mut module) => {
            module.input = vec![0; bytes];
            module.input.as_mut_ptr()
        }
        Err(_) => vec![0; bytes].leak().as_mut_ptr(),
    })
}

/// Where the output lies.
#[unsafe(no_mangle)]
extern "C" fn output() -> *const u8 {
    with_output(<[u8]>::as_ptr)
}

/// Bytes of the output.
#[unsafe(no_mangle)]
extern "C" fn output_bytes() -> usize {
    with_output(<[u8]>::len)
}

#[cfg(not(feature = "engine"))]
mod of_studies {
    use smalti::design::TrialProcessing;
    use smalti::sensor::NoiseMode;

    use super::run;
    use crate::StudyPictureError;

    /// Adds the study of the input.
    #[unsafe(no_mangle)]
    extern "C" fn study() -> i32 {
        run(|module| {
            Ok::<_, StudyPictureError>(module.pictures.study(&std::mem::take(&mut module.input))? as i32)
        })
    }

    /// Makes a condition of a study ready.
    #[unsafe(no_mangle)]
    extern "C" fn setup(study: usize, condition: usize, is_learned: u32, text_bytes: usize) -> i32 {
        run(|module| {
            let input = std::mem::take(&mut module.input);
            let (light, codes) = input.split_at_checked(text_bytes).ok_or(StudyPictureError::Planes)?;
            let processing = if is_learned == 0 { TrialProcessing::Classic } else { TrialProcessing::L3 };
            module.pictures.setup(study, condition, processing, light, codes)?;
            Ok::<_, StudyPictureError>(0)
        })
    }

    /// Draws what a design makes of a scene.
    #[unsafe(no_mangle)]
    extern "C" fn draw(number: f64, scene: usize, is_noisy: u32) -> i32 {
        run(|module| {
            let noise = if is_noisy == 0 { NoiseMode::None } else { NoiseMode::All };
            module.output = module.pictures.draw(number as u64, scene, noise)?;
            Ok::<_, StudyPictureError>(0)
        })
    }
}

#[cfg(feature = "engine")]
mod of_engine {
    use super::run;
    use crate::{EngineError, StudioFile};

    /// The input as a text of some bytes and what follows it.
    fn named(input: &[u8], name_bytes: usize) -> Result<(&str, &[u8]), EngineError> {
        input
            .split_at_checked(name_bytes)
            .and_then(|(name, rest)| Some((std::str::from_utf8(name).ok()?, rest)))
            .ok_or(EngineError::Missing("a name in UTF-8"))
    }

    /// Takes a file of the studio: the first bytes of the input are the name of the lens in UTF-8, the others the file.
    #[unsafe(no_mangle)]
    extern "C" fn load(kind: u32, name_bytes: usize) -> i32 {
        run(|module| {
            let kind = match kind {
                0 => StudioFile::Training,
                1 => StudioFile::Scene,
                2 => StudioFile::Statistics,
                other => return Err(EngineError::NoKind(other)),
            };
            let input = std::mem::take(&mut module.input);
            let (lens, file) = named(&input, name_bytes)?;
            module.engine.load(lens, kind, file)?;
            Ok::<_, EngineError>(0)
        })
    }

    /// Takes a file from which light is gathered: the first bytes of the input are its name in UTF-8, the others the file.
    #[unsafe(no_mangle)]
    extern "C" fn source(name_bytes: usize) -> i32 {
        run(|module| {
            let input = std::mem::take(&mut module.input);
            let (name, file) = named(&input, name_bytes)?;
            module.engine.source(name, file.to_vec());
            Ok::<_, EngineError>(0)
        })
    }

    /// Takes a photograph: the first bytes of the input are its name in UTF-8, the others RGBA.
    #[unsafe(no_mangle)]
    extern "C" fn photograph(name_bytes: usize, rows: usize, cols: usize) -> i32 {
        run(|module| {
            let input = std::mem::take(&mut module.input);
            let (id, rgba) = named(&input, name_bytes)?;
            module.engine.photograph(id, [rows, cols], rgba)?;
            Ok::<_, EngineError>(0)
        })
    }

    /// Answers the request of the input.
    #[unsafe(no_mangle)]
    extern "C" fn ask() -> i32 {
        run(|module| {
            module.output = module.engine.ask(&std::mem::take(&mut module.input))?.to_bytes();
            Ok::<_, EngineError>(0)
        })
    }
}
