"""Simulates a camera, from a spectral scene to a scored picture, to design colour filter arrays and their processing together.

    >>> import smalti
    >>> camera = smalti.Camera("rgbw", set={"sensor.pixel.pitch_um": 1.4})
    >>> photo = camera.photograph(smalti.Scene("macbeth", luminance_cd_m2=10.0))
    >>> photo.picture.write("macbeth.png")

Objects are values: none changes after it is made. Arrays that they give are views of what they hold, not writeable, with no copy
made; arrays that they are given are copied once. Images are [rows, columns, wavelengths or channels]; numbers carry their unit in
their name. What cannot be computed raises `SmaltiError` (a ValueError) in the words of the `smalti` command.
"""

from ._smalti import (
    Camera,
    Cfa,
    Image,
    OpticalImage,
    Photograph,
    RawImage,
    Scene,
    SmaltiError,
    Spectrum,
    __version__,
    cameras,
    cfas,
    filters,
    illuminant,
    illuminants,
    scenes,
)

__all__ = [
    "Camera",
    "Cfa",
    "Image",
    "OpticalImage",
    "Photograph",
    "RawImage",
    "Scene",
    "SmaltiError",
    "Spectrum",
    "__version__",
    "cameras",
    "cfas",
    "filters",
    "illuminant",
    "illuminants",
    "scenes",
]
