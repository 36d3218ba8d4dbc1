"""What F12 does: passes, animation, cancel, border, report; the export; what several objects share."""

import glob
import math
import os
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from xml.etree import ElementTree

import bpy
import numpy as np
import support


def simple(size=(48, 32)):
    scene = support.clear(size)
    support.mesh("plane", support.diffuse((0.8, 0.6, 0.4)), size=8)
    support.mesh("cube", support.diffuse((0.2, 0.5, 0.8), "Blue"), size=1.2, location=(0, 0, 0.7), rotation=(0.3, 0, 0.4))
    support.light("POINT", (1.5, -1.5, 4), energy=300, shadow_soft_size=0)
    support.camera((0, -6, 4), (0, 0, 0.3), 45)
    return scene


# Of this process alone: other tests render at the same time.
tempfile.tempdir = tempfile.mkdtemp(prefix="blender-engine-")


def leftovers():
    return glob.glob(os.path.join(tempfile.gettempdir(), "metrolux-*"))


def tearDownModule():
    os.rmdir(tempfile.tempdir)


def report():
    text = bpy.data.texts.get("Metrolux report")
    return text.as_string() if text else ""


class Engine(unittest.TestCase):
    def setUp(self):
        self.before = leftovers()

    def tearDown(self):
        self.assertEqual(leftovers(), self.before, "the folder of a render was left")

    def multilayer(self, engine):
        scene = bpy.context.scene
        scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
        with support.rendered(engine) as (_, channels):
            return {name.split(".", 1)[1]: pixels for name, pixels in channels.items()}

    def test_passes(self):
        """Depth and normal as Cycles has them; albedo is the color; variance shrinks with the passes."""
        scene = simple()
        layer = bpy.context.view_layer
        layer.use_pass_z = layer.use_pass_normal = True
        layer.metrolux.use_albedo = layer.metrolux.use_variance = True
        bpy.data.cameras[0].shift_x = 0.1
        scene.metrolux.passes = 8
        ours = self.multilayer("METROLUX")
        scene.cycles.samples, scene.cycles.pixel_filter_type, scene.cycles.use_denoising = 16, "BOX", False
        cycles = self.multilayer("CYCLES")
        hit = (cycles["Depth.Z"] < 1e9) & (ours["Depth.Z"] < 1e9)
        self.assertGreater(hit.mean(), 0.5)
        self.assertGreater(((ours["Depth.Z"] > 1e9) == (cycles["Depth.Z"] > 1e9)).mean(), 0.95)
        self.assertLess(np.median(np.abs(ours["Depth.Z"] / cycles["Depth.Z"] - 1)[hit]), 0.01)
        for axis in "XYZ":
            self.assertLess(np.median(np.abs(ours["Normal." + axis] - cycles["Normal." + axis])[hit]), 0.01)
        self.assertAlmostEqual(float(np.median(ours["Albedo.R"][-4:])), 0.8, 2)
        scene.metrolux.passes = 64
        more = self.multilayer("METROLUX")
        self.assertLess(more["Variance.X"].mean(), 0.5 * ours["Variance.X"].mean())

    def test_transparent_film(self):
        """Where nothing is, alpha is 0 and the sky is not there."""
        scene = simple()
        scene.world.color = (1, 1, 1)
        scene.render.film_transparent, scene.metrolux.passes = True, 16
        with support.rendered("METROLUX") as (_, channels):
            alpha, colors = channels["A"], support.rgb(channels)
        self.assertLess(float(alpha[:2].max()), 0.01)
        self.assertLess(float(colors[:2].max()), 0.01)
        self.assertGreater(float(alpha[-4:].min()), 0.99)
        self.assertGreater(float(colors[-4:].min()), 0.1)

    def test_limits_and_integrator(self):
        """The default integrator, by time, with a parameter of its own."""
        scene = simple()
        scene.metrolux.integrator, scene.metrolux.time = "mcmc_vcm", 1
        scene.metrolux.parameters.chain_inefficiency, scene.metrolux.parameters.variance_aware = "8", "false"
        start = time.time()
        with support.rendered("METROLUX") as (_, channels):
            self.assertGreater(channels["R"].mean(), 0.01)
        self.assertLess(time.time() - start, 20)
        scene.metrolux.parameters.chain_inefficiency = "many"
        with self.assertRaisesRegex(RuntimeError, "chain-inefficiency"), support.rendered("METROLUX"):
            pass

    def test_animation(self):
        scene = simple()
        cube = bpy.data.objects["Cube"]
        for frame, x in ((1, -1.5), (3, 1.5)):
            cube.location.x = x
            cube.keyframe_insert("location", frame=frame)
        scene.frame_start, scene.frame_end = 1, 3
        scene.render.engine, scene.metrolux.passes = "METROLUX", 16
        with tempfile.TemporaryDirectory() as folder:
            scene.render.filepath = os.path.join(folder, "frame-")
            bpy.ops.render.render(animation=True)
            files = sorted(os.listdir(folder))
            self.assertEqual(files, ["frame-0001.exr", "frame-0002.exr", "frame-0003.exr"])
            columns = []
            for file in files:
                blue = support.rgb(support._exr().read(os.path.join(folder, file))[1])
                weight = np.maximum(blue[:, :, 2] - blue[:, :, 0], 0)
                columns.append(float((weight.sum(axis=0) * np.arange(weight.shape[1])).sum() / weight.sum()))
        self.assertGreater(columns[1] - columns[0], 3)
        self.assertGreater(columns[2] - columns[1], 3)

    def test_border(self):
        """The part has the pixels of the whole, up to antialiasing noise; outside of it nothing is."""
        scene = simple((60, 40))
        whole = support.metrolux(64)
        scene.render.use_border = True
        scene.render.border_min_x, scene.render.border_max_x = 0.3, 0.7
        scene.render.border_min_y, scene.render.border_max_y = 0.5, 0.9
        part = support.metrolux(64)
        self.assertEqual(part.shape, whole.shape)
        inside = np.zeros(part.shape[:2], bool)
        inside[4:20, 18:42] = True
        self.assertLess(np.abs(part - whole)[inside].mean(), 0.05 * whole[inside].mean())
        self.assertEqual(float(np.abs(part[~inside]).max()), 0)
        scene.render.use_crop_to_border = True
        cropped = support.metrolux(64)
        np.testing.assert_array_equal(cropped, part[4:20, 18:42])

    def test_cancel(self):
        """Ctrl-C ends the render soon, with the image so far."""
        scene = simple()
        scene.metrolux.time, scene.metrolux.passes = 300, 0
        threading.Timer(3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        start = time.time()
        scene.render.engine = "METROLUX"
        bpy.ops.render.render()
        self.assertLess(time.time() - start, 60)

    def test_missing_command(self):
        simple()
        command = os.environ["METROLUX_COMMAND"]
        os.environ["METROLUX_COMMAND"] = "/nowhere/metrolux"
        try:
            with self.assertRaisesRegex(RuntimeError, "/nowhere/metrolux is no program"), support.rendered("METROLUX"):
                pass
        finally:
            os.environ["METROLUX_COMMAND"] = command

    def test_report(self):
        """What is not supported is named with what it is on, in the text; a clean scene empties the list."""
        scene = simple()

        def noisy(t):
            noise = t.nodes.new("ShaderNodeTexNoise")
            return support.new_node(t, "ShaderNodeBsdfDiffuse", {"Color": noise.outputs["Color"]})

        cube = bpy.data.objects["Cube"]
        clean = cube.data.materials[0]
        cube.data.materials[0] = support.material("Noisy", noisy)
        hair = support.material("Hairy", lambda t: t.nodes.new("ShaderNodeBsdfHair"))
        support.mesh("cube", hair, size=0.2, location=(1, 0, 2))
        smoke = support.material("Smoke", lambda t: t.nodes.new("ShaderNodeBsdfTransparent"))
        t = smoke.node_tree
        volume = t.nodes.new("ShaderNodeVolumePrincipled")
        t.links.new(volume.outputs[0], t.nodes["Material Output"].inputs["Volume"])
        volume.inputs["Emission Strength"].default_value = 1
        support.mesh("cube", smoke, size=0.2, location=(-1, 0, 2))
        support.light("AREA", (0, 0, 5), energy=1, name="Narrow", spread=0.5)
        scene.metrolux.passes = 1
        support.metrolux(1)
        for line in ("material Noisy: the node Noise Texture", "material Hairy: the shader Hair BSDF", "material Smoke: Emission Strength",
                     "light Narrow: a spread"):
            self.assertIn(line, report())
        for name in ("Cube.001", "Cube.002", "Narrow"):
            bpy.data.objects.remove(bpy.data.objects[name])
        cube.data.materials[0] = clean
        support.metrolux(1)
        self.assertIn("Everything was rendered", report())

    def test_no_camera(self):
        scene = simple()
        scene.camera = None
        with self.assertRaises(RuntimeError), support.rendered("METROLUX"):
            pass


class Export(unittest.TestCase):
    def export(self, folder):
        path = os.path.join(folder, "out.xml")
        bpy.ops.export_scene.metrolux(filepath=path)
        return path

    def test_folder_is_complete(self):
        """The folder can be moved and renders; pictures are in it."""
        simple()
        picture = support.image("Dots", np.random.default_rng(1).uniform(0, 1, (4, 4, 3)))

        def build(t):
            texture = support.new_node(t, "ShaderNodeTexImage", image=picture)
            return support.new_node(t, "ShaderNodeBsdfDiffuse", {"Color": texture.outputs["Color"]})

        bpy.data.objects["Cube"].data.materials[0] = support.material("Dots", build)
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(folder + "/a")
            self.export(folder + "/a")
            os.rename(folder + "/a", folder + "/b")
            image = folder + "/image.exr"
            subprocess.run([os.environ["METROLUX_COMMAND"], "render", folder + "/b/out.xml", "-o", image, "--strict", "--passes", "4",
                            "-i", "path", "--quiet"], check=True)
            self.assertGreater(support._exr().read(image)[1]["R"].mean(), 0.01)

    def test_instances(self):
        """Copies of a mesh are one file; each has its place, mirrored ones too."""
        simple((64, 64))
        cube = bpy.data.objects["Cube"]
        bevel = cube.modifiers.new("Bevel", "BEVEL")
        bevel.width, bevel.segments = 0.2, 3
        group = bpy.data.collections.new("Group")
        group.objects.link(cube)
        for place, scale in (((-1.8, 0.5, 0.2), (1, 1, 1)), ((1.8, 0.5, 0), (-0.8, 1, 1)), ((0.5, 1.8, 0), (1, 0.5, 1.5))):
            empty = support.add_object("Place", None)
            empty.instance_type, empty.instance_collection = "COLLECTION", group
            empty.location, empty.scale = place, scale
        with tempfile.TemporaryDirectory() as folder:
            scene = ElementTree.parse(self.export(folder)).getroot()
            self.assertEqual(len(glob.glob(folder + "/meshes/*.ply")), 2)
            self.assertEqual([s.get("type") for s in scene.iter("shape")].count("instance"), 4)
        from comparison import checked, compare

        checked(self, compare("instances", 256, 256))

    def test_split_normals(self):
        """Auto smooth: sharp edges stay sharp, as in Cycles. A plain mirror shows where normals point."""
        support.clear()
        chrome = support.material("Chrome", lambda t: support.new_node(t, "ShaderNodeBsdfGlossy", {"Color": (0.9, 0.9, 0.9),
                                                                                              "Roughness": 0}, distribution="GGX"))
        drum = support.mesh("cylinder", chrome, smooth=True, vertices=64, radius=1, depth=1.5, rotation=(0.6, 0.2, 0))
        if hasattr(drum.data, "use_auto_smooth"):
            drum.data.use_auto_smooth, drum.data.auto_smooth_angle = True, math.radians(30)
        else:
            bpy.ops.object.shade_smooth_by_angle(angle=math.radians(30))
        from comparison import checked, compare
        from test_lights import sky_pixels

        sky = support.image("Sky", np.minimum(sky_pixels(), 2))

        def build(t):
            texture = support.new_node(t, "ShaderNodeTexEnvironment", image=sky)
            return support.new_node(t, "ShaderNodeBackground", {"Color": texture.outputs["Color"]})

        support.world(build)
        support.camera((0, -5, 0), (0, 0, 0), 30)
        checked(self, compare("split-normals", 64, 64))


class Settings(unittest.TestCase):
    def test_parameters_are_fresh(self):
        """parameters.json is what tools/blender_parameters.py makes of this command."""
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        made = subprocess.run([os.environ.get("METROLUX_PYTHON", "python3"), root + "/tools/blender_parameters.py",
                               os.environ["METROLUX_COMMAND"]], check=True, capture_output=True, text=True).stdout
        with open(root + "/blender/metrolux/parameters.json", encoding="utf-8") as file:
            self.assertEqual(file.read(), made, "run `make blender-parameters`")

    def test_integrators_are_those_of_the_command(self):
        text = subprocess.run([os.environ["METROLUX_COMMAND"], "integrators"], check=True, capture_output=True, text=True).stdout
        from metrolux import settings

        self.assertEqual(list(settings.INTEGRATORS), [line.split()[0] for line in text.splitlines()])

    def test_reference_is_fresh(self):
        """The tables of docs/reference/blender.md are what the exporter says."""
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        from metrolux.export import reference_page

        with open(root + "/docs/reference/blender.md", encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page, reference_page.updated(page), "run `make blender-reference`")
