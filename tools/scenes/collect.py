"""Writes data/reflectances.csv and data/lights.csv from the published sources (see README.md).

    python -m scenes collect --usgs usgs_indoor_d1.json --skin M38597.csv --veg earthlib/data

Needs colour-science. Everything becomes means over 31 bands of 10 nm, 400 to 700 nm.
"""

import csv
import json
import pathlib
import warnings

import numpy as np

DATA = pathlib.Path(__file__).resolve().parent / "data"
BANDS_NM = np.arange(400.0, 701.0, 10.0)

USGS = """Aluminum brushed 293K|Asphalt GDS376 Blck Road old|Asphalt Shingle GDS367 DkGry|Asphalt Tar GDS346 Blck Roof
Bone black GDS808|Brick GDS347 Paving Tan|Brick GDS348 Pave DkBrwngrey|Brick GDS349 Paving Red
Brick GDS350 Dk Red Building|Brick GDS353 Building MedRed|Brick GDS354 Building Lt Gry|Brick GDS355 Paving Dk Gry
Brilliant(Hansa)yellowGDS785|Burlap Fabric GDS430 Brown|Burnt umber GDS811|Cadmium orange 0 GDS786|Cadmium red 2 GDS778
Cadmium yellow 6 med GDS788|Cardboard GDS371 Brn Corgted|Cedar Shake GDS357 Fresh|Cedar Shake GDS359 MedWeathr
Cedar Shake GDS360 H Weamoss|Cedar Shake GDS361 HiWeather|Cerulean blue GDS797|Cinder Block GDS356 Lg Grey
Cobalt blue GDS790|Cobalt green GDS816|Cobalt violet GDS803|Concrete GDS375 Lt Gry Road|Concrete WTC01-37A
Cotton Fabric GDS437 White|GalvanizedSheetMetal GDS334|Iron oxide #4820 GDS782|Italian burnt sienna GDS812
Italian nat sienna GDS805|Lead White GDS796|Manganese violet GDS804|Naples yellow GDS787|Natural umber GDS809 (raw)
Nylon Carpet GDS535 LtBrown|Nylon Carpet GDS536 Gry Pile|Nylon Fabric GDS431 Red RpSt|Nylon Fabric GDS432 Grn RpSt
Nylon Fabric GDS433 Blu RpSt|Nylon Fabric GDS436 BlkCoatd|Nylon Webbing GDS428 OlvDrab|Nylon Webbing GDS438 Flr Yel
Oxide of chromium GDS795|Painted Aluminum GDS333 LgGr|Paper Cotton Bond PAPR1 100%|Phthalocyaninie blue GDS799
Plastic HDPE GDS351 BlkSheet|Plastic HDPE GDS384 Wht Opaq|Plastic HDPE GDS386 Yelopaqu|Plastic HDPE GDS391 Blu-Grn
Plastic Pipe GDS344 Blue|Plastic PVC GDS338 White|Plastic Tarp GDS339 Green|Plastic Tarp GDS340 Blu Wovn
Plastic Vinyl GDS372 White|Plastic Vinyl GDS398 Red Toy|Plywood GDS365 Fresh Pine|Polyester Pile GDS434 Blk
Polyester Pile GDS435 DkGrn|Prussian blue GDS802|Roofing Felt GDS377 Black|Rusted Tin Can GDS378 MV99-6
Terra Pozzuoli GDS806|Terrycloth Fabric GDS537 Yel|Titanium dioxide GDS798 TiO2|Ultramarine GDS791 sy vdark
Venetian red GDS783|Vermillion GDS779|Viridian GDS800|Wood Beam GDS363 Nw Pine 2X4|Yellow ochre GDS794 Germany"""
VEGETATION = ["Grass_dry.8+.2green", "Grass_dry.9+.1green", "Sagebrush", "Willow"]
# USGS splib07a record 21373, Lawn_Grass GDS91 green (Beckman), 400 to 700 nm.
LAWN = [
    0.025,
    0.0283,
    0.0298,
    0.031,
    0.0312,
    0.0355,
    0.0365,
    0.0366,
    0.0365,
    0.0367,
    0.0391,
    0.0457,
    0.0619,
    0.0832,
    0.0939,
    0.0969,
    0.0949,
    0.0855,
    0.0729,
    0.0668,
    0.0638,
    0.0608,
    0.0558,
    0.0531,
    0.0501,
    0.0452,
    0.0427,
    0.0391,
    0.0382,
    0.049,
    0.0914,
]
SKIN_SUBJECTS = [3, 5, 12, 17, 24, 36, 48, 55, 61, 74, 83, 97]
LIGHTS = [
    "D65",
    "D50",
    "A",
    "LED-B1",
    "LED-B2",
    "LED-B3",
    "LED-B4",
    "LED-B5",
    "LED-BH1",
    "LED-RGB1",
    "LED-V1",
    "HP1",
    "HP2",
    "HP5",
    "FL3.12",
    "FL3.14",
    "FL11",
]
LAMPS = ["Mercury", "Metal Halide", "C100S54 (HPS)", "MHC100/U/MP/4K", "H38JA-100/DX (Mercury DX)"]


def band_means(wavelength_nm: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Means over the bands of a densely interpolated spectrum."""
    fine = np.arange(395.0, 705.05, 0.1)
    dense = np.interp(fine, wavelength_nm, values)
    return np.array([dense[(fine >= b - 5) & (fine < b + 5)].mean() for b in BANDS_NM])


# Lines 2p → 1s of Ne I: wavelength (nm), statistical weight and energy (eV) of the upper level, transition probability (10⁶ s⁻¹).
NEON = [
    (540.056, 1, 18.966, 0.90),
    (585.249, 1, 18.966, 61.5),
    (588.190, 3, 18.726, 11.5),
    (594.483, 5, 18.704, 11.3),
    (597.553, 3, 18.693, 3.51),
    (603.000, 3, 18.726, 5.61),
    (607.434, 1, 18.711, 60.3),
    (609.616, 5, 18.704, 18.1),
    (614.306, 5, 18.637, 28.2),
    (616.359, 3, 18.726, 14.6),
    (621.728, 3, 18.613, 6.37),
    (626.650, 3, 18.693, 24.9),
    (630.479, 5, 18.637, 4.16),
    (633.443, 5, 18.576, 16.1),
    (638.299, 3, 18.613, 32.1),
    (640.225, 7, 18.555, 51.5),
    (650.653, 5, 18.576, 30.0),
    (653.288, 3, 18.613, 10.8),
    (659.895, 3, 18.726, 23.2),
    (667.828, 5, 18.704, 23.3),
    (671.704, 3, 18.693, 21.7),
    (692.947, 5, 18.637, 17.4),
    (702.405, 3, 18.613, 1.89),
    (703.241, 3, 18.382, 26.6),
]


def neon() -> np.ndarray:
    """Power of the neon lines in each band, optically thin, with the upper levels populated at 1 eV.

    The relative intensities of line lists are not radiometric: they make a sign yellow.
    """
    out = np.zeros(len(BANDS_NM))
    for line_nm, weight, energy_ev, rate in NEON:
        out[int(np.floor((line_nm - 395.0) / 10.0))] += weight * rate / line_nm * np.exp(-(energy_ev - 18.4))
    return out


def write(path: pathlib.Path, comment: str, rows: list[tuple[str, str, np.ndarray]]) -> None:
    head = "name,source," + ",".join(f"{b:.0f}" for b in BANDS_NM)
    lines = [f"# {line}" for line in comment.splitlines()] + [head]
    lines += [f'"{n}",{s},' + ",".join(f"{v:.4f}" for v in values) for n, s, values in rows]
    path.write_text("\n".join(lines) + "\n")


def collect(usgs: pathlib.Path, skin: pathlib.Path, veg: pathlib.Path) -> None:
    warnings.simplefilter("ignore")
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017

    rows: list[tuple[str, str, np.ndarray]] = []
    library = json.loads(usgs.read_text())["spectra"]
    for name in USGS.replace("\n", "|").split("|"):
        # Means over the bands of a curve sampled every 10 nm would smooth it again: the samples are taken as they are.
        rows.append((name, "usgs", np.array(library[name]["reflectance"][:31])))
    rows.append(("Lawn grass GDS91", "usgs", np.array(LAWN)))
    names = [r["NAME"] for r in csv.DictReader((veg / "spectra.csv").open())]
    notes = [r["NOTES"] for r in csv.DictReader((veg / "spectra.csv").open())]
    table = np.fromfile(veg / "spectra.sli", "<f4").reshape(len(names), -1)
    for name in VEGETATION:
        i = next(i for i, n in enumerate(names) if n == name and notes[i] == "usgs")
        rows.append((name, "usgs", table[i, :31]))
    lines = list(csv.reader(skin.open(encoding="latin-1")))
    start = next(i for i, line in enumerate(lines) if line and line[0] == "250")
    values = np.array([[float(v) for v in line[:401]] for line in lines[start : start + 751] if line and line[0]])
    for s in SKIN_SUBJECTS:
        rows.append((f"Skin {s}", "nist", band_means(values[:, 0], values[:, 4 * s])))
    tcs = load_TCS_CIE2017(colour.SpectralShape(380, 780, 5))
    for i in range(99):
        rows.append((f"TCS {i + 1}", "cie224", band_means(tcs.wavelengths, tcs.values[:, i])))
    write(DATA / "reflectances.csv", "Reflectance in bands of 10 nm. Sources: see README.md.", rows)
    lights = []
    for name in LIGHTS:
        s = colour.SDS_ILLUMINANTS[name]
        lights.append((name, "cie15", band_means(s.wavelengths, s.values)))
    for name in LAMPS:
        s = colour.SDS_LIGHT_SOURCES[name]
        lights.append((name, "lamp", band_means(s.wavelengths, s.values)))
    lights.append(("Neon", "nist-asd", neon()))
    write(
        DATA / "lights.csv",
        "Relative spectral power in bands of 10 nm, largest 1. Sources: see README.md.",
        [(n, s, v / v.max()) for n, s, v in lights],
    )
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    write(
        DATA / "observer.csv",
        "Means of the CIE 1931 2° colour matching functions over the bands.",
        [(n, "cie", band_means(observer.wavelengths, observer.values[:, i])) for i, n in enumerate("XYZ")],
    )
