#!/usr/bin/env python3
"""Measures the figures of docs/l3.md and prints them as tables, section by section.

    cargo build --release -p smalti-cli
    python3 tools/measure_l3.py target/release/smalti target/l3 [SECTION …]

Each section is one or more runs of the command, whose results stay in the given folder and are used again by a later run of this script. Only the
section `kinds` needs more than the built-in scenes: --spectral FILE names a spectral image of one's own. The section `greys` needs NumPy.

    python3 tools/measure_l3.py target/release/smalti target/l3-catalog --training-set catalog
    python3 tools/measure_l3.py target/release/smalti target/l3 effect --against target/l3-catalog

The first command makes the same figures with pipelines that learn from the catalogue alone, the second prints by how much every figure changes.
"""

import argparse
import json
import math
import pathlib
import shlex
import subprocess

FOLDER = pathlib.Path()
SMALTI = ""
TRAINING_SET = "all"
AGAINST: pathlib.Path | None = None
SLIDES = "bayer rgbw clarity kodak wang rgbcmy medical"
CLASSIC = "--processing l3,bilinear,malvar2004,hamilton-adams1997"
METRICS = {"cpsnr_db": "CPSNR, dB", "pixel_delta_e_2000_mean": "ΔE2000", "scielab_mean": "S-CIELAB"}
SETS = ("natural", "charts")
# The 0.975 quantiles of Student's distribution for the numbers of scenes of the two sets.
STUDENT = {14: 2.160, 5: 2.776}
PHOTOGRAPHS = [f"photo-{name}" for name in ("astronaut", "brushes", "dahlia", "fig", "pagoda", "raccoon", "spices", "stream")]
TARGETS = {
    "mtf50": lambda t: t["mtf50_cy_per_mm"],
    "visual_snr": lambda t: t["visual_snr"]["median"],
    "noise": lambda t: t["luminance_noise_percent"]["mean"],
}


def smalti(*words: str) -> None:
    """Runs the command and says which."""
    print("    $ smalti", *[shlex.quote(w) if "?" in w or "{" in w else w for w in words], flush=True)
    subprocess.run([SMALTI, *words], check=True, capture_output=True)


def compare(name: str, words: str) -> dict:
    """The results of a comparison, from its folder if it was run before."""
    out = FOLDER / name
    if not (out / "results.json").exists():
        smalti("compare", *shlex.split(words), *learning(), "-o", str(out))
    return json.loads((out / "results.json").read_text())


def learning() -> list[str]:
    """The options of the training scenes."""
    return [] if TRAINING_SET == "all" else ["--training-set", TRAINING_SET]


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


def of_sets(name: str, words: str) -> dict[str, dict]:
    """The results of a comparison on both sets of scenes."""
    return {s: compare(name + ("" if s == "natural" else f"-{s}"), f"{words} --scenes {s}") for s in SETS}


def estimate(e: dict) -> str:
    """A difference with its interval, bold where the interval excludes 0."""
    value = f"{e['value']:+.2f}".replace("-", "−")
    if e["interval"] is None:
        return value
    low, high = e["interval"]["low"], e["interval"]["high"]
    value = f"**{value}**" if low * high > 0 else value
    return f"{value} [{low:.2f}, {high:.2f}]".replace("-", "−")


def stops(gain: dict) -> str:
    """A light gain with its interval, bold where the interval excludes 0. Ends beyond the search are bounds."""

    def end(of: dict, digits: str) -> str:
        (kind, value), = of.items()
        return {"stops": f"{value:{digits}}", "more_than": f"> {value:g}", "less_than": f"< {value:g}"}[kind]

    value = end(gain["gain"], "+.2f")
    if gain["interval"] is None:
        return value.replace("-", "−")
    ends = [gain["interval"][name] for name in ("low", "high")]
    low, high = (next(iter(e.values())) for e in ends)
    value = f"**{value}**" if low * high > 0 else value
    return f"{value} [{', '.join(end(e, '.2f') for e in ends)}]".replace("-", "−")


def difference(a: dict, b: dict, metric: str) -> str:
    """The mean difference of two rows of results of different runs, with Student's interval over the scenes."""
    own = [[sum(seed[metric] for seed in s["by_seed"]) / len(s["by_seed"]) for s in r["scenes"]] for r in (a, b)]
    by_scene = [x - y for x, y in zip(*own)]
    n = len(by_scene)
    mean = sum(by_scene) / n
    half = STUDENT[n] * math.sqrt(sum((d - mean) ** 2 for d in by_scene) / (n - 1) / n)
    return estimate({"value": mean, "interval": {"low": mean - half, "high": mean + half}})


def paired(runs: dict[str, dict]) -> list[tuple[dict, dict]]:
    """The rows of the natural scenes, each with that of the charts, ordered by light."""
    both = list(zip(*(rows(runs[s]) for s in SETS)))
    return sorted(both, key=lambda pair: pair[0]["light"])


def both_sets(pair: tuple[dict, dict]) -> list[str]:
    """Scores of pictures on both sets, and those of the chart and the edge."""
    n, c = pair
    return [*[f"{n[key]} · {c[key]}" for key in ("cpsnr", "de", "scielab")], n["mtf50"], n["snr"], n["noise"]]


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
    body = []
    for name in ("cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean", "visual_snr", "luminance_noise_percent"):
        # The chart has no set of scenes.
        for scenes in SETS if name in METRICS else ("natural",):
            line = [name, scenes if name in METRICS else "chart"]
            for k in range(2):
                for solver in ("wiener", "perceptual"):
                    found = runs[scenes, solver]["light_gains"][k]["gains"]["metrics"]
                    line.append(stops(next(m for m in found if m["metric"] == name)))
            body.append(line)
    table(["metric, stops", "scenes", "1 cd/m², wiener", "1, perceptual", "80, wiener", "80, perceptual"], body)


def curve() -> None:
    """RGBW − Bayer against light."""
    runs = of_sets("curve", "bayer rgbw --luminance 0.3,1,3,10,30,80")
    body = []
    for k, light in enumerate(runs["natural"]["verdict"]["lights"]):
        for scenes in SETS:
            of = metrics(runs[scenes], k)
            lead = next((m["light"] for m in of["cpsnr_db"]["leads"] if m["light"]), None) if of["cpsnr_db"]["best"] == 1 else None
            worth = "–"
            if lead and "stops" in lead:
                ends = lead["stops"]["interval"]
                high = "…" if ends["high"] is None else f"{ends['high']:.2f}"
                worth = f"{lead['stops']['value']:.2f} [{ends['low']:.2f}, {high}]"
            differences = [estimate(of[m]["from_first"][1]) for m in METRICS]
            body.append([f"{light['luminance_cd_m2']:g}", scenes, differences[0], worth, *differences[1:]])
    table(["cd/m²", "scenes", "CPSNR, dB", "worth, stops", "ΔE2000", "S-CIELAB"], body)


def score_table(results: dict, first: str = "camera") -> None:
    """The first table of a comparison."""
    body = [[f"{r['light']:g}", r[first], r["cpsnr"], r["de"], r["scielab"], r["mtf50"], r["snr"], r["noise"]] for r in rows(results)]
    body.sort(key=lambda line: float(line[0]))
    table(["cd/m²", first, "CPSNR dB", "ΔE2000", "S-CIELAB", "MTF50 cy/mm", "visual SNR", "noise %"], body)


def cameras() -> None:
    """All mosaics of the slides."""
    runs = of_sets("cameras", f"{SLIDES} --luminance 1,80")
    head = ["cd/m²", "camera", "CPSNR dB, natural · charts", "ΔE2000", "S-CIELAB", "MTF50 cy/mm", "visual SNR", "noise %"]
    table(head, [[f"{n['light']:g}", n["camera"], *both_sets((n, c))] for n, c in paired(runs)])
    names, body = SLIDES.split(), []
    for k, light in enumerate(("1", "80")):
        for number, name in enumerate(names[1:], 1):
            for scenes in SETS:
                of = metrics(runs[scenes], k)
                body.append([light, name, scenes, *[estimate(of[m]["from_first"][number]) for m in METRICS]])
    table(["cd/m²", "camera − bayer", "scenes", *METRICS.values()], body)
    for scenes in SETS:
        for k, light in enumerate(("1", "80")):
            of = metrics(runs[scenes], k)["cpsnr_db"]
            leads = [f"`{n}` {estimate(lead['by'])}" for n, lead in zip(names, of["leads"])]
            print(f"{scenes}, {light} cd/m²: `{names[of['best']]}` has the best mean CPSNR; leads over", ", ".join(leads))


def classic() -> None:
    """L³ against other processing on Bayer."""
    runs = of_sets("classic", f"bayer {CLASSIC} --luminance 1,10,80")
    margins(runs["natural"], "")
    score_table(runs["natural"], "pipeline")
    quiet = "--set sensor.pixel.read_noise_mv=0 --set sensor.dsnu_mv=0 --set sensor.prnu_percent=0 --set sensor.pixel.dark_voltage_v_per_s=0"
    quiet += " --set sensor.adc_bits=16 --set sensor.pixel.conversion_gain_uv_per_e=0.02 --set sensor.pixel.full_well_e=718200000"
    no_noise = compare("classic-no-noise", f"bayer {CLASSIC} --luminance 20,80 --scenes charts {quiet} --set exposure.time_ms=1000000")
    for results, what in ((runs["charts"], ""), (no_noise, ", no noise")):
        score_table(results, "pipeline")
        margins(results, what)
        losses(results, what)


def margins(results: dict, what: str) -> None:
    """By how much L³ is better than each other method, with intervals."""
    body = []
    for k, light in enumerate(results["verdict"]["lights"]):
        for name, of in metrics(results, k).items():
            sign = -1 if name == "cpsnr_db" else 1
            line = []
            for e in of["from_first"][1:]:
                ends = sorted(sign * e["interval"][end] for end in ("low", "high"))
                better = {"value": sign * e["value"], "interval": {"low": ends[0], "high": ends[1]}}
                line.append(estimate(better).replace("+", ""))
            body.append([f"{light['luminance_cd_m2']:g}{what}", METRICS[name], *line])
    table(["cd/m²", "metric", *[f"over {r['pipeline']}" for r in results["results"][len(results["verdict"]["lights"]) :: len(results["verdict"]["lights"])]]], body)


def losses(results: dict, what: str) -> None:
    """The scenes in which L³ loses."""
    found = []
    for light in sorted({r["luminance_cd_m2"] for r in results["results"]}):
        own, *others = (r for r in results["results"] if r["luminance_cd_m2"] == light)
        for metric, best, sign in (("cpsnr_db", max, 1), ("pixel_delta_e_2000_mean", min, -1), ("scielab_mean", min, -1)):
            for i, scene in enumerate(own["scenes"]):
                mine = scene["scores"][metric]
                best_other = best(others, key=lambda o: o["scenes"][i]["scores"][metric])
                theirs = best_other["scenes"][i]["scores"][metric]
                if sign * (mine - theirs) < 0:
                    found.append([f"{light:g}{what}", scene["scene"].split("?")[0], METRICS[metric], f"{mine:.2f}", f"{theirs:.2f}", best_other["pipeline"]])
    table(["cd/m²", "scene", "metric", "L³", "the best other", "by"], found)


def settings(prefix: str, lights: str, choices: dict[str, str]) -> dict[str, dict[str, dict]]:
    """The results of Bayer and RGBW with several settings of learning."""
    return {name: of_sets(f"{prefix}-{name.replace(' ', '-')}", f"bayer rgbw --luminance {lights} {words}") for name, words in choices.items()}


def gained(runs: dict[str, dict[str, dict]], setting: str, over: str) -> None:
    """By how much the scores of one setting differ from those of another, for each camera, light and set of scenes."""
    body = []
    for i, of in enumerate(runs[setting]["natural"]["results"]):
        for scenes in SETS:
            a, b = (runs[name][scenes]["results"][i] for name in (setting, over))
            body.append([of["camera"], f"{of['luminance_cd_m2']:g}", scenes, *[difference(a, b, m) for m in METRICS]])
    table(["camera", "cd/m²", "scenes", *METRICS.values()], body)


def textures() -> None:
    """Classes of orientation."""
    flat = "--textures flat-texture"
    runs = settings("textures", "1,10,80", {"flat-texture 10": flat, "flat-texture 16": f"{flat} --levels 16", "oriented 10": ""})
    body = []
    for i, camera in enumerate(("bayer", "rgbw")):
        for name, of in runs.items():
            learned = of["natural"]["learned"][i]
            classes = f"{learned['classes_that_occur']} / {learned['operators']}"
            for scenes in SETS:
                own = [line for line in rows(of[scenes]) if line["camera"] == camera]
                scores = [" · ".join(line[key] for line in own) for key in ("cpsnr", "de", "scielab", "mtf50")]
                body.append([camera, name, classes, scenes, *scores])
    table(["camera", "texture classes, levels", "classes / kernels", "scenes", *METRICS.values(), "MTF50 cy/mm"], body)
    gained(runs, "oriented 10", "flat-texture 10")


def alpha() -> None:
    """The perceptual weights."""
    choices = {"wiener": ""}
    for flat, texture in (("4,4", "1,1"), ("16,4", "1,4"), ("64,16", "4,16")):
        choices[f"{flat} and {texture}"] = f"--alpha-flat {flat} --alpha-texture {texture}"
    runs = settings("alpha", "1,10", choices)
    lines = {name: paired(of) for name, of in runs.items()}
    body = []
    for light in (1.0, 10.0):
        for camera in ("bayer", "rgbw"):
            for name, pairs in lines.items():
                pair = next(p for p in pairs if (p[0]["light"], p[0]["camera"]) == (light, camera))
                body.append([f"{light:g}", camera, name, *both_sets(pair)])
    head = ["cd/m²", "camera", "α flat and texture", "CPSNR dB, natural · charts", "ΔE2000", "S-CIELAB", "MTF50 cy/mm", "visual SNR", "noise %"]
    table(head, body)
    gained(runs, "16,4 and 1,4", "wiener")


def trained(name: str, words: str) -> str:
    """A learned table."""
    out = FOLDER / f"{name}.l3"
    if not out.exists():
        smalti("train", *shlex.split(words), *learning(), "-o", str(out))
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
        words = f"bayer bayer bayer {pipelines} --illuminant {light} --luminance 10,80"
        # Rendered scenes have their own lights. The photographs and the charts can be relit.
        scenes = {"natural": " ".join(f"--scene {name}" for name in PHOTOGRAPHS), "charts": "--scenes charts"}
        runs = {s: compare(f"illuminants-{light}" + ("" if s == "natural" else f"-{s}"), f"{words} {chosen}") for s, chosen in scenes.items()}
        every = list(zip(*(rows(runs[s]) for s in SETS)))
        for k, cd in enumerate(("10", "80")):
            body += [[light, cd, name, *both_sets(pair)[:3]] for name, pair in zip(tables, every[k::2])]
    table(["tested under", "cd/m²", "learned under", "CPSNR dB, photographs · charts", "ΔE2000", "S-CIELAB"], body)


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
    of_sets("artefacts", "bayer rgbw rgbx rgbcmy medical clarity kodak wang --luminance 1,80")
    print("see side-by-side in the folders artefacts and artefacts-charts")


def fixed() -> None:
    """The lowest PSNR of fixed point over the scenes of each set."""
    runs = of_sets("fixed", "bayer rgbw rgbx rgbcmy medical --luminance 1,80")
    body = []
    for scenes in SETS:
        for light in (1.0, 80.0):
            at = [line for line in runs[scenes]["results"] if line["luminance_cd_m2"] == light]
            body.append([f"{light:g}", scenes, *[f"{min(s['fixed_point_psnr_db'] for s in line['scenes']):.1f}" for line in at]])
    table(["cd/m²", "scenes", "bayer", "rgbw", "rgbx", "rgbcmy", "medical"], body)


def phone() -> None:
    """A camera that clips."""
    runs = of_sets("phone", f"phone {CLASSIC} --luminance 80")
    body = []
    for line in runs["charts"]["results"]:
        scores = [f"{s['scores']['cpsnr_db']:.2f}" for s in line["scenes"]]
        body.append([line["pipeline"], *scores, f"{line['cpsnr_db']:.2f}", f"{line['scielab_mean']:.2f}"])
    table(["pipeline", "dead leaves", "ColorChecker", "resolution chart", "star", "room", "mean", "S-CIELAB"], body)
    score_table(runs["natural"], "pipeline")
    margins(runs["natural"], "")


def effect() -> None:
    """By how much figures change with the training scenes: those of the folder less those of --against, the range for each section."""
    if AGAINST is None:
        raise SystemExit("the section effect needs --against FOLDER, with the results of the other training scenes")
    ranges, findings = {}, []
    for own in sorted(FOLDER.glob("*/results.json")):
        other = AGAINST / own.parent.name / "results.json"
        if not other.exists():
            raise SystemExit(f"{other} is missing: run the same sections with the other training scenes")
        a, b = (json.loads(f.read_text()) for f in (own, other))
        scenes = "charts" if "-charts" in own.parent.name or "no-noise" in own.parent.name else "natural"
        section = own.parent.name.split("-")[0]
        for x, y in zip(a["results"], b["results"], strict=True):
            if x["pipeline"] in CLASSIC.split(",")[1:]:
                continue
            changed = {key: x[key] - y[key] for key in METRICS}
            for key, of in TARGETS.items():
                changed[key] = of(x["targets"]) - of(y["targets"])
            changed["fixed_point_psnr_db"] = min(s["fixed_point_psnr_db"] for s in x["scenes"]) - min(s["fixed_point_psnr_db"] for s in y["scenes"])
            for key, value in changed.items():
                ranges.setdefault((section, scenes), {}).setdefault(key, []).append(value)
        findings += changed_findings(own.parent.name, a, b)
    keys = {"cpsnr_db": 2, "pixel_delta_e_2000_mean": 2, "scielab_mean": 2, "mtf50": 1, "visual_snr": 3, "noise": 1, "fixed_point_psnr_db": 1}
    body = []
    for (section, scenes), of in ranges.items():
        ends = [(min(of[key]), max(of[key]), digits) for key, digits in keys.items()]
        body.append([section, scenes, *[f"{low:+.{d}f} … {high:+.{d}f}".replace("-", "−") for low, high, d in ends]])
    head = ["section", "scenes", *METRICS.values(), "MTF50 cy/mm", "visual SNR", "noise %", "fixed point, dB"]
    table(head, body)
    table(["run", "cd/m²", "metric", "of", "catalog", "default"], findings)


def changed_findings(run: str, a: dict, b: dict) -> list[list[str]]:
    """The differences from the first camera whose interval excludes 0 with one set of training scenes and not with the other."""
    out = []
    for k, light in enumerate(a["verdict"]["lights"]):
        for name, of in metrics(a, k).items():
            for number, (x, y) in enumerate(zip(of["from_first"], metrics(b, k)[name]["from_first"], strict=True)):
                if None not in (x["interval"], y["interval"]) and sign(x) != sign(y):
                    row = a["results"][number * len(a["verdict"]["lights"])]
                    label = f"{row['camera']}, {row['pipeline']} − first"
                    out.append([run, f"{light['luminance_cd_m2']:g}", METRICS[name], label, estimate(y), estimate(x)])
    return out


def sign(e: dict) -> int:
    """The sign of a difference that its interval shows, or 0."""
    return (e["interval"]["low"] > 0) - (e["interval"]["high"] < 0)


def main() -> None:
    global FOLDER, SMALTI, TRAINING_SET, AGAINST
    every = (rgbw, curve, cameras, classic, textures, alpha, kinds, illuminants, greys, fixed, phone, artefacts)
    sections = {f.__name__: f for f in (*every, effect)}
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("smalti", help="the command")
    p.add_argument("folder", type=pathlib.Path, help="where the results are kept")
    p.add_argument("sections", nargs="*", metavar="SECTION", help="all if none is given")
    p.add_argument("--training-set", default="all", choices=["all", "catalog"], help="what the pipelines learn from")
    p.add_argument("--against", type=pathlib.Path, metavar="FOLDER", help="results with other training scenes, for the section effect")
    p.add_argument("--spectral", type=pathlib.Path, help="a spectral image for the section kinds")
    args = p.parse_args()
    unknown = [name for name in args.sections if name not in sections]
    if unknown:
        p.error(f"no section is called {unknown[0]}; there are {', '.join(sections)}")
    FOLDER, SMALTI = args.folder, str(pathlib.Path(args.smalti).resolve())
    TRAINING_SET, AGAINST = args.training_set, args.against
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in args.sections or [f.__name__ for f in every]:
        print(f"\n## {name}", flush=True)
        kinds(args.spectral) if name == "kinds" else sections[name]()


if __name__ == "__main__":
    main()
