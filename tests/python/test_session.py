"""Sessions: steps, iteration, views, stop, threads, checkpoints."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy
from support import BALL_XML, TestCase, ball

import metrolux


class Session(TestCase):
    def setUp(self):
        super().setUp()
        self.scene = metrolux.load_dict(ball())

    def test_iterates_until_its_limit(self):
        session = self.scene.session("vcm", seed=2, passes=3)
        images = [image.copy() for image in session]
        self.assertEqual(len(images), 3)
        self.assertSameBits(images[-1], self.scene.render("vcm", seed=2, passes=3))
        self.assertFalse(numpy.array_equal(images[0], images[1]))
        self.assertEqual(list(session), [], "the limit holds")
        self.assertEqual(session.progress.passes, 3)
        self.assertEqual(session.statistics["stop_reason"], "passes")

    def test_iterates_without_limits_until_it_is_stopped(self):
        session = self.scene.session("path")
        for image in session:
            if session.progress.passes == 4:
                session.stop()
        self.assertEqual(session.progress.passes, 4)
        session.stop()
        self.assertEqual(list(session), [])
        self.assertSameBits(session.render(passes=6), self.scene.render("path", passes=6))
        self.assertIs(iter(session), session)

    def test_views_are_the_sessions_own_memory(self):
        session = self.scene.session("path", layers=["albedo", "depth", "variance"])
        first = session.step()
        address = first.__array_interface__["data"][0]
        before = first.copy()
        second = session.step()
        self.assertEqual(second.__array_interface__["data"][0], address)
        self.assertFalse(numpy.array_equal(first, before))
        self.assertFalse(first.flags.writeable)
        self.assertEqual(session.layers["variance"].__array_interface__, session.variance.__array_interface__)
        self.assertEqual(session.layers["albedo"].shape, (16, 24, 3))
        self.assertEqual(session.layers["depth"].shape, (16, 24, 1))
        depth = session.layers["depth"]
        expected = depth.copy()
        del session
        self.assertSameBits(depth, expected, "a view keeps its session")

    def test_is_stopped_by_another_thread(self):
        session = self.scene.session("path")
        begun = threading.Event()
        stopper = threading.Thread(daemon=True, target=lambda: (begun.wait(), session.stop()))
        stopper.start()
        start = time.monotonic()
        session.render(time=100, progress=lambda p: begun.set())
        stopper.join()
        self.assertLess(time.monotonic() - start, 50)
        self.assertEqual(session.statistics["stop_reason"], "interrupted")

    def test_belongs_to_one_thread_while_it_renders(self):
        session = self.scene.session("path")
        begun, errors = threading.Event(), []

        def other():
            begun.wait()
            for use in (lambda: session.image, lambda: session.step(), lambda: session.save(self.folder / "a")):
                try:
                    use()
                except metrolux.Error as error:
                    errors.append(str(error))
            session.stop()

        def watch(progress):
            self.assertEqual(session.progress.passes, progress.passes, "its own functions may look")
            self.assertEqual(session.image.shape, (16, 24, 3))
            with self.assertRaisesRegex(metrolux.Error, "is rendering"):
                session.step()
            begun.set()

        thread = threading.Thread(daemon=True, target=other)
        thread.start()
        session.render(time=100, progress=watch)
        thread.join()
        self.assertEqual(len(errors), 3, errors)
        self.assertIn("only stop() may be called", errors[0])

    def test_several_render_at_the_same_time(self):
        expected = {integrator: self.scene.render(integrator, passes=20) for integrator in ("path", "vcm", "mcmc_vcm")}
        images = {}

        def render(integrator):
            images[integrator] = metrolux.load_dict(ball()).render(integrator, passes=20, threads=2)

        threads = [threading.Thread(daemon=True, target=render, args=[integrator]) for integrator in expected]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for integrator, image in expected.items():
            self.assertSameBits(images[integrator], image, integrator)

    def test_the_interpreter_ends_while_a_thread_renders(self):
        code = """
import sys, threading, time, metrolux
from support import ball
begun = threading.Event()
def render():
    for image in metrolux.load_dict(ball()).session("path"):
        begun.set()
threading.Thread(target=render, daemon=True).start()
begun.wait()
"""
        for _ in range(5):
            result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100)
            self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_interrupt_leaves_the_session_usable(self):
        session = self.scene.session("path")
        with self.assertRaises(metrolux.Interrupted) as caught:
            session.render(time=100, progress=lambda p: os.kill(os.getpid(), signal.SIGINT))
        passes = session.progress.passes
        self.assertSameBits(caught.exception.image, self.scene.render("path", passes=passes))
        self.assertSameBits(session.render(passes=passes + 2), self.scene.render("path", passes=passes + 2))

    def test_a_hundred_steps_stopped_and_resumed_are_those_without_a_stop(self):
        for integrator in ("path", "vcm", "mcmc_vcm"):
            whole = self.scene.session(integrator, seed=7)
            for _ in range(100):
                whole.step()
            part = self.scene.session(integrator, seed=7)
            for _ in part:
                if part.progress.passes == 37:
                    part.stop()
            part.save(self.folder / "state")
            rest = metrolux.load_dict(ball()).session(integrator, seed=7, passes=100)
            rest.resume(self.folder / "state")
            self.assertEqual(rest.progress.passes, 37)
            self.assertEqual(sum(1 for _ in rest), 63)
            self.assertSameBits(rest.image, whole.image, integrator)

    def test_checkpoints_are_those_of_the_command(self):
        file = self.write("ball.xml", BALL_XML)
        result = self.command("render", file, "--passes", 2, "--seed", 5, "--checkpoint", "state")
        self.assertEqual(result.returncode, 0, result.stderr)
        scene = metrolux.load(file)
        image = scene.render(seed=5, passes=5, resume=self.folder / "state")
        self.assertSameBits(image, scene.render(seed=5, passes=5))
        with self.assertRaisesRegex(metrolux.Error, "seed: found 6, expected 5"):
            scene.session(seed=6).resume(self.folder / "state")

    def test_writes_files(self):
        session = self.scene.session("path", passes=2, layers=["normal"])
        image = session.render(output=[self.folder / "a.exr", str(self.folder / "a.png")], exposure=1)
        self.assertSameBits(metrolux.read(self.folder / "a.exr"), image)
        session.save_image(self.folder / "b.png", exposure=1)
        self.assertSameBits(metrolux.read(self.folder / "a.png"), metrolux.read(self.folder / "b.png"))

    def test_says_what_it_is(self):
        session = self.scene.session("scene", threads=1)
        self.assertEqual((session.integrator, session.threads), ("path", 1))
        self.assertEqual(session.scene.resolution, (24, 16))
        self.assertEqual(repr(session), "<metrolux.Session path of scene, 0 passes>")


if __name__ == "__main__":
    unittest.main()
