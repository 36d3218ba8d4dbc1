"""Scenes made in Blender, rendered by Cycles and by Metrolux, and compared patch by patch."""

import contextlib
import math
import os
import sys
import tempfile

import addon_utils
import bpy
import numpy as np

PICTURES = os.environ.get("METROLUX_BLENDER_PICTURES", "")  # a folder: the tests leave their pictures there


def enable():
    """Installs the add-on from its zip file into the scripts' folder of this run, and enables it."""
    bpy.ops.preferences.addon_install(filepath=os.environ["METROLUX_ADDON"], overwrite=True)
    if addon_utils.enable("metrolux") is None:
        sys.exit("the add-on cannot be enabled")


def clear(size=(64, 64)):
    """An empty scene with a black world; the add-on stays."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    addon_utils.enable("metrolux")
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0, 0, 0)
    settings = scene.metrolux
    settings.integrator, settings.time, settings.filter, settings.threads = "path", 0, "box", 2
    return scene


def add_object(name, data, matrix=None):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    if matrix is not None:
        thing.matrix_world = matrix
    return thing


def look_at(position, target, up=(0, 0, 1)):
    from mathutils import Matrix, Vector

    z = (Vector(position) - Vector(target)).normalized()
    x = Vector(up).cross(z).normalized() if abs(Vector(up).dot(z)) < 0.9999 else Vector((1, 0, 0))
    y = z.cross(x)
    return Matrix((
        (x[0], y[0], z[0], position[0]), (x[1], y[1], z[1], position[1]), (x[2], y[2], z[2], position[2]), (0, 0, 0, 1)))


def camera(position, target, angle=40, **values):
    data = bpy.data.cameras.new("Camera")
    data.angle = math.radians(angle)
    for name, value in values.items():
        setattr(data, name, value)
    thing = add_object("Camera", data, look_at(position, target))
    bpy.context.scene.camera = thing
    return thing


def light(kind, position, target=(0, 0, 0), energy=100, name=None, **values):
    data = bpy.data.lights.new(name or kind.title(), kind)
    data.energy = energy
    for key, value in values.items():
        setattr(data, key, value)
    return add_object(data.name, data, look_at(position, target))


def tree(owner):
    owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


# Names of the sockets of 3.4 in 4.x.
NEW_NAMES = {"Transmission": "Transmission Weight", "Clearcoat": "Coat Weight", "Clearcoat Roughness": "Coat Roughness",
             "Sheen": "Sheen Weight", "Emission": "Emission Color"}


def new_node(nodes, kind, inputs=None, **values):
    """A node with properties and inputs: a value, or an output socket to link."""
    node = nodes.nodes.new(kind)
    for name, value in values.items():
        setattr(node, name, value)
    for name, value in (inputs or {}).items():
        socket = node.inputs[name if not isinstance(name, str) or name in node.inputs else NEW_NAMES[name]]
        if isinstance(value, bpy.types.NodeSocket):
            nodes.links.new(value, socket)
        elif hasattr(socket.default_value, "__len__") and len(socket.default_value) == 4 and len(value) == 3:
            socket.default_value = (*value, 1)
        else:
            socket.default_value = value
    return node


def material(name, build):
    """A material whose surface is the output of the node that build(tree) returns."""
    result = bpy.data.materials.new(name)
    nodes = tree(result)
    shader = build(nodes)
    output = nodes.nodes.new("ShaderNodeOutputMaterial")
    nodes.links.new(shader.outputs[0], output.inputs["Surface"])
    return result


def diffuse(color, name="Diffuse"):
    return material(name, lambda t: new_node(t, "ShaderNodeBsdfDiffuse", {"Color": color}))


def world(build):
    """A world whose surface is the node that build(tree) returns."""
    nodes = tree(bpy.context.scene.world)
    shader = build(nodes)
    output = nodes.nodes.new("ShaderNodeOutputWorld")
    nodes.links.new(shader.outputs[0], output.inputs["Surface"])


def mesh(operator, made_of=None, smooth=False, **values):
    """An object of one of Blender's primitives: mesh("plane", size=4)."""
    getattr(bpy.ops.mesh, f"primitive_{operator}_add")(**values)
    thing = bpy.context.object
    if made_of is not None:
        thing.data.materials.append(made_of)
    if smooth:
        thing.data.polygons.foreach_set("use_smooth", [True] * len(thing.data.polygons))
    return thing


def image(name, pixels, non_color=False):
    """An image of Blender from linear pixels, shape (height, width, 3), top row first."""
    height, width, _ = pixels.shape
    result = bpy.data.images.new(name, width, height, float_buffer=True, is_data=non_color)
    full = np.concatenate([pixels, np.ones((height, width, 1))], axis=2)[::-1].astype(np.float32)
    result.pixels.foreach_set(full.reshape(-1))
    result.update()
    return result


def _exr():
    from metrolux import exr

    return exr


@contextlib.contextmanager
def rendered(engine, name="render"):
    """Renders with F12's operator; gives the channels of the file."""
    scene = bpy.context.scene
    scene.render.engine = engine
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, name + ".exr")
        bpy.ops.render.render(write_still=True)
        yield _exr().read(scene.render.filepath)


def rgb(channels):
    return np.stack([channels[c] for c in "RGB"], axis=2)


def cycles(samples, seed=0):
    scene = bpy.context.scene
    settings = scene.cycles
    settings.samples, settings.seed = samples, seed
    settings.use_adaptive_sampling = settings.use_denoising = False
    settings.sample_clamp_direct = settings.sample_clamp_indirect = 0
    settings.blur_glossy = 0
    settings.pixel_filter_type, settings.filter_width = "BOX", 1
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(settings, name, 32)
    settings.light_sampling_threshold = 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    with rendered("CYCLES") as (_, channels):
        return rgb(channels)


def metrolux(passes, seed=0):
    settings = bpy.context.scene.metrolux
    settings.passes, settings.seed = passes, seed
    with rendered("METROLUX") as (_, channels):
        return rgb(channels)
