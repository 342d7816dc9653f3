"""A custom colour filter array: three Gaussian filters and a clear one, with the green filter that gives the lowest colour error."""

import numpy as np
import smalti

nm = np.arange(400.0, 701.0, 10.0)
tile = [[2, 3], [1, 0]]


def cfa(center_nm: float) -> smalti.Cfa:
    """Blue, green at `center_nm`, red, clear."""
    curves = [0.9 * np.exp(-0.5 * ((nm - c) / 35.0) ** 2) for c in (450.0, center_nm, 610.0)]
    return smalti.Cfa.from_arrays(tile, [*curves, np.full_like(nm, 0.95)], nm, ["B", "G", "R", "W"], f"G at {center_nm:.0f} nm")


camera = smalti.Camera("bayer")
found = {c: smalti.evaluate(camera.with_cfa(cfa(c))).delta_e_2000 for c in (530.0, 545.0, 560.0)}
for center_nm, delta_e in found.items():
    print(f"green at {center_nm:.0f} nm: ΔE2000 {delta_e:.2f}")

best = cfa(min(found, key=lambda c: found[c]))
print(best)
photo = camera.with_cfa(best).photograph(smalti.Scene("macbeth"))
photo.picture.write("own-cfa.png")
