//! Answers requests to the engine of the studio with the native library, for comparison with the module: `studio_answers FOLDER REQUESTS OUT`. FOLDER has
//! the files of `studio_assets`, REQUESTS is a JSON list; the answer to the request with index N is written to `OUT/N`.

use std::error::Error;
use std::fs;
use std::io::Read;
use std::path::Path;

use flate2::read::DeflateDecoder;
use serde_json::Value;
use smalti_wasm::{Engine, StudioFile};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, requests, out] = args.as_slice() else { return Err("expected FOLDER REQUESTS OUT".into()) };
    let inflated = |name: &str| -> Result<Vec<u8>, Box<dyn Error>> {
        let mut bytes = Vec::new();
        DeflateDecoder::new(fs::File::open(Path::new(folder).join(name))?).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let manifest: Value = serde_json::from_slice(&fs::read(Path::new(folder).join("manifest.json"))?)?;
    let mut engine = Engine::default();
    engine.load("", StudioFile::Training, &inflated("training.bin")?)?;
    engine.load("", StudioFile::Statistics, &inflated("statistics.bin")?)?;
    for scene in manifest["scenes"].as_array().ok_or("expected scenes")? {
        engine.load("", StudioFile::Scene, &inflated(scene["file"].as_str().ok_or("expected a file")?)?)?;
    }
    let requests: Vec<Value> = serde_json::from_slice(&fs::read(requests)?)?;
    for (number, request) in requests.iter().enumerate() {
        let answer = engine.ask(request.to_string().as_bytes())?;
        fs::write(Path::new(out).join(number.to_string()), answer.to_bytes())?;
    }
    Ok(())
}
