"""A camera photographs a hyperspectral image: reflectances and their wavelengths from an .npz file."""

import numpy as np
import smalti

# This stands for your own file: a cube [rows, columns, wavelengths] of reflectance, 400 to 720 nm in steps of 8 nm.
nm = np.arange(400.0, 721.0, 8.0)
y, x = np.mgrid[0:120, 0:160] / 160.0
cube = 0.5 + 0.4 * np.sin(2 * np.pi * (x[..., None] * 3 + (nm - 400.0) / 320.0)) * np.cos(2 * np.pi * y[..., None])
np.savez("scene.npz", reflectance=cube.astype(np.float32), wavelengths_nm=nm)

file = np.load("scene.npz")
scene = smalti.Scene.from_reflectance(file["reflectance"], file["wavelengths_nm"], illuminant="A", luminance_cd_m2=40.0)
print(scene)
camera = smalti.Camera("phone", wavelengths_nm=nm)
photo = camera.photograph(scene)
photo.picture.write("phone.png")
print(photo, photo.raw)

# Other programs read these files: OpenEXR, MATLAB for ISETCam, ENVI. Smalti can read a part of one.
for name in ["scene.exr", "scene.mat", "scene.hdr"]:
    scene.write(name)
    again = smalti.Scene(name)
    print(f"{name} as written:", np.allclose(again.radiance, scene.radiance, rtol=1e-5))
print(smalti.Scene("scene.hdr", crop=(0, 40, 60, 80)))
