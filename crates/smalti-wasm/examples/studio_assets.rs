//! Writes the files that the page of the studio loads into a folder: `studio_assets FOLDER [CAMERA]`.

use std::error::Error;
use std::fs;
use std::path::Path;

use smalti::experiment::Silent;
use smalti_io::{cameras, studio};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().ok_or("expected a folder")?;
    let camera =
        cameras::load(args.next().as_deref().unwrap_or("bayer"), &[], None).map_err(|e| e.to_string())?;
    fs::create_dir_all(&folder)?;
    for asset in studio::assets(&camera, &Silent)?.into_iter().chain(studio::sources()) {
        fs::write(Path::new(&folder).join(&asset.name), &asset.bytes)?;
        println!("{} {}", asset.name, asset.bytes.len());
    }
    Ok(())
}
