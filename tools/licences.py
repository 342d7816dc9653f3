"""Writes THIRD-PARTY.txt: the licences of all code and fonts that the command and the Python package contain.

    python3 tools/licences.py            writes it; a test of the command compares the list with `cargo metadata`
    python3 tools/licences.py --check    compares the licences and sources of all dependencies, on all platforms, with deny.toml
"""

import json
import pathlib
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
PACKAGES = ("smalti-cli", "smalti-py")
# One processor of each system: none brings crates of its own.
PLATFORMS = ("x86_64-unknown-linux-gnu", "aarch64-apple-darwin", "x86_64-pc-windows-msvc")
HEADER = """Third-party software and fonts in Smalti

Smalti itself is licensed under MIT or Apache-2.0 (LICENSE-MIT, LICENSE-APACHE). The programs and packages that are built from it contain
the crates and files below. Where a crate offers several licences, its MIT licence is taken if it has one.

This software is based in part on the work of the Independent JPEG Group (jpeg-encoder).
"""


def linked() -> tuple[dict[str, dict], dict[str, set[str]]]:
    """The crates that the packages link on any platform, by their identities, and what each of them needs."""
    packages: dict[str, dict] = {}
    needs: dict[str, set[str]] = {}
    for platform in PLATFORMS:
        command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", platform]
        metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
        packages |= {p["id"]: p for p in metadata["packages"]}
        nodes = {n["id"]: n for n in metadata["resolve"]["nodes"]}
        open_ids = [p["id"] for p in metadata["packages"] if p["name"] in PACKAGES]
        seen: set[str] = set()
        while open_ids:
            node = nodes[open_ids.pop()]
            if node["id"] not in seen:
                seen.add(node["id"])
                normal = [d["pkg"] for d in node["deps"] if any(k["kind"] is None for k in d["dep_kinds"])]
                needs.setdefault(node["id"], set()).update(normal)
                open_ids += normal
    return {i: packages[i] for i in needs}, needs


def crates() -> list[dict]:
    """Those of them that are not ours, in alphabetical order."""
    external = [p for p in linked()[0].values() if p["source"]]
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
    # C code that a crate brings has a licence of its own, the same in each of its versions.
    files += sorted(folder.glob("c_src/**/LICENSE"))
    return list(dict.fromkeys(f.read_text("utf-8", "replace").replace("\r\n", "\n").strip() for f in files))


def permits(expression: str, allowed: set[str]) -> bool:
    """Whether an SPDX expression can be satisfied with the allowed licences. The old separator of crates, "/", means OR."""
    terms = re.findall(r"[()]|[^\s()]+", expression.replace("/", " OR "))

    def alternatives() -> bool:
        result = parts()
        while terms and terms[0] == "OR":
            terms.pop(0)
            result = parts() or result
        return result

    def parts() -> bool:
        result = licence()
        while terms and terms[0] == "AND":
            terms.pop(0)
            result = licence() and result
        return result

    def licence() -> bool:
        term = terms.pop(0)
        if term == "(":
            result = alternatives()
            if not terms or terms.pop(0) != ")":
                raise ValueError(f"a parenthesis is missing in {expression}")
            return result
        if terms and terms[0] == "WITH":
            term = " ".join([term, terms.pop(0), terms.pop(0)])
        return term in allowed

    result = alternatives()
    if terms:
        raise ValueError(f"{terms[0]} is unexpected in {expression}")
    return result


def complaints() -> list[str]:
    """What deny.toml does not admit: licences, and sources other than crates.io."""
    rules = tomllib.loads((ROOT / "deny.toml").read_text("utf-8"))["licenses"]
    exceptions = {e["crate"]: set(e["allow"]) for e in rules["exceptions"]}
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    found = []
    for package in metadata["packages"]:
        name = f"{package['name']} {package['version']}"
        allowed = set(rules["allow"]) | exceptions.get(package["name"], set())
        if not package["license"] or not permits(package["license"], allowed):
            found.append(f"{name}: the licence {package['license']} is not in deny.toml")
        source = package["source"] or ""
        if source and source != "registry+https://github.com/rust-lang/crates.io-index":
            found.append(f"{name}: the source {source} is not crates.io")
    if len(metadata["packages"]) < 100:
        found.append("cargo metadata lists too few packages")
    return found


def main() -> None:
    if sys.argv[1:] == ["--check"]:
        found = complaints()
        sys.exit("\n".join(found) if found else 0)
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
        "photographs, as scenes": ROOT / "crates/smalti-io/scenes/LICENCES.md",
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
