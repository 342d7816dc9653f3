//! The extension module of the Python package `smalti`: objects of the library with NumPy arrays in and out.
//!
//! `smalti` computes, `smalti-io` reads and writes files. This crate converts arguments and arrays (`arrays`), raises exceptions
//! (`error`), and runs long work without the lock of the interpreter until it ends or Ctrl-C stops it (`work`). Progress bars and
//! functions with many keyword arguments are written in Python, in `python/smalti`.

mod arrays;
mod camera;
mod cfa;
mod cluster;
mod color;
#[cfg(feature = "command")]
mod command;
mod compare;
mod design;
mod error;
mod evaluate;
mod image;
mod json;
mod l3;
mod metrics;
mod photograph;
mod pipeline;
mod rating;
mod raw;
mod report;
mod scene;
mod spectrum;
mod study;
mod work;

use pyo3::prelude::*;

/// The implementation of the package `smalti`, which documents it.
#[pymodule]
mod _smalti {
    #[cfg(feature = "command")]
    #[pymodule_export]
    use crate::command::run_command;
    #[pymodule_export]
    use crate::{
        camera::{PyCamera, camera_names},
        cfa::{PyCfa, cfas, filters},
        cluster::{PyPartMaker, PySharedFolder, PySharedPlace, scenes_in_files},
        color::{delta_e, lab, scielab_map, xyz},
        compare::compare,
        design::{PyDesignSearch, design_names},
        error::SmaltiError,
        evaluate::{
            PyEvaluation, PySceneScores, evaluate, light_gain, score_pictures, score_scenes, test_scene_names,
        },
        image::PyImage,
        l3::{PyStatistics, PyTrainingRecord, gather_statistics, refine_pipeline, solve_statistics},
        metrics::{PyEdge, aliasing, cpsnr_db, edge_sfr, luminance_noise_percent, metrics, visual_snr},
        photograph::PyPhotograph,
        pipeline::PyPipeline,
        rating::analyse_ratings,
        raw::PyRawImage,
        report::write_report,
        scene::{PyOpticalImage, PyScene, scenes},
        spectrum::{PySpectrum, illuminant, illuminants},
        study::{PyResults, PyStudy, merge, parse_shard, run_sweep, study_names},
    };

    /// The version of the package and of the command.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
