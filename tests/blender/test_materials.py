"""Materials and textures, next to Cycles' own: within 1 % where both compute the same, with a named difference where not."""

import math
import unittest

import numpy as np
import support
from comparison import checked, compare
from support import material, new_node
from test_lights import sky_pixels


def stage(made_of, smooth=True, floor=(0.6, 0.6, 0.6), shape="uv_sphere"):
    """A ball of the material on a floor below a sky with sun."""
    support.clear()
    support.mesh("plane", support.diffuse(floor, "Floor"), size=12)
    values = {"radius": 1, "segments": 128, "ring_count": 64} if shape == "uv_sphere" else {"size": 1.8}
    support.mesh(shape, made_of(), smooth=smooth, location=(0, 0, 1.2), **values)
    sky = support.image("Sky", np.minimum(sky_pixels(128), 4))

    def build(t):
        picture = new_node(t, "ShaderNodeTexEnvironment", image=sky)
        return new_node(t, "ShaderNodeBackground", {"Color": picture.outputs["Color"], "Strength": 1})

    support.world(build)
    support.camera((0, -5, 2.6), (0, 0, 1), 35)


def of(kind, **inputs):
    """A function that makes a material of one shader node; keywords with a capital are inputs, others properties."""
    properties = {name: value for name, value in inputs.items() if name[0].islower()}
    values = {name.replace("_", " "): value for name, value in inputs.items() if not name[0].islower()}
    return lambda: material(kind, lambda t: new_node(t, kind, values, **properties))


class Exact(unittest.TestCase):
    """Both compute the same."""

    def test_mirror(self):
        stage(of("ShaderNodeBsdfGlossy", Color=(0.9, 0.6, 0.3), Roughness=0.0, distribution="GGX"))
        checked(self, compare("mirror"))

    def test_glass(self):
        """Glass that is seen directly, and the floor through it. With flat faces: shading normals differ in refraction."""
        stage(of("ShaderNodeBsdfGlass", Color=(0.9, 1, 0.95), Roughness=0.0, distribution="GGX", IOR=1.5), smooth=False, shape="cube")
        support.bpy.data.objects["Cube"].rotation_euler = (0.3, 0.2, 0.5)
        checked(self, compare("glass", 384, 384))

    def test_translucent(self):
        stage(of("ShaderNodeBsdfTranslucent", Color=(0.7, 0.5, 0.3)), smooth=False, shape="plane")
        checked(self, compare("translucent", 128, 128))

    def test_mix_add_transparent(self):
        """0.3 of a red, 0.7 of a half transparent blue that glows: nested Mix and Add."""

        def build(t):
            red = new_node(t, "ShaderNodeBsdfDiffuse", {"Color": (0.8, 0.1, 0.1)})
            blue = new_node(t, "ShaderNodeBsdfDiffuse", {"Color": (0.1, 0.2, 0.4)})
            glow = new_node(t, "ShaderNodeEmission", {"Color": (0.2, 1, 0.3), "Strength": 0.3})
            green = new_node(t, "ShaderNodeBsdfDiffuse", {"Color": (0.05, 0.2, 0.1)})
            clear = new_node(t, "ShaderNodeBsdfTransparent")
            both = t.nodes.new("ShaderNodeAddShader")
            sum_of = t.nodes.new("ShaderNodeAddShader")
            for node, first, second in ((sum_of, blue, green), (both, sum_of, glow)):
                t.links.new(first.outputs[0], node.inputs[0])
                t.links.new(second.outputs[0], node.inputs[1])
            half, result = (new_node(t, "ShaderNodeMixShader", {"Fac": f}) for f in (0.5, 0.7))
            for node, first, second in ((half, both, clear), (result, red, half)):
                t.links.new(first.outputs[0], node.inputs[1])
                t.links.new(second.outputs[0], node.inputs[2])
            return result

        stage(lambda: material("Mixed", build))
        checked(self, compare("mix", 384, 384))


def colors(width=16, seed=3):
    """Pixels of many colors."""
    return np.random.default_rng(seed).uniform(0.05, 0.95, (width, width, 3))


class Textures(unittest.TestCase):
    """Pictures on a wall that faces the camera, below a white sky."""

    def setUp(self):
        support.clear()

    def wall(self, build):
        wall = support.mesh("plane", size=4, rotation=(math.pi / 2, 0, 0))
        wall.data.materials.append(material("Wall", build))
        support.world(lambda t: new_node(t, "ShaderNodeBackground", {"Color": (1, 1, 1), "Strength": 1}))
        support.camera((0, -5, 0), (0, 0, 0), 40)
        return wall

    def test_mapping(self):
        """A byte image in sRGB, moved, turned, scaled. (Cycles interpolates before it decodes, so that single texels differ.)"""
        picture = support.bpy.data.images.new("Bytes", 16, 16)
        full = np.concatenate([colors(), np.ones((16, 16, 1))], axis=2).astype(np.float32)
        picture.pixels.foreach_set(full.reshape(-1))
        picture.update()

        def build(t):
            uv = new_node(t, "ShaderNodeUVMap", uv_map="UVMap")
            mapping = new_node(t, "ShaderNodeMapping", {"Vector": uv.outputs[0], "Location": (0.1, 0.3, 0), "Rotation": (0, 0, 0.5),
                                                        "Scale": (1.5, 0.7, 1)})
            texture = new_node(t, "ShaderNodeTexImage", {"Vector": mapping.outputs[0]}, image=picture, interpolation="Closest")
            return new_node(t, "ShaderNodeBsdfDiffuse", {"Color": texture.outputs["Color"]})

        self.wall(build)
        checked(self, compare("mapping", 128, 128))

    def test_baked(self):
        """A color ramp of an image, mixed with a product, inverted: one picture in the end."""
        picture = support.image("Floats", colors())

        def build(t):
            texture = new_node(t, "ShaderNodeTexImage", image=picture, interpolation="Closest")
            ramp = new_node(t, "ShaderNodeValToRGB", {"Fac": texture.outputs["Color"]})
            ramp.color_ramp.elements[0].color = (0.9, 0.2, 0.1, 1)
            ramp.color_ramp.elements[1].color = (0.1, 0.3, 0.8, 1)
            half = new_node(t, "ShaderNodeMath", {0: 0.3, 1: 0.2}, operation="ADD")
            mixed = new_node(t, "ShaderNodeMixRGB", {"Fac": half.outputs[0], "Color1": ramp.outputs["Color"],
                                                     "Color2": texture.outputs["Color"]}, blend_type="MULTIPLY")
            hue = new_node(t, "ShaderNodeHueSaturation", {"Color": mixed.outputs["Color"], "Hue": 0.6, "Saturation": 0.7})
            inverted = new_node(t, "ShaderNodeInvert", {"Color": hue.outputs["Color"], "Fac": 0.5})
            return new_node(t, "ShaderNodeBsdfDiffuse", {"Color": inverted.outputs["Color"]})

        self.wall(build)
        checked(self, compare("baked", 128, 128))

    def test_vertex_colors_and_mask(self):
        picture = support.image("Mask", colors(8, 5), non_color=True)

        def build(t):
            attribute = new_node(t, "ShaderNodeVertexColor", layer_name="Tint")
            texture = new_node(t, "ShaderNodeTexImage", image=picture, interpolation="Closest")
            painted = new_node(t, "ShaderNodeBsdfDiffuse", {"Color": attribute.outputs["Color"]})
            clear = t.nodes.new("ShaderNodeBsdfTransparent")
            mix = new_node(t, "ShaderNodeMixShader", {"Fac": texture.outputs["Color"]})
            t.links.new(clear.outputs[0], mix.inputs[1])
            t.links.new(painted.outputs[0], mix.inputs[2])
            return mix

        wall = self.wall(build)
        for name, kind in (("Other", "FLOAT_COLOR"), ("Tint", "BYTE_COLOR")):
            layer = wall.data.color_attributes.new(name, kind, "CORNER")
            for index, color in enumerate(((1, 0.1, 0.1, 1), (0.1, 0.8, 0.2, 1), (0.1, 0.2, 0.7, 1), (0.5, 0.5, 0.5, 1))):
                layer.data[index].color = color
        checked(self, compare("mask", 128, 128))

    def test_normal_map(self):
        """Tilts within 25 degrees, lit by a sun: both shade the same."""
        tilt = np.random.default_rng(1).uniform(-0.4, 0.4, (8, 8, 2))
        normals = np.concatenate([tilt, np.sqrt(1 - (tilt**2).sum(axis=2, keepdims=True))], axis=2)
        picture = support.image("Normals", 0.5 * normals + 0.5, non_color=True)

        def build(t):
            texture = new_node(t, "ShaderNodeTexImage", image=picture, interpolation="Closest")
            bent = new_node(t, "ShaderNodeNormalMap", {"Color": texture.outputs["Color"], "Strength": 0.8}, uv_map="UVMap")
            return new_node(t, "ShaderNodeBsdfDiffuse", {"Color": (0.8, 0.8, 0.8), "Normal": bent.outputs[0]})

        self.wall(build)
        support.bpy.context.scene.world = None
        support.light("SUN", (1, -3, 2), energy=3, angle=0)
        # Metrolux has a shadowing term for what the tilt turns away; Cycles has another.
        checked(self, compare("normal-map", 64, 64), 0.02)

    def test_bump(self):
        v, u = np.mgrid[0:64, 0:64] / 64
        waves = 0.5 + 0.25 * np.sin(4 * np.pi * u) * np.cos(4 * np.pi * v)
        picture = support.image("Waves", np.repeat(waves[:, :, None], 3, axis=2), non_color=True)

        def build(t):
            texture = new_node(t, "ShaderNodeTexImage", image=picture)
            bump = new_node(t, "ShaderNodeBump", {"Height": texture.outputs["Color"], "Distance": 0.3, "Strength": 1})
            return new_node(t, "ShaderNodeBsdfDiffuse", {"Color": (0.8, 0.8, 0.8), "Normal": bump.outputs[0]})

        self.wall(build)
        support.bpy.context.scene.world = None
        support.light("SUN", (1, -3, 2), energy=3, angle=0)
        checked(self, compare("bump", 64, 64), 0.03)


class Volumes(unittest.TestCase):
    """What fills a ball, with and without a surface."""

    def ball(self, build, surface=None):
        def made():
            result = support.bpy.data.materials.new("Filled")
            nodes = support.tree(result)
            output = nodes.nodes.new("ShaderNodeOutputMaterial")
            nodes.links.new(build(nodes).outputs[0], output.inputs["Volume"])
            if surface:
                nodes.links.new(new_node(nodes, *surface).outputs[0], output.inputs["Surface"])
            return result

        stage(made)
        cycles = support.bpy.context.scene.cycles
        cycles.volume_bounces = cycles.max_bounces = 256

    def test_absorption(self):
        self.ball(lambda t: new_node(t, "ShaderNodeVolumeAbsorption", {"Color": (0.9, 0.5, 0.2), "Density": 1.3}))
        checked(self, compare("volume-absorption", 128, 128))

    def test_scatter(self):
        self.ball(lambda t: new_node(t, "ShaderNodeVolumeScatter", {"Color": (0.7, 0.8, 0.9), "Density": 1.2, "Anisotropy": 0.4}))
        checked(self, compare("volume-scatter", 512, 512), 0.02)

    def test_sum_of_scatter_and_absorption(self):
        def build(t):
            both = t.nodes.new("ShaderNodeAddShader")
            for i, kind in enumerate(("ShaderNodeVolumeScatter", "ShaderNodeVolumeAbsorption")):
                part = new_node(t, kind, {"Color": (0.8, 0.6, 0.4), "Density": 0.8})
                t.links.new(part.outputs[0], both.inputs[i])
            return both

        self.ball(build)
        checked(self, compare("volume-sum", 512, 512), 0.02)

    def test_principled(self):
        inputs = {"Color": (0.8, 0.5, 0.4), "Density": 1.5, "Absorption Color": (0.1, 0.2, 0.4), "Anisotropy": -0.3}
        self.ball(lambda t: new_node(t, "ShaderNodeVolumePrincipled", inputs))
        checked(self, compare("volume-principled", 512, 512), 0.02)

    def test_what_is_not_the_same_everywhere_is_named(self):
        def build(t):
            noise = t.nodes.new("ShaderNodeTexNoise")
            return new_node(t, "ShaderNodeVolumeScatter", {"Density": noise.outputs["Fac"]})

        self.ball(build)
        support.metrolux(1)
        self.assertIn("Noise Texture", support.bpy.data.texts["Metrolux report"].as_string())


class Different(unittest.TestCase):
    """Where the models differ: by how much, within a bound that a wrong parameter would exceed."""

    def differs(self, name, made_of, bound, most=0.08, **kind):
        stage(made_of, **kind)
        result = compare(name, 128, 128, parts=2)
        self.assertLess(result.worst, bound, str(result))
        self.assertLess(abs(result.metrolux.mean() / result.cycles.mean() - 1), most, str(result))

    def test_glass_ball(self):
        """Shading normals of a mesh with 16,384 faces in refraction."""
        self.differs("glass-ball", of("ShaderNodeBsdfGlass", Roughness=0.0, distribution="GGX", IOR=1.5), 0.02, 0.01)

    def test_rough_diffuse(self):
        self.differs("oren-nayar", of("ShaderNodeBsdfDiffuse", Color=(0.8, 0.5, 0.3), Roughness=0.8), 0.1)

    def test_rough_glossy(self):
        self.differs("glossy", of("ShaderNodeBsdfGlossy", Color=(0.9, 0.8, 0.5), Roughness=0.4, distribution="GGX"), 0.05)

    def test_rough_glass(self):
        self.differs("rough-glass", of("ShaderNodeBsdfGlass", Roughness=0.3, distribution="GGX", IOR=1.4), 0.1)

    def test_refraction(self):
        self.differs("refraction", of("ShaderNodeBsdfRefraction", Roughness=0.0, distribution="GGX", IOR=1.3), 0.3)

    def test_principled(self):
        kinds = {
            "plastic": {"Base_Color": (0.8, 0.2, 0.1), "Roughness": 0.3},
            "metal": {"Base_Color": (0.9, 0.7, 0.3), "Metallic": 1.0, "Roughness": 0.3},
            "glass": {"Base_Color": (0.9, 1, 0.9), "Transmission": 1.0, "Roughness": 0.1, "IOR": 1.45},
            "coat": {"Base_Color": (0.1, 0.2, 0.6), "Roughness": 0.6, "Clearcoat": 1.0, "Clearcoat_Roughness": 0.1},
            "sheen": {"Base_Color": (0.3, 0.1, 0.3), "Roughness": 0.8, "Sheen": 1.0},
            "alpha": {"Base_Color": (0.8, 0.2, 0.1), "Alpha": 0.4, "Emission": (0.1, 0.1, 0.4)},
        }
        for name, inputs in kinds.items():
            with self.subTest(name):
                self.differs("principled-" + name, of("ShaderNodeBsdfPrincipled", **inputs), 0.25)
