"""Writes the software bill of materials of the command and the Python package on all systems (CycloneDX 1.5) to standard output.

    python3 tools/sbom.py > smalti.cdx.json
"""

import json
import tomllib

import licences


def main() -> None:
    lock = tomllib.loads((licences.ROOT / "Cargo.lock").read_text("utf-8"))
    checksums = {(p["name"], p["version"]): p.get("checksum") for p in lock["package"]}
    packages, needs = licences.linked()
    version = next(p["version"] for p in packages.values() if p["name"] == "smalti")
    # The URL of a package identifies it in the list.
    urls = {i: f"pkg:cargo/{p['name']}@{p['version']}" for i, p in packages.items()}
    components = []
    for i, package in sorted(packages.items(), key=lambda item: urls[item[0]]):
        component = {
            "type": "library",
            "bom-ref": urls[i],
            "name": package["name"],
            "version": package["version"],
            "purl": urls[i],
            "licenses": [{"expression": package["license"].replace("/", " OR ")}],
        }
        if checksum := checksums[package["name"], package["version"]]:
            component["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        components.append(component)
    root = {"type": "application", "bom-ref": f"smalti@{version}", "name": "smalti", "version": version}
    roots = [urls[i] for i, p in packages.items() if p["name"] in licences.PACKAGES]
    dependencies = [{"ref": root["bom-ref"], "dependsOn": sorted(roots)}]
    dependencies += [
        {"ref": urls[i], "dependsOn": sorted({urls[n] for n in needs[i]})} for i in sorted(packages, key=lambda i: urls[i])
    ]
    sbom = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": root},
        "components": components,
        "dependencies": dependencies,
    }
    print(json.dumps(sbom, indent=1, ensure_ascii=False))


if __name__ == "__main__":
    main()
