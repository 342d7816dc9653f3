"""A study of which filters and mosaics have a low colour error and little noise, with a data frame and a plot of the results."""

import matplotlib.pyplot as plt
import smalti

study = smalti.Study.from_toml(
    """
    name = "filters"
    camera = "table1"
    colors = [3, 4]
    metrics = ["delta_e_2000", "luminance_noise_percent"]
    [sample]
    filters = 40
    mosaics = 4
    [filters.gaussian_grid]
    [mosaics.tile]
    rows = 2
    cols = 2
    [conditions.grid]
    luminance_cd_m2 = [10]
    """
)
print(study)
# Ctrl-C keeps the finished parts, and the next run resumes.
frame = smalti.sweep(study, "filters").to_pandas()
best = frame.nsmallest(5, "delta_e_2000")[["trial", "colors", "tile", "delta_e_2000", "luminance_noise_percent"]]
print(best.to_string(index=False))
print(study.cfa(int(best.trial.iloc[0])))

for colors, group in frame.groupby("colors"):
    plt.scatter(group.luminance_noise_percent, group.delta_e_2000, s=8, label=f"{colors} colours")
plt.xlabel("noise on grey patches, %")
plt.ylabel("ΔE2000")
plt.legend()
plt.savefig("filters.png")
