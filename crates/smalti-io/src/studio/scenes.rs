//! The scenes of the studio.

/// Spectral components of scenes and of the training scene. They describe natural surfaces in daylight to a few thousandths.
pub const COMPONENTS: usize = 8;

/// A scene of the studio.
pub(super) struct StudioScene {
    pub(super) id: &'static str,
    /// Its name in the catalogue.
    pub(super) catalogue: &'static str,
    /// Its name for people.
    pub(super) name: &'static str,
}

impl StudioScene {
    const fn new(id: &'static str, catalogue: &'static str, name: &'static str) -> Self {
        Self { id, catalogue, name }
    }

    pub(super) fn is_photograph(&self) -> bool {
        self.catalogue.starts_with("photo-")
    }

    /// The name of its source, for a photograph.
    pub(super) fn source(&self) -> Option<String> {
        self.is_photograph().then(|| format!("{}.jpg", self.catalogue))
    }
}

/// The scenes. The first is shown first.
pub(super) static SCENES: [StudioScene; 5] = [
    StudioScene::new("brushes", "photo-brushes", "Paint brushes"),
    StudioScene::new("spices", "photo-spices", "Spices"),
    StudioScene::new("dahlia", "photo-dahlia", "Dahlia"),
    StudioScene::new("colorchecker", "macbeth", "ColorChecker"),
    StudioScene::new("leaves", "dead-leaves", "Dead leaves"),
];

/// The name in the catalogue of a scene of the studio.
#[must_use]
pub fn catalogue_name(id: &str) -> Option<&'static str> {
    SCENES.iter().find(|scene| scene.id == id).map(|scene| scene.catalogue)
}
