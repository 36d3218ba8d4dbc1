"""Images: files, pictures for notebooks, comparisons."""

import unittest

import numpy
from support import TestCase

import metrolux


class Images(TestCase):
    def setUp(self):
        super().setUp()
        self.pixels = numpy.random.default_rng(1).random((6, 8, 3), dtype=numpy.float32)

    def test_files_keep_all_bits(self):
        metrolux.write(self.folder / "a.exr", self.pixels)
        image = metrolux.read(self.folder / "a.exr")
        self.assertIsInstance(image, metrolux.Image)
        self.assertSameBits(image, self.pixels)
        metrolux.write(self.folder / "b.exr", self.pixels[:, ::-1])
        self.assertSameBits(metrolux.read(self.folder / "b.exr"), self.pixels[:, ::-1].copy())
        with self.assertRaisesRegex(metrolux.Error, "of 2 channels, expected 3 or 1"):
            metrolux.write(self.folder / "c.exr", self.pixels[:, :, :2])
        with self.assertRaisesRegex(metrolux.Error, r"image: found an array of shape \(3,\)"):
            metrolux.write(self.folder / "c.exr", [1, 2, 3])

    def test_notebooks_show_a_picture(self):
        image = self.pixels.view(metrolux.Image)
        self.assertTrue(image._repr_png_().startswith(b"\x89PNG"))
        brighter = image.shown(exposure=1, curve="filmic")
        self.assertTrue(numpy.shares_memory(brighter, image))
        self.assertEqual((image.exposure, brighter.exposure, (brighter * 2).exposure), (0, 1, 1))
        self.assertEqual(brighter._repr_png_(), metrolux.png(image, exposure=1, curve="filmic"))
        self.assertNotEqual(brighter._repr_png_(), image._repr_png_())
        brighter.save(self.folder / "a.png")
        shown = metrolux.read(self.folder / "a.png")
        image.save(self.folder / "b.png")
        self.assertGreater(shown.mean(), metrolux.read(self.folder / "b.png").mean())
        self.assertTrue(image[:, :, :1]._repr_png_().startswith(b"\x89PNG"))
        self.assertIsNone(image.mean(axis=(0, 1))._repr_png_())
        self.assertIs(type(image.mean()), numpy.float32)
        self.assertIsNone(image[:, :, :2]._repr_png_())

    def test_comparisons_are_those_of_the_command(self):
        other = self.pixels + numpy.float32(0.1) * self.pixels**2
        difference = metrolux.compare(other, self.pixels)
        squares = (other - self.pixels).astype(numpy.float64) ** 2
        relative = squares / (self.pixels.astype(numpy.float64) ** 2 + 1e-2)
        self.assertAlmostEqual(difference.mse, squares.mean(), places=6)
        self.assertAlmostEqual(difference.rel_mse, relative.mean(), places=6)
        self.assertLess(difference.trimmed_rel_mse, difference.rel_mse)
        self.assertAlmostEqual(difference.bias, other.mean() / self.pixels.mean() - 1, places=5)
        self.assertEqual((difference.pixels, difference.non_finite), (48, 0))
        metrolux.write(self.folder / "a.exr", other)
        metrolux.write(self.folder / "b.exr", self.pixels)
        text = self.command("compare", "a.exr", "b.exr", "--heatmap", "errors.png").stdout
        for value in (difference.mse, difference.rel_mse, difference.trimmed_rel_mse, difference.smape):
            self.assertIn(f" {value:.6g}\n", text)
        difference.heat_map.save(self.folder / "mine.png")
        self.assertSameBits(metrolux.read(self.folder / "mine.png"), metrolux.read(self.folder / "errors.png"))
        self.assertIn("relMSE", repr(difference))
        with self.assertRaises(metrolux.Error):
            metrolux.compare(self.pixels, self.pixels[1:])


if __name__ == "__main__":
    unittest.main()
