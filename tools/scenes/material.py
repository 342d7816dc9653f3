"""Materials: mixtures of measured reflectances whose shares come from a texture."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from . import spectra

_TEXTURES: dict[str, tuple[np.ndarray, np.ndarray, float]] = {}


class Palette(mi.Texture):  # type: ignore[misc]
    """Reflectance Σ wₖ(u, v) Rₖ(λ): the shares wₖ are a texture, the Rₖ are measured, λ is the centre of a band."""

    def __init__(self, props: Any) -> None:
        mi.Texture.__init__(self, props)
        shares, table, scale = _TEXTURES[props["key"]]
        self.shares = mi.Texture2f(mi.TensorXf(np.ascontiguousarray(shares, np.float32)), wrap_mode=dr.WrapMode.Repeat)
        self.count = shares.shape[2]
        self.scale = scale
        self.table = mi.Float(np.ascontiguousarray(table, np.float32).ravel())
        self.average = float((shares.reshape(-1, self.count).mean(axis=0) * table.mean(axis=0)).sum())

    def eval(self, si: Any, active: Any = True) -> Any:
        shares = self.shares.eval(si.uv * self.scale, active)
        bands = []
        for c in range(4):
            row = mi.UInt32(dr.round((si.wavelengths[c] - spectra.BANDS_NM[0]) / spectra.STEP_NM)) * self.count
            value = mi.Float(0)
            for k in range(self.count):
                value = dr.fma(shares[k], dr.gather(mi.Float, self.table, row + k, active), value)
            bands.append(value)
        return mi.UnpolarizedSpectrum(bands)

    def eval_1(self, si: Any, active: Any = True) -> Any:
        return mi.Float(self.average)

    def mean(self) -> Any:
        return mi.Float(self.average)

    def is_spatially_varying(self) -> bool:
        return True

    def to_string(self) -> str:
        return "Palette"


def texture(shares: np.ndarray | None, names: list[str], scale: float = 1.0, gain: float = 1.0) -> dict[str, Any]:
    """A texture of mixed reflectances. `shares` is rows × cols × materials, first row at v = 0; None is the first material."""
    if shares is None:
        shares = np.eye(1, len(names))[None]
    key = f"t{len(_TEXTURES)}"
    _TEXTURES[key] = (shares, spectra.table(names) * gain, scale)
    return {"type": "palette", "key": key}


def diffuse(shares: np.ndarray | None, names: list[str], scale: float = 1.0, gain: float = 1.0) -> dict[str, Any]:
    """A matt surface seen from both sides."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": texture(shares, names, scale, gain)}}


def plastic(shares: np.ndarray | None, names: list[str], alpha: float, scale: float = 1.0, gain: float = 1.0) -> dict[str, Any]:
    """A coloured base below a clear surface of refractive index 1.5 and a GGX roughness."""
    return {
        "type": "twosided",
        "bsdf": {
            "type": "roughplastic",
            "distribution": "ggx",
            "alpha": alpha,
            "int_ior": 1.5,
            "diffuse_reflectance": texture(shares, names, scale, gain),
        },
    }


def metal(kind: str, alpha: float) -> dict[str, Any]:
    """A rough metal with measured optical constants."""
    return {"type": "twosided", "bsdf": {"type": "roughconductor", "material": kind, "alpha": alpha, "distribution": "ggx"}}


def spectrum(values: np.ndarray) -> dict[str, Any]:
    """A spectrum of a lamp over the bands."""
    text = ",".join(f"{v:.7g}" for v in values)
    return {"type": "regular", "wavelength_min": 400.0, "wavelength_max": 700.0, "values": text}


def lamp(name: str, cd_m2: float) -> dict[str, Any]:
    """An emitting surface of a given luminance."""
    return {"type": "area", "radiance": spectrum(spectra.radiance(name, cd_m2))}


def register() -> None:
    """Makes the texture known to Mitsuba; the variant must be set before."""
    mi.register_texture("palette", Palette)
