"""Writes THIRD-PARTY.txt: the licences of all code and fonts that the command and the Python package contain.

    python3 tools/licences.py

A test of the command compares the list with `cargo metadata`.
"""

import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
PACKAGES = ("smalti-cli", "smalti-py")
PLATFORM = "x86_64-unknown-linux-gnu"
HEADER = """Third-party software and fonts in Smalti

Smalti itself is licensed under MIT or Apache-2.0 (LICENSE-MIT, LICENSE-APACHE). The programs and packages that are built from it contain
the crates and files below. Where a crate offers several licences, its MIT licence is taken if it has one.

This software is based in part on the work of the Independent JPEG Group (jpeg-encoder).
"""


def crates() -> list[dict]:
    """The crates that the packages link, in alphabetical order."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", PLATFORM]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    packages = {p["id"]: p for p in metadata["packages"]}
    nodes = {n["id"]: n for n in metadata["resolve"]["nodes"]}
    open_ids = [i for i, p in packages.items() if p["name"] in PACKAGES]
    seen = set()
    while open_ids:
        node = nodes[open_ids.pop()]
        if node["id"] in seen:
            continue
        seen.add(node["id"])
        open_ids += [d["pkg"] for d in node["deps"] if any(k["kind"] is None for k in d["dep_kinds"])]
    external = [packages[i] for i in seen if packages[i]["source"]]
    return sorted(external, key=lambda p: (p["name"], p["version"]))


def texts(package: dict) -> list[str]:
    """The licences of a crate that are in its files."""
    folder = pathlib.Path(package["manifest_path"]).parent
    pattern = re.compile(r"(licen[cs]e|copying|notice|unlicense)", re.IGNORECASE)
    files = sorted(f for f in folder.iterdir() if f.is_file() and pattern.match(f.name))
    # One of several that are offered; what must be kept beside it, such as a notice, stays.
    expression = package["license"] or ""
    mit = [f for f in files if "mit" in f.name.lower()]
    if mit and "MIT" in expression and " AND " not in expression:
        files = mit + [f for f in files if "notice" in f.name.lower()]
    return [f.read_text("utf-8", "replace").replace("\r\n", "\n").strip() for f in files]


def main() -> None:
    by_text: dict[str, list[str]] = {}
    lines, without = [], []
    for package in crates():
        name = f"{package['name']} {package['version']}"
        lines.append(f"{name}: {package['license']}")
        found = texts(package)
        for text in found:
            by_text.setdefault(text, []).append(name)
        if not found:
            without.append(name)
    files = {
        "the typeface Inter, in figures": ROOT / "crates/smalti-report/fonts/OFL.txt",
        "uPlot, in pages": ROOT / "crates/smalti-report/vendor/uplot/LICENSE",
    }
    for name, file in files.items():
        lines.append(f"{name}: {file.relative_to(ROOT)}")
        by_text.setdefault(file.read_text("utf-8").strip(), []).append(name)
    rule = "\n\n" + "-" * 100 + "\n\n"
    parts = [HEADER + "\n" + "\n".join(lines)]
    if without:
        parts.append("These crates contain no text of their licence, which is the one named above:\n" + ", ".join(without))
    parts += [", ".join(names) + ":\n\n" + text for text, names in by_text.items()]
    (ROOT / "THIRD-PARTY.txt").write_text(rule.join(parts) + "\n", "utf-8")


if __name__ == "__main__":
    main()
