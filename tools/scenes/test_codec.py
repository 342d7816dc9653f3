"""python -m unittest scenes.test_codec"""

import unittest
import zlib

import numpy as np

from . import codec, spectra


class Codec(unittest.TestCase):
    def scene(self) -> np.ndarray:
        rng = np.random.default_rng(3)
        names = ["TCS 10", "TCS 32", "TCS 45", "TCS 75", "Skin 36"]
        shares = rng.dirichlet(np.ones(5) * 0.3, (41, 56))
        light = spectra.radiance("LED-B3", 200.0)
        level = np.exp(rng.normal(0, 2, (41, 56)))
        return ((shares @ spectra.table(names).T) * light * level[:, :, None]).astype(np.float32)

    def test_round_trip(self) -> None:
        picture = self.scene()
        data = codec.encode(picture, spectra.radiance("LED-B3", 200.0), {"name": "test"}, 5)
        back = codec.decode(data)
        error = np.linalg.norm(back.radiance - picture, axis=2) / np.linalg.norm(picture, axis=2)
        self.assertLess(np.percentile(error, 95), 0.006)
        self.assertEqual(back.about, {"name": "test"})
        np.testing.assert_allclose(back.light, spectra.radiance("LED-B3", 200.0), rtol=1e-6)

    def test_large_residuals(self) -> None:
        picture = self.scene()
        picture[10, 10] *= 1e5
        back = codec.decode(codec.encode(picture, picture[0, 0], {}, 5, 0.001, 0.002)).radiance
        np.testing.assert_allclose(back[10, 10], picture[10, 10], rtol=0.01)
        np.testing.assert_allclose(back[40, 55], picture[40, 55], rtol=0.02)

    def test_black_stays_black(self) -> None:
        picture = self.scene()
        picture[3:9, 4:20] = 0
        back = codec.decode(codec.encode(picture, picture[0, 0], {}, 5))
        self.assertEqual(float(back.radiance[3:9, 4:20].max()), 0.0)

    def test_damage_is_refused(self) -> None:
        data = codec.encode(self.scene(), self.scene()[0, 0], {}, 3)
        with self.assertRaises(zlib.error):
            codec.decode(data[:-50])
        with self.assertRaises(ValueError):
            codec.decode(b"X" + data[1:])


if __name__ == "__main__":
    unittest.main()
