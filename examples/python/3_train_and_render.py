"""A learned pipeline: trained for a mosaic that no raw developer supports, written to a file and applied to a raw file."""

import smalti

camera = smalti.Camera("rgbw", set={"sensor.rows": 192, "sensor.cols": 256})
# Without scenes, training uses the built-in set and takes about a minute. These few scenes suffice for a first look.
scenes = [smalti.Scene(f"dead-leaves?rows=256&cols=320&seed={seed}") for seed in (1, 2, 3)]
pipeline = smalti.train(camera, [*scenes, smalti.Scene("grey-steps")], levels=6)
pipeline.write("rgbw.l3")
print(pipeline)

chart = smalti.Scene("macbeth", luminance_cd_m2=20.0)
photo = camera.photograph(chart)
photo.raw.write("chart.dng")
picture = smalti.Pipeline.read("rgbw.l3").render(smalti.RawImage.read("chart.dng"))
picture.write("learned.png")

reference = photo.reference()
own = camera.render(photo.raw, chart)
for name, made in (("bilinear", own), ("learned", picture)):
    print(name, {k: round(v, 2) for k, v in smalti.score_picture(made, reference).items()})
