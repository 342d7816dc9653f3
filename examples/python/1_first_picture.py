"""A first picture: a camera photographs a chart, and smaller pixels increase its noise."""

import smalti

scene = smalti.Scene("macbeth", luminance_cd_m2=10.0, illuminant="D65")
print(scene)
for pitch_um in (2.2, 1.1):
    camera = smalti.Camera("rgbw", set={"sensor.pixel.pitch_um": pitch_um})
    photo = camera.photograph(scene)
    photo.picture.write(f"macbeth-{pitch_um}um.png")
    scores = smalti.evaluate(camera, luminance_cd_m2=10.0)
    print(f"{pitch_um} µm, {photo.exposure_time_s * 1e3:.0f} ms: {scores}")

# Every stage is an array: irradiance on the sensor, digital numbers and the picture in XYZ.
print(photo.optical_image.irradiance.shape, photo.raw.samples.dtype, photo.picture.array.mean(axis=(0, 1)))
