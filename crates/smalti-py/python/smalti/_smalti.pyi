import os
from collections.abc import Callable, Sequence
from typing import Any, Final, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path = str | os.PathLike[str]
_Light = str | Spectrum
_Filter = Spectrum | str | float | dict[str, Any]
_White = tuple[float, float, float] | list[float]
_Region = tuple[int, int, int, int]
_Noise = Literal["all", "shot", "none"]
_Space = Literal["xyz", "linear-srgb", "srgb", "linear-display-p3", "display-p3"]
_Told = Callable[[int], object] | None
_ToldOfSteps = Callable[[int, int], object] | None

__version__: str

class SmaltiError(ValueError): ...

@final
class Spectrum:
    def __new__(cls, values: ArrayLike, wavelengths_nm: ArrayLike | None = None) -> Spectrum: ...
    @staticmethod
    def read(path: _Path) -> Spectrum: ...
    values: Final[NDArray[np.float64]]
    wavelengths_nm: Final[NDArray[np.float64]]
    def at(self, wavelength_nm: float) -> float | None: ...
    def integral(self) -> float: ...
    def resampled(
        self, wavelengths_nm: ArrayLike, outside: Literal["error", "zero", "hold"] = "error"
    ) -> Spectrum: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: None  # type: ignore[assignment]

@final
class Cfa:
    def __new__(
        cls,
        pattern: str | Sequence[str],
        filters: dict[str, _Filter] | None = None,
        wavelengths_nm: ArrayLike | None = None,
        name: str | None = None,
    ) -> Cfa: ...
    @staticmethod
    def from_arrays(
        tile: ArrayLike,
        transmittances: ArrayLike,
        wavelengths_nm: ArrayLike | None = None,
        channel_names: Sequence[str] | None = None,
        name: str = "custom",
    ) -> Cfa: ...
    name: Final[str]
    tile: Final[NDArray[np.uint8]]
    letters: Final[list[str] | None]
    channel_names: Final[list[str]]
    channels: Final[dict[str, Spectrum]]
    wavelengths_nm: Final[NDArray[np.float64]]
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: None  # type: ignore[assignment]
    def _repr_svg_(self) -> str: ...

@final
class Scene:
    def __new__(
        cls,
        source: _Path,
        *,
        luminance_cd_m2: float | None = None,
        illuminant: _Light | None = None,
        distance_m: float | None = None,
        fov_deg: float | None = None,
        wavelengths_nm: ArrayLike | None = None,
        quantity: Literal["photons", "energy", "relative-energy", "reflectance"] | None = None,
        variable: str | None = None,
        crop: tuple[int, int, int, int] | None = None,
        clamp_negative: bool = False,
        upsampling: Literal["smooth", "measured"] | None = None,
    ) -> Scene: ...
    @staticmethod
    def from_radiance(
        radiance: ArrayLike,
        wavelengths_nm: ArrayLike | None = None,
        *,
        unit: Literal["photons", "energy", "relative-energy"] = "photons",
        illuminant: _Light | None = None,
        luminance_cd_m2: float | None = None,
        distance_m: float = 1.2,
        fov_deg: float | None = None,
        name: str = "array",
    ) -> Scene: ...
    @staticmethod
    def from_reflectance(
        reflectance: ArrayLike,
        wavelengths_nm: ArrayLike | None = None,
        *,
        illuminant: _Light | None = None,
        luminance_cd_m2: float = 100.0,
        distance_m: float = 1.2,
        fov_deg: float | None = None,
        name: str = "array",
    ) -> Scene: ...
    radiance: Final[NDArray[np.float32]]
    illuminant_photons: Final[Spectrum]
    wavelengths_nm: Final[NDArray[np.float64]]
    shape: Final[tuple[int, int, int]]
    name: Final[str]
    distance_m: Final[float]
    fov_deg: Final[float]
    mean_luminance_cd_m2: Final[float]
    def luminance_cd_m2(self) -> NDArray[np.float32]: ...
    def xyz(self) -> Image: ...
    def relit(self, illuminant: _Light) -> Scene: ...
    def replaced(
        self,
        *,
        luminance_cd_m2: float | None = None,
        distance_m: float | None = None,
        fov_deg: float | None = None,
    ) -> Scene: ...
    def resampled(self, wavelengths_nm: ArrayLike) -> Scene: ...
    def cropped(self, row: int, col: int, rows: int, cols: int) -> Scene: ...
    def write(
        self, path: _Path, layout: Literal["fichet2021", "pbrt", "v5", "v7.3", "pages", "samples"] | None = None
    ) -> None: ...
    def _repr_png_(self) -> bytes: ...

@final
class OpticalImage:
    def __new__(
        cls, irradiance: ArrayLike, sample_spacing_m: float, wavelengths_nm: ArrayLike | None = None
    ) -> OpticalImage: ...
    irradiance: Final[NDArray[np.float32]]
    wavelengths_nm: Final[NDArray[np.float64]]
    sample_spacing_m: Final[float]
    shape: Final[tuple[int, int, int]]
    def scaled(self, factor: float) -> OpticalImage: ...
    def illuminance_lux(self) -> NDArray[np.float32]: ...

@final
class RawImage:
    def __new__(
        cls,
        samples: ArrayLike,
        tile: ArrayLike | Cfa | None = None,
        *,
        black_level: float,
        white_level: float,
        channel_names: Sequence[str] | None = None,
    ) -> RawImage: ...
    @staticmethod
    def read(path: _Path, *, cfa: str | None = None) -> RawImage: ...
    def write(self, path: _Path) -> None: ...
    samples: Final[NDArray[np.uint16] | NDArray[np.float32]]
    def normalized(self) -> NDArray[np.float32]: ...
    tile: Final[NDArray[np.uint8] | None]
    shape: Final[tuple[int, ...]]
    channel_names: Final[list[str]]
    black_level: Final[float]
    white_level: Final[float]
    unit: Final[str]
    saturated_percent: Final[float]
    notes: Final[list[str]]
    def with_channels(self, names: Sequence[str]) -> RawImage: ...

@final
class Image:
    def __new__(cls, array: ArrayLike, space: _Space = "srgb", white: _White | None = None) -> Image: ...
    @staticmethod
    def read(path: _Path) -> Image: ...
    def write(self, path: _Path, bits: Literal[8, 16] = 8) -> None: ...
    array: Final[NDArray[np.float32]]
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...
    space: Final[_Space]
    shape: Final[tuple[int, int, int]]
    white: Final[list[float] | None]
    def converted(self, space: _Space) -> Image: ...
    def brightness_gain(self) -> float: ...
    def shown(self, gain: float | None = None) -> Image: ...
    def to_uint8(self) -> NDArray[np.uint8]: ...
    def _repr_png_(self) -> bytes: ...

@final
class Camera:
    def __new__(
        cls, source: _Path, set: dict[str, Any] | None = None, wavelengths_nm: ArrayLike | None = None
    ) -> Camera: ...
    @staticmethod
    def from_toml(
        text: str,
        set: dict[str, Any] | None = None,
        wavelengths_nm: ArrayLike | None = None,
        folder: _Path | None = None,
    ) -> Camera: ...
    name: Final[str]
    description: Final[dict[str, Any]]
    notes: Final[list[str]]
    def to_toml(self) -> str: ...
    cfa: Final[Cfa]
    shape: Final[tuple[int, int]]
    pitch_m: Final[float]
    wavelengths_nm: Final[NDArray[np.float64]]
    def spectral_responsivity(self) -> NDArray[np.float64]: ...
    def with_cfa(self, cfa: Cfa) -> Camera: ...
    def with_size(self, rows: int, cols: int) -> Camera: ...
    def fitted(self, scene: Scene) -> Scene: ...
    def optical_image(self, scene: Scene) -> OpticalImage: ...
    def exposure_time_s(self, optical_image: OpticalImage) -> float: ...
    def capture(
        self, optical_image: OpticalImage, *, noise: _Noise = "all", seed: int = 1, time_s: float | None = None
    ) -> RawImage: ...
    def render(
        self, raw: RawImage, illuminant: Scene | _Light, *, white_balance: Literal["none", "camera"] = "none"
    ) -> Image: ...
    def reference(
        self, optical_image: OpticalImage, illuminant: Scene | _Light, *, time_s: float | None = None
    ) -> Image: ...
    def photograph(
        self,
        scene: Scene,
        *,
        noise: _Noise = "all",
        seed: int = 1,
        full_frame: bool = False,
        pipeline: Pipeline | None = None,
    ) -> Photograph: ...
    def _repr_svg_(self) -> str: ...

@final
class Photograph:
    optical_image: Final[OpticalImage]
    raw: Final[RawImage]
    picture: Final[Image]
    exposure_time_s: Final[float]
    def reference(self) -> Image: ...
    def scores(self) -> dict[str, Any] | None: ...
    def _repr_png_(self) -> bytes: ...

@final
class Pipeline:
    @staticmethod
    def read(path: _Path) -> Pipeline: ...
    def write(self, path: _Path, *, arithmetic: Literal["integers", "float"] = "integers") -> None: ...
    def at_quality(self, quality: Literal["fast", "best"]) -> Pipeline: ...
    quality: Final[Literal["fast", "best"]]
    def render(self, raw: RawImage, *, fixed_point: bool = False) -> Image: ...
    def render_outputs(
        self, raw: RawImage, *, fixed_point: bool = False
    ) -> tuple[NDArray[np.float32], dict[str, int]]: ...
    outputs: Final[list[str]]
    channel_names: Final[list[str]]
    white: Final[list[float] | None]
    weights: Final[NDArray[np.float32]]
    offsets: Final[NDArray[np.float32]]
    textures: Final[list[str]]
    provenance: Final[dict[str, Any]]
    def classes(self) -> list[dict[str, Any]]: ...

@final
class Statistics:
    @staticmethod
    def read(path: _Path) -> Statistics: ...
    def write(self, path: _Path) -> None: ...
    def merged(self, other: Statistics) -> Statistics: ...
    patches: Final[int]
    outputs: Final[list[str]]

@final
class Evaluation:
    delta_e_2000: Final[float]
    delta_e_76: Final[float]
    mtf50_cy_per_mm: Final[float]
    mtf50_cy_per_px: Final[float]
    mtf50_reliability: Final[Literal["reliable", "beyond-nyquist", "plateau", "no-edge"]]
    mtf50_low_contrast_cy_per_mm: Final[float]
    vora_value: Final[float]
    sensitivity_metamerism_index: Final[float]
    metamer_mismatch_percent: Final[float]
    luminance_noise_percent: Final[float]
    visual_snr: Final[float]
    aliasing_percent: Final[float]
    saturated_percent: Final[float]
    dynamic_range_db: Final[float]
    def to_dict(self) -> dict[str, Any]: ...
    pictures: Final[dict[str, Image]]
    aliasing: Final[NDArray[np.float32]]

@final
class SceneScores:
    def to_dict(self) -> dict[str, Any]: ...
    cpsnr_db: Final[float]
    pixel_delta_e_2000_mean: Final[float]
    scielab_mean: Final[float]
    picture: Final[Image]
    reference: Final[Image]

@final
class EdgeResponse:
    frequency_cy_per_px: Final[NDArray[np.float64]]
    sfr: Final[NDArray[np.float64]]
    mtf50_cy_per_px: Final[float | None]
    mtf50_reliability: Final[Literal["reliable", "beyond-nyquist", "plateau"] | None]
    def mtf50_cy_per_mm(self, pitch_m: float) -> float | None: ...
    def frequency_at(self, level: float) -> float | None: ...
    aliasing_percent: Final[float]
    edge_angle_deg: Final[float]
    contrast: Final[float]
    esf: Final[NDArray[np.float64]]

@final
class Study:
    def __new__(cls, source: _Path) -> Study: ...
    @staticmethod
    def from_toml(text: str, folder: _Path | None = None) -> Study: ...
    name: Final[str]
    about: Final[str]
    description: Final[dict[str, Any]]
    def cfa(self, trial: int) -> Cfa: ...
    def __len__(self) -> int: ...

@final
class Results:
    def __new__(cls, dir: _Path) -> Results: ...
    dir: Final[os.PathLike[str]]
    complete: Final[bool]
    study: Final[dict[str, Any]]
    columns: Final[dict[str, tuple[str, str]]]
    def camera(self, trial: int) -> Camera: ...
    def read(self, names: Sequence[str] | None = None) -> dict[str, Any]: ...
    def to_pandas(self, names: Sequence[str] | None = None) -> Any: ...
    def verify(self) -> None: ...
    def __len__(self) -> int: ...

def illuminant(name: str, wavelengths_nm: ArrayLike | None = None) -> Spectrum: ...
def illuminants() -> list[str]: ...
def cfas() -> list[str]: ...
def filters() -> list[str]: ...
def scenes() -> dict[str, str]: ...
def cameras() -> dict[str, str]: ...
def designs() -> dict[str, str]: ...
def studies() -> dict[str, str]: ...
def test_scenes() -> list[str]: ...
def metrics() -> list[dict[str, Any]]: ...
def delta_e(
    lab1: ArrayLike, lab2: ArrayLike, method: Literal["2000", "1994", "1976"] = "2000"
) -> NDArray[np.float64]: ...
def lab_from_xyz(xyz: ArrayLike, white: _White) -> NDArray[np.float64]: ...
def xyz_from_lab(lab: ArrayLike, white: _White) -> NDArray[np.float64]: ...
def scielab(
    picture: Image,
    reference: Image,
    white: _White,
    samples_per_degree: float = 60.0,
    method: Literal["1976", "1994", "2000"] = "1976",
) -> NDArray[np.float32]: ...
def score_picture(
    picture: Image, reference: Image, *, samples_per_degree: float = 60.0, highlight_share: float = 0.005
) -> dict[str, float]: ...
def edge_sfr(
    image: ArrayLike | Image | RawImage,
    *,
    plane: int | None = None,
    region: _Region | None = None,
    isetcam: bool = False,
) -> EdgeResponse: ...
def luminance_noise_percent(
    luminance: ArrayLike | Image, patches: Sequence[_Region]
) -> NDArray[np.float64]: ...
def cpsnr_db(
    image: ArrayLike | Image,
    reference: ArrayLike | Image,
    *,
    peak: float = 1.0,
    region: _Region | None = None,
) -> float: ...
def aliasing(
    picture: ArrayLike | Image, reference: ArrayLike | Image, luminance_weights: Sequence[float] = ...
) -> dict[str, float]: ...
def visual_snr(picture: Image, region: _Region, white: _White, samples_per_degree: float = 60.0) -> float: ...
def evaluate(
    camera: Camera,
    *,
    luminance_cd_m2: float = 75.0,
    illuminant: _Light | None = None,
    pipeline: Pipeline | None = None,
    seed: int = 1,
    cache: bool = True,
) -> Evaluation: ...
def score_scenes(
    camera: Camera,
    *,
    scenes: Sequence[str | Scene] | None = None,
    luminances_cd_m2: Sequence[float] = ...,
    illuminant: _Light | None = None,
    pipeline: Pipeline | None = None,
    seed: int = 1,
    progress: _Told = None,
) -> list[SceneScores]: ...
def merge(folders: Sequence[_Path], out: _Path) -> None: ...
def analyse_ratings(folder: _Path, *, keep_all: bool = False) -> dict[str, Any]: ...

# What `_long` and `_command` are made of.
def run_command(args: list[str]) -> int: ...
def write_report(
    results: list[_Path], output: _Path | None, pictures: int, picture: list[int], draw: list[str], progress: _Told
) -> dict[str, Any]: ...
def light_gain(
    camera: Camera,
    other: Camera,
    pipelines: tuple[Pipeline | None, Pipeline | None],
    scenes: list[str] | None,
    luminance_cd_m2: float,
    illuminant: _Light | None,
    seed: int,
    progress: _Told,
) -> dict[str, Any]: ...
def compare(
    cameras: list[Camera],
    pipelines: list[Pipeline | None],
    processing: list[str],
    scenes: str | list[str | Scene],
    luminances_cd_m2: list[float],
    illuminant: _Light | None,
    exposure: tuple[float | str, float, float],
    training_set: str,
    seeds: tuple[int, int],
    cache: bool,
    progress: _ToldOfSteps,
) -> tuple[list[dict[str, Any]], dict[str, Any]]: ...
@final
class DesignSearch:
    def __new__(
        cls,
        source: _Path,
        scenes: list[Scene] | None,
        training_set: str,
        resume: _Path | None,
        light: list[bytes] | None,
        progress: _ToldOfSteps,
    ) -> DesignSearch: ...
    def light(self) -> list[bytes]: ...
    def hash(self) -> str: ...
    def known(self) -> list[str]: ...
    def add(self, line: str) -> None: ...
    def open_parts(self) -> list[str]: ...
    def search(self, part: str, known: list[str]) -> str: ...
    def find(self, progress: _ToldOfSteps) -> tuple[dict[str, Any], Camera, list[tuple[str, Camera]], list[Camera]]: ...

@final
class TrainingRecord: ...

def gather_statistics(
    camera: Camera,
    scenes: list[Scene] | None,
    pairs: list[tuple[RawImage, Image]] | None,
    align: bool,
    illuminants: list[_Light],
    target: Literal["xyz"] | Camera,
    target_illuminant: _Light | None,
    exposures: list[float],
    patch: int,
    levels: int,
    level_rule: str,
    textures: str,
    sharp: bool,
    training_set: str,
    seed: int,
    progress: _ToldOfSteps,
) -> tuple[Statistics, TrainingRecord]: ...
def solve_statistics(
    statistics: Statistics,
    story: TrainingRecord | None,
    solver: str,
    alpha_flat: tuple[float, float] | None,
    alpha_texture: tuple[float, float] | None,
    linear: bool,
    symmetry: bool,
    smoothing: float,
    quality: str,
) -> Pipeline: ...
def refine_pipeline(
    pipeline: Pipeline,
    camera: Camera,
    scenes: list[Scene] | None,
    pairs: list[tuple[RawImage, Image]] | None,
    align: bool,
    illuminants: list[_Light],
    target_illuminant: _Light | None,
    exposures: list[float],
    sharp: bool,
    training_set: str,
    seed: int,
    progress: _ToldOfSteps,
) -> Pipeline: ...
def scenes_in_files(study: Study) -> bytes: ...
@final
class PartMaker:
    def __new__(cls, manifest: str, scenes: bytes, cache: bool) -> PartMaker: ...
    def name(self, part: int) -> str: ...
    def encode(self, part: int) -> bytes: ...
    def write(self, part: int, dir: _Path) -> int: ...

@final
class SharedFolder:
    def __new__(cls, study: Study, out: _Path, part_size: int | None) -> SharedFolder: ...
    def manifest(self) -> str: ...
    def missing(self) -> list[int]: ...
    def trials_of(self, part: int) -> int: ...
    def adopt(self, part: int) -> None: ...
    def finish(self, seconds: float, threads: int) -> None: ...
    def close(self) -> None: ...

@final
class SharedPlace:
    def __new__(
        cls, study: Study, place: _Path, part_size: int | None, names: list[str], manifest: bytes | None
    ) -> SharedPlace: ...
    def manifest(self) -> str: ...
    def missing(self, names: list[str]) -> list[int]: ...
    def trials_of(self, part: int) -> int: ...
    def with_run(self, manifest: bytes, parts: int, trials: int, seconds: float, threads: int) -> str: ...

def run_sweep(
    study: Study, out: _Path, shard: tuple[int, int] | None, part_size: int | None, cache: bool, progress: _ToldOfSteps
) -> tuple[int, float, int]: ...
def parse_shard(text: str) -> tuple[int, int]: ...
