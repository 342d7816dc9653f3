//! The scenes on which cameras are compared, by the names of sets and scenes.

use std::path::Path;

use smalti::camera::TestScene;
use smalti::spectrum::Illuminant;

use crate::error::At;
use crate::scene_file::is_meant;
use crate::{IoError, ReadOptions, SceneRequest, rendered, scenes};

/// A set of test scenes. None of them is a training scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TestSet {
    /// Test patterns: dead leaves, ColorChecker, resolution charts and a room of high dynamic range, under the illuminant of the
    /// comparison.
    Charts,
    /// Scenes of measured reflectances, each in its own light.
    #[default]
    Natural,
    /// Both.
    All,
}

impl TestSet {
    /// All sets with their names and summaries.
    pub const NAMED: [(&'static str, &'static str, Self); 3] = [
        ("charts", "Test patterns and charts", Self::Charts),
        ("natural", "Natural scenes in their own light", Self::Natural),
        ("all", "Both sets", Self::All),
    ];

    /// The scenes of the set.
    ///
    /// # Errors
    /// When a stored scene is damaged.
    pub fn scenes(self) -> Result<Vec<TestScene>, IoError> {
        let mut scenes = Vec::new();
        if matches!(self, Self::Natural | Self::All) {
            for scene in rendered::names() {
                scenes.push(stored(scene.name)?);
            }
        }
        if matches!(self, Self::Charts | Self::All) {
            scenes.extend(TestScene::charts());
        }
        Ok(scenes)
    }
}

/// A scene of a comparison by its name: a built-in scene, which is relit if it can be, or a file, which is relit with one sample per
/// pixel. A name without parameters selects a scene of the set `charts` in its size there.
///
/// # Errors
/// When a file cannot be read or relit, or a stored scene is damaged.
pub fn test_scene(name: &str, illuminant: &Illuminant) -> Result<TestScene, IoError> {
    if rendered::find(name).is_some() {
        return stored(name);
    }
    if !is_meant(name) {
        return Ok(TestScene::built_in(name));
    }
    let request = SceneRequest {
        luminance_cd_m2: Some(1.0),
        illuminant: Some(illuminant.clone()),
        read: ReadOptions::default(),
        ..SceneRequest::default()
    };
    Ok(TestScene::relit(name, scenes::load(name, &request)?))
}

/// A stored scene in its own light.
fn stored(name: &str) -> Result<TestScene, IoError> {
    let scene = scenes::load(name, &SceneRequest::default())?;
    TestScene::in_own_light(name, scene).at(Path::new(name))
}
