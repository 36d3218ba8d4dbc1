"""Cameras by silhouettes: a pattern that emits is seen at the same place, as sharp and as blurred."""

import math
import unittest

import bpy
import numpy as np
import support


def pattern():
    """A plane and a near one, whose cells emit differently, so that all shifts and scales show."""
    scene = support.clear((80, 48))
    v, u = np.mgrid[0:16, 0:16]
    colors = np.stack([(u // 2 + v // 2) % 2, u / 15, v / 15], axis=2) + 0.02
    picture = support.image("Pattern", colors)

    def build(t):
        texture = support.new_node(t, "ShaderNodeTexImage", image=picture, interpolation="Closest")
        return support.new_node(t, "ShaderNodeEmission", {"Color": texture.outputs["Color"]})

    made_of = support.material("Pattern", build)
    support.mesh("plane", made_of, size=6)
    support.mesh("plane", made_of, size=0.8, location=(0.6, -2, 1), rotation=(1, 0, 0))
    return scene


class Cameras(unittest.TestCase):
    def same(self, name, blurred=False, samples=64):
        """Pixels differ by antialiasing alone: the mean difference is below 1 % of the mean, noise included."""
        ours, cycles = support.metrolux(samples), support.cycles(samples)
        from comparison import leave

        leave("camera-" + name, ours, cycles)
        difference = float(np.abs(ours - cycles).mean() / cycles.mean())
        shifted = float(np.abs(np.roll(ours, 1, axis=1) - cycles).mean() / cycles.mean())
        print(f"COMPARED camera {name}: mean difference {100 * difference:.2f} %, of a shift by a pixel {100 * shifted:.1f} %",
              flush=True)
        self.assertLess(difference, 0.02 if blurred else 0.015)
        self.assertLess(10 * difference, shifted)

    def test_perspective(self):
        pattern()
        support.camera((1, -5, 4), (0, 0, 0), 50)
        self.same("perspective")

    def test_sensor_fit_and_shift(self):
        pattern()
        for fit, x, y in (("VERTICAL", 0.2, -0.1), ("HORIZONTAL", -0.15, 0.1), ("AUTO", 0.1, 0.25)):
            camera = support.camera((1, -5, 4), (0, 0, 0), sensor_fit=fit, shift_x=x, shift_y=y, lens=40, sensor_width=36,
                                    sensor_height=20)
            camera.data.lens = 40
            self.same(f"shift-{fit.lower()}")

    def test_portrait(self):
        scene = pattern()
        scene.render.resolution_x, scene.render.resolution_y = 48, 80
        support.camera((1, -5, 4), (0, 0, 0), lens=40, shift_x=0.1, shift_y=0.1).data.lens = 40
        self.same("portrait")

    def test_orthographic(self):
        pattern()
        support.camera((1, -5, 4), (0, 0, 0), type="ORTHO", ortho_scale=5, shift_x=0.1, shift_y=-0.05)
        self.same("orthographic")

    def test_depth_of_field(self):
        pattern()
        camera = support.camera((1, -5, 4), (0, 0, 0), lens=50)
        camera.data.lens = 50
        dof = camera.data.dof
        dof.use_dof, dof.aperture_fstop = True, 0.1
        dof.focus_object = support.add_object("Focus", None, support.look_at((0.6, -2, 1), (0, 0, 0)))
        self.same("focus", blurred=True, samples=1024)

    def test_panorama(self):
        pattern()
        camera = support.camera((0, -1, 1), (0, 1, 0.5), type="PANO")
        settings = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
        settings.panorama_type = "EQUIRECTANGULAR"
        self.same("panorama")
        settings.panorama_type, settings.fisheye_fov = "FISHEYE_EQUIDISTANT", math.radians(180)
        bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 64
        self.same("fisheye")
