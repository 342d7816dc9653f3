#!/usr/bin/env python3
"""Measures the figures of docs/l3.md and prints them as tables, section by section.

    cargo build --release -p smalti-cli
    python3 tools/measure_l3.py target/release/smalti target/l3 [SECTION …]

Each section is one or more runs of the command, whose results stay in the given folder and are used again by a later run of this script. Only the
section `kinds` needs more than the built-in scenes: --spectral FILE names a spectral image of one's own. The section `greys` needs NumPy.
"""

import argparse
import json
import pathlib
import shlex
import subprocess

FOLDER = pathlib.Path()
SMALTI = ""
SLIDES = "bayer rgbw clarity kodak wang rgbcmy medical"
CLASSIC = "--processing l3,bilinear,malvar2004,hamilton-adams1997"
METRICS = {"cpsnr_db": "CPSNR, dB", "pixel_delta_e_2000_mean": "ΔE2000", "scielab_mean": "S-CIELAB"}


def smalti(*words: str) -> None:
    """Runs the command and says which."""
    print("    $ smalti", *[shlex.quote(w) if "?" in w or "{" in w else w for w in words], flush=True)
    subprocess.run([SMALTI, *words], check=True, capture_output=True)


def compare(name: str, words: str) -> dict:
    """The results of a comparison, from its folder if it was run before."""
    out = FOLDER / name
    if not (out / "results.json").exists():
        smalti("compare", *shlex.split(words), "-o", str(out))
    return json.loads((out / "results.json").read_text())


def rows(results: dict) -> list[dict]:
    """The rows of the first table: camera, processing and light, with the scores that are shown."""
    out = []
    for r in results["results"]:
        t = r["targets"]
        out.append(
            {
                "camera": r["camera"],
                "pipeline": r["pipeline"],
                "light": r["luminance_cd_m2"],
                "cpsnr": f"{r['cpsnr_db']:.2f}",
                "de": f"{r['pixel_delta_e_2000_mean']:.2f}",
                "scielab": f"{r['scielab_mean']:.2f}",
                "mtf50": f"{t['mtf50_cy_per_mm']:.1f}",
                "snr": f"{t['visual_snr']['median']:.3f}",
                "noise": f"{t['luminance_noise_percent']['mean']:.1f}",
                "scenes": r["scenes"],
            }
        )
    return out


def table(head: list[str], body: list[list[str]]) -> None:
    """A table in Markdown."""
    print()
    for line in (head, ["---"] * len(head), *body):
        print("| " + " | ".join(line) + " |")
    print()


def estimate(e: dict) -> str:
    """A difference with its interval, bold where the interval excludes 0."""
    value = f"{e['value']:+.2f}".replace("-", "−")
    if e["interval"] is None:
        return value
    low, high = e["interval"]["low"], e["interval"]["high"]
    value = f"**{value}**" if low * high > 0 else value
    return f"{value} [{low:.2f}, {high:.2f}]".replace("-", "−")


def metrics(results: dict, light: int) -> dict[str, dict]:
    """The verdict at a light by metric."""
    return {m["metric"]: m for m in results["verdict"]["lights"][light]["metrics"]}


def rgbw() -> None:
    """RGBW against Bayer: scores, differences, stops."""
    runs = {
        (scenes, solver): compare(f"rgbw-{scenes}-{solver}", f"bayer rgbw --luminance 1,80 --light-gain --scenes {scenes} --solver {solver}")
        for scenes in ("natural", "charts")
        for solver in ("wiener", "perceptual")
    }
    body, differences = [], []
    for k, light in enumerate(("1", "80")):
        for solver in ("wiener", "perceptual"):
            pair = [[r for r in rows(runs[s, solver]) if r["light"] == float(light)] for s in ("natural", "charts")]
            for n, c in zip(*pair):
                both = [f"{n[key]} · {c[key]}" for key in ("cpsnr", "de", "scielab")]
                body.append([light, solver, n["camera"], *both, n["mtf50"], n["snr"], n["noise"]])
            for scenes in ("natural", "charts"):
                of = metrics(runs[scenes, solver], k)
                differences.append([light, solver, scenes, *[estimate(of[m]["from_first"][1]) for m in METRICS]])
    head = ["cd/m²", "solver", "camera", "CPSNR dB, natural · charts", "ΔE2000", "S-CIELAB", "MTF50 cy/mm", "visual SNR", "noise %"]
    table(head, body)
    table(["cd/m²", "solver", "scenes", *METRICS.values()], differences)
    columns = [(k, solver) for k in range(2) for solver in ("wiener", "perceptual")]
    stops = []
    for name in ("cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean", "visual_snr", "luminance_noise_percent"):
        line = [name]
        for k, solver in columns:
            found = []
            for scenes in ("natural", "charts"):
                gain = next(m["gain"] for m in runs[scenes, solver]["light_gains"][k]["gains"]["metrics"] if m["metric"] == name)
                found.append(f"{gain['stops']:+.2f}".replace("-", "−") if "stops" in gain else "–")
            line.append(" · ".join(found) if found[0] != found[1] else found[0])
        stops.append(line)
    table(["metric, stops, natural · charts", "1 cd/m², wiener", "1, perceptual", "80, wiener", "80, perceptual"], stops)
    for (scenes, solver), r in runs.items():
        lead = metrics(r, 0)["cpsnr_db"]["leads"]
        print(f"interval of the CPSNR lead at 1 cd/m² in stops, {scenes}, {solver}:", lead[0]["light"] or lead[1]["light"])


def curve() -> None:
    """RGBW − Bayer against light."""
    r = compare("curve", "bayer rgbw --luminance 0.3,1,3,10,30,80")
    body = []
    for k, light in enumerate(r["verdict"]["lights"]):
        of = metrics(r, k)
        worth = next((m["light"] for m in of["cpsnr_db"]["leads"] if m["light"]), None)
        stops = f"{worth['stops']['value']:.2f}" if worth and "stops" in worth and of["cpsnr_db"]["best"] == 1 else "–"
        differences = [estimate(of[m]["from_first"][1]) for m in METRICS]
        body.append([f"{light['luminance_cd_m2']:g}", differences[0], stops, *differences[1:]])
    table(["cd/m²", "CPSNR, dB", "worth, stops", "ΔE2000", "S-CIELAB"], body)


def score_table(results: dict, first: str = "camera") -> None:
    """The first table of a comparison."""
    body = [[f"{r['light']:g}", r[first], r["cpsnr"], r["de"], r["scielab"], r["mtf50"], r["snr"], r["noise"]] for r in rows(results)]
    body.sort(key=lambda line: float(line[0]))
    table(["cd/m²", first, "CPSNR dB", "ΔE2000", "S-CIELAB", "MTF50 cy/mm", "visual SNR", "noise %"], body)


def cameras() -> None:
    """All mosaics of the slides."""
    r = compare("cameras", f"{SLIDES} --luminance 1,80")
    score_table(r)
    names = SLIDES.split()
    for k, light in enumerate(r["verdict"]["lights"]):
        of = metrics(r, k)["cpsnr_db"]
        leads = [f"`{n}` {estimate(lead['by'])}" for n, lead in zip(names, of["leads"])]
        print(f"{light['luminance_cd_m2']:g} cd/m²: `{names[of['best']]}` has the best mean CPSNR; leads over", ", ".join(leads))


def classic() -> None:
    """L³ against other processing on Bayer."""
    r = compare("classic", f"bayer {CLASSIC} --luminance 1,10,80")
    score_table(r, "pipeline")
    for k, light in enumerate(r["verdict"]["lights"]):
        for name, of in metrics(r, k).items():
            print(f"{light['luminance_cd_m2']:g}", name, "best", of["best"], *[estimate(e) for e in of["from_first"]], sep=" | ")
    r = compare("classic-charts", f"bayer {CLASSIC} --luminance 1,10,80 --scenes charts")
    score_table(r, "pipeline")
    loses(r, "")
    quiet = "--set sensor.pixel.read_noise_mv=0 --set sensor.dsnu_mv=0 --set sensor.prnu_percent=0 --set sensor.pixel.dark_voltage_v_per_s=0"
    quiet += " --set sensor.adc_bits=16 --set sensor.pixel.conversion_gain_uv_per_e=0.02 --set sensor.pixel.full_well_e=718200000"
    r = compare("classic-no-noise", f"bayer {CLASSIC} --luminance 20,80 --scenes charts {quiet} --set exposure.time_ms=1000000")
    score_table(r, "pipeline")
    loses(r, ", no noise")


def loses(results: dict, what: str) -> None:
    """The margin of L³ over the best other method, and the scenes in which it loses."""
    lights = sorted({r["luminance_cd_m2"] for r in results["results"]})
    margins, losses = [], []
    for light in lights:
        at = [r for r in results["results"] if r["luminance_cd_m2"] == light]
        own, others = at[0], at[1:]
        line = [f"{light:g}{what}"]
        for metric, best, sign in (("cpsnr_db", max, 1), ("pixel_delta_e_2000_mean", min, -1), ("scielab_mean", min, -1)):
            line.append(f"{own[metric] - best(o[metric] for o in others):+.2f}".replace("-", "−"))
            for i, scene in enumerate(own["scenes"]):
                mine = scene["scores"][metric]
                best_other = best(others, key=lambda o: o["scenes"][i]["scores"][metric])
                theirs = best_other["scenes"][i]["scores"][metric]
                if sign * (mine - theirs) < 0:
                    losses.append([f"{light:g}{what}", scene["scene"].split("?")[0], METRICS[metric], f"{mine:.2f}", f"{theirs:.2f}", best_other["pipeline"]])
        margins.append(line)
    table(["cd/m²", *METRICS.values()], margins)
    table(["cd/m²", "scene", "metric", "L³", "the best other", "by"], losses)


def settings(prefix: str, lights: str, choices: dict[str, str], counts: bool) -> None:
    """Bayer and RGBW with several settings of learning."""
    body: dict[str, list[list[str]]] = {"bayer": [], "rgbw": []}
    for name, words in choices.items():
        r = compare(f"{prefix}-{name.replace(' ', '-')}", f"bayer rgbw --luminance {lights} {words}")
        for camera, learned in zip(("bayer", "rgbw"), r["learned"]):
            own = [line for line in rows(r) if line["camera"] == camera]
            scores = [" · ".join(line[key] for line in own) for key in ("cpsnr", "de", "scielab", "mtf50", "snr", "noise")]
            classes = [f"{learned['classes_that_occur']} / {learned['operators']}"] if counts else []
            body[camera].append([camera, name, *classes, *scores])
    head = ["camera", "setting", *(["classes / kernels"] if counts else []), *METRICS.values(), "MTF50 cy/mm", "visual SNR", "noise %"]
    table(head, body["bayer"] + body["rgbw"])


def textures() -> None:
    """Classes of orientation."""
    flat = "--textures flat-texture"
    settings("textures", "1,10,80", {"flat-texture 10": flat, "flat-texture 16": f"{flat} --levels 16", "oriented 10": ""}, True)


def alpha() -> None:
    """The perceptual weights."""
    choices = {"wiener": ""}
    for flat, texture in (("4,4", "1,1"), ("16,4", "1,4"), ("64,16", "4,16")):
        choices[f"{flat} and {texture}"] = f"--alpha-flat {flat} --alpha-texture {texture}"
    settings("alpha", "1,10", choices, False)


def trained(name: str, words: str) -> str:
    """A learned table."""
    out = FOLDER / f"{name}.l3"
    if not out.exists():
        smalti("train", *shlex.split(words), "-o", str(out))
    return str(out)


def kinds(spectral: pathlib.Path | None) -> None:
    """Pipelines learned from the built-in set and from the test scene itself."""
    general = trained("general", "bayer --illuminants D65")
    scenes = ["photo-astronaut", "photo-spices", *([str(spectral)] if spectral else [])]
    body = []
    for scene in scenes:
        name = pathlib.Path(scene).stem
        own = trained(f"own-{name}", f"bayer --scene {scene} --illuminant D65")
        r = compare(f"kinds-{name}", f"bayer bayer --pipeline {general} --pipeline {own} --scene {scene} --luminance 1,10,80")
        every = rows(r)
        for a, b in zip(every[:3], every[3:]):
            loss = f"{float(b['cpsnr']) - float(a['cpsnr']):+.2f} dB".replace("-", "−")
            body.append([name, f"{a['light']:g}", *[f"{a[key]} / {b[key]}" for key in ("cpsnr", "de", "scielab")], loss])
    table(["scene", "cd/m²", "CPSNR dB, built-in / own", "ΔE2000", "S-CIELAB", "loss in CPSNR"], body)


def illuminants() -> None:
    """Tables learned under other lights than those of the test."""
    tables = {"D65, A, LED": "D65,A,LED", "D65": "D65", "A": "A"}
    files = {name: trained(f"under-{lights.replace(',', '-')}", f"bayer --illuminants {lights}") for name, lights in tables.items()}
    body = []
    for light in ("D65", "A"):
        pipelines = " ".join(f"--pipeline {f}" for f in files.values())
        r = compare(f"illuminants-{light}", f"bayer bayer bayer {pipelines} --illuminant {light} --scenes charts --luminance 10,80")
        every = rows(r)
        for k, cd in enumerate(("10", "80")):
            body += [[light, cd, name, line["cpsnr"], line["de"], line["scielab"]] for name, line in zip(tables, every[k::2])]
    table(["tested under", "cd/m²", "learned under", "CPSNR dB", "ΔE2000", "S-CIELAB"], body)


def greys() -> None:
    """The chromaticity of the four lightest greys of a ColorChecker under A, with and without illuminant correction."""
    import numpy as np

    tables = {"corrected to D65": "--target-illuminant D65", "not corrected": ""}
    raw = FOLDER / "greys"
    if not (raw / "metrics.json").exists():
        smalti("simulate", "bayer", "--scene", "macbeth", "--illuminant", "A", "--luminance", "80", "-o", str(raw))
    for name, words in tables.items():
        table_file = trained(f"greys-{name.replace(' ', '-')}", f"bayer --illuminants A {words}")
        out = FOLDER / f"greys-{name.replace(' ', '-')}.npy"
        smalti("render", str(raw / "raw.dng"), "--pipeline", table_file, "-o", str(out))
        picture = np.load(out).astype(float)
        rows, cols = picture.shape[1] / 4, picture.shape[2] / 6
        # The middle of each patch of the last row.
        patches = [picture[:, int(3.35 * rows) : int(3.65 * rows), int((c + 0.35) * cols) : int((c + 0.65) * cols)] for c in range(4)]
        xyz = np.array([p.reshape(3, -1).mean(1) for p in patches])
        x, y = (xyz[:, :2] / xyz.sum(1, keepdims=True)).mean(0)
        print(f"{name}: ({x:.4f}, {y:.4f})")


def artefacts() -> None:
    """The side-by-side pictures whose artefacts are described."""
    compare("artefacts", "bayer rgbw rgbx rgbcmy medical clarity kodak wang --luminance 1,80 --scenes charts")
    print("see", FOLDER / "artefacts" / "side-by-side")


def fixed() -> None:
    """The lowest PSNR of fixed point over the charts."""
    r = compare("fixed", "bayer rgbw rgbx rgbcmy medical --luminance 1,80 --scenes charts")
    body = []
    for light in (1.0, 80.0):
        at = [line for line in r["results"] if line["luminance_cd_m2"] == light]
        body.append([f"{light:g}", *[f"{min(s['fixed_point_psnr_db'] for s in line['scenes']):.1f}" for line in at]])
    table(["cd/m²", "bayer", "rgbw", "rgbx", "rgbcmy", "medical"], body)


def phone() -> None:
    """A camera that clips."""
    r = compare("phone", f"phone {CLASSIC} --luminance 80 --scenes charts")
    body = []
    for line in r["results"]:
        scores = [f"{s['scores']['cpsnr_db']:.2f}" for s in line["scenes"]]
        body.append([line["pipeline"], *scores, f"{line['cpsnr_db']:.2f}", f"{line['scielab_mean']:.2f}"])
    table(["pipeline", "dead leaves", "ColorChecker", "resolution chart", "star", "room", "mean", "S-CIELAB"], body)


def main() -> None:
    global FOLDER, SMALTI
    sections = {f.__name__: f for f in (rgbw, curve, cameras, classic, textures, alpha, kinds, illuminants, greys, fixed, phone, artefacts)}
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("smalti", help="the command")
    p.add_argument("folder", type=pathlib.Path, help="where the results are kept")
    p.add_argument("sections", nargs="*", metavar="SECTION", help="all if none is given")
    p.add_argument("--spectral", type=pathlib.Path, help="a spectral image for the section kinds")
    args = p.parse_args()
    unknown = [name for name in args.sections if name not in sections]
    if unknown:
        p.error(f"no section is called {unknown[0]}; there are {', '.join(sections)}")
    FOLDER, SMALTI = args.folder, str(pathlib.Path(args.smalti).resolve())
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in args.sections or sections:
        print(f"\n## {name}", flush=True)
        kinds(args.spectral) if name == "kinds" else sections[name]()


if __name__ == "__main__":
    main()
