"""Scene.render(): the command's bits, the keywords, files, what interrupts it."""

import _thread
import gc
import os
import shutil
import signal
import threading
import time
import unittest

import numpy
from support import BALL_XML, TestCase, ball

import metrolux


class Render(TestCase):
    def test_has_the_bits_of_the_command(self):
        file = self.write("ball.xml", BALL_XML)
        scene = metrolux.load(file, width=20, define={"gray": 0.25})
        for integrator, parameters in {
            "path": {},
            "vcm": {"radius_alpha": 0.7, "correlation_aware": False},
            "mcmc_vcm": {"chain_inefficiency": 8, "kernel": "adaptive"},
        }.items():
            options = ["--no-correlation-aware"] if "correlation_aware" in parameters else []
            for name, value in parameters.items():
                if value is not False:
                    options += [f"--{name.replace('_', '-')}", value]
            result = self.command(
                "render", file, "-i", integrator, "--passes", 4, "--seed", 5, "--max-depth", 5, "-D", "width=20",
                "-D", "gray=0.25", "-o", "a.exr", "--aov", "albedo,depth,variance", "--overwrite", *options,
            )  # fmt: skip
            self.assertEqual(result.returncode, 0, result.stderr)
            image = scene.render(
                integrator, passes=4, seed=5, max_depth=5, layers=["albedo", "depth", "variance"],
                output=self.folder / "b.exr", threads=1, **parameters,
            )  # fmt: skip
            self.assertSameBits(image, metrolux.read(self.folder / "a.exr"), integrator)
            self.assertSameBits(image, metrolux.read(self.folder / "b.exr"), integrator)
            self.assertEqual(image.statistics["passes"], 4)
            self.assertEqual(image.statistics["integrator"], integrator)

    def test_gives_arrays_that_stand_alone(self):
        scene = metrolux.load_dict(ball())
        image = scene.render("path", passes=2, layers=["albedo", "normal", "depth", "variance"])
        self.assertIsInstance(image, numpy.ndarray)
        self.assertEqual((image.shape, image.dtype), ((16, 24, 3), numpy.float32))
        self.assertFalse(image.flags.owndata, "the library's own buffer")
        shapes = {name: layer.shape for name, layer in image.layers.items()}
        one, three = (16, 24, 1), (16, 24, 3)
        self.assertEqual(shapes, {"albedo": three, "normal": three, "depth": one, "variance": one})
        expected = image.copy()
        scene.render("path", passes=3)
        del scene
        gc.collect()
        self.assertSameBits(image, expected)
        image *= 2
        self.assertTrue(numpy.array_equal(image, 2 * expected))
        self.assertEqual(dict(expected.layers), {})

    def test_limits(self):
        scene = metrolux.load_dict(ball())
        self.assertEqual(scene.render("path", passes=3).statistics["stop_reason"], "passes")
        self.assertEqual(scene.render("path", time=0.05).statistics["stop_reason"], "time")
        self.assertEqual(scene.render("path", error=0.5, time=100).statistics["stop_reason"], "error")

    def test_errors_have_the_commands_text(self):
        scene = metrolux.load_dict(ball())
        for text, arguments in {
            "unknown integrator 'mcmc_vmc', did you mean 'mcmc_vcm'?": {"integrator": "mcmc_vmc"},
            "unknown parameter 'radus', did you mean 'radius'?": {"radus": 1},
            "expected a number from 0 to 1": {"radius_alpha": 2},
            "unknown AOV 'color'": {"layers": ["color"]},
            "radius: found list": {"radius": [1]},
            "expected .exr or .png": {"output": self.folder / "a.jpg"},
            "unknown tone curve 'log'": {"output": self.folder / "a.png", "curve": "log"},
        }.items():
            with self.assertRaises(metrolux.Error) as caught:
                scene.render(**{"integrator": "vcm", "passes": 1} | arguments)
            self.assertIn(text, str(caught.exception))
        with self.assertRaises(TypeError):
            scene.render("path", passes="many")
        with self.assertRaisesRegex(metrolux.Error, "absent.xml: the file does not exist"):
            metrolux.load("absent.xml")

    def test_progress(self):
        seen = []
        scene = metrolux.load_dict(ball())
        scene.render("vcm", passes=3, progress=seen.append)
        self.assertEqual([p.passes for p in seen], [1, 2, 3])
        self.assertGreater(seen[-1].seconds, 0)
        self.assertIn("pass 3", repr(seen[-1]))
        image = scene.render("vcm", time=100, progress=lambda p: p.passes < 2)
        self.assertEqual(image.statistics["passes"], 2)

    def test_what_the_progress_function_raises_brings_the_image(self):
        def fail(progress):
            raise LookupError(f"at pass {progress.passes}")

        with self.assertRaisesRegex(LookupError, "at pass 1") as caught:
            metrolux.load_dict(ball()).render("path", passes=5, progress=fail)
        self.assertSameBits(caught.exception.image, metrolux.load_dict(ball()).render("path", passes=1))

    def test_interrupt_ends_after_the_pass(self):
        scene = metrolux.load_dict(ball())
        passes = []

        def interrupt(progress):
            passes.append(progress.passes)
            if progress.passes == 2:
                os.kill(os.getpid(), signal.SIGINT)

        output = self.folder / "a.exr"
        with self.assertRaises(KeyboardInterrupt) as caught:
            scene.render("path", time=100, progress=interrupt, output=output)
        self.assertIsInstance(caught.exception, metrolux.Interrupted)
        image = caught.exception.image
        self.assertLessEqual(passes[-1], 3)
        self.assertSameBits(image, scene.render("path", passes=passes[-1]))
        self.assertSameBits(image, metrolux.read(output))

    def test_interrupt_in_the_last_pass_keeps_the_image(self):
        with self.assertRaises(metrolux.Interrupted) as caught:
            metrolux.load_dict(ball()).render(
                "path", passes=1, progress=lambda p: os.kill(os.getpid(), signal.SIGINT)
            )
        self.assertEqual(caught.exception.image.statistics["passes"], 1)

    def test_releases_the_interpreter(self):
        counted = []

        def count():
            end = time.monotonic() + 100
            while not counted and time.monotonic() < end:
                time.sleep(0.001)
            _thread.interrupt_main()

        scene = metrolux.load_dict(ball())
        other = threading.Thread(daemon=True, target=count)
        other.start()
        with self.assertRaises(metrolux.Interrupted):
            scene.render("path", time=200, progress=lambda p: counted.append(p.passes) if p.passes > 2 else None)
        other.join()

    def test_a_file_that_cannot_be_written_does_not_lose_the_image(self):
        folder = self.folder / "gone"
        folder.mkdir()
        working = os.getcwd()
        self.addCleanup(os.chdir, working)
        os.chdir(self.folder)  # where the image is rescued to

        def remove(progress):
            if progress.passes == 2:
                shutil.rmtree(folder)  # with the lock of the output

        with self.assertRaisesRegex(metrolux.Error, "gone/a.exr.*(?s:.)*the image is in") as caught:
            metrolux.load_dict(ball()).render("path", passes=2, output=folder / "a.exr", save_every=0, progress=remove)
        self.assertSameBits(caught.exception.image, metrolux.read(next(self.folder.glob("*.exr"))))

    def test_slices_that_are_merged_are_one_rendering(self):
        scene = metrolux.load_dict(ball())
        whole = scene.render("vcm", passes=8, slices=4)
        parts = [self.folder / "0", self.folder / "1"]
        for i, part in enumerate(parts):
            scene.render("vcm", passes=8, slices=4, only_slices=(2 * i, 2 * i + 1), checkpoint=part)
        statistics = metrolux.merge(parts, self.folder / "a.exr")
        self.assertEqual(statistics["passes"], 8)
        self.assertSameBits(metrolux.read(self.folder / "a.exr"), whole)


if __name__ == "__main__":
    unittest.main()
