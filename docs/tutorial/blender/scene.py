"""The scene of docs/tutorial/blender.md, and its pictures: blender -b -P scene.py -- FOLDER SECONDS

With the add-on enabled it can be run in Blender's text editor, too; then it only makes the scene.
"""

import math
import os
import sys

import bpy


def material(name, shader, **inputs):
    """A material of one shader node: its inputs by name, with _ for spaces."""
    result = bpy.data.materials.new(name)
    result.use_nodes = True
    tree = result.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return result


def add(operator, made_of, smooth=True, **values):
    getattr(bpy.ops.mesh, f"primitive_{operator}_add")(**values)
    thing = bpy.context.object
    thing.data.materials.append(made_of)
    thing.data.polygons.foreach_set("use_smooth", [smooth] * len(thing.data.polygons))
    return thing


def make_scene():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0, 0, 0)

    add("plane", material("Floor", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.62, 0.52, 1)), size=30)
    glass = material("Glass", "ShaderNodeBsdfGlass", IOR=1.5, Roughness=0.0)
    add("uv_sphere", glass, segments=128, ring_count=64, radius=0.8, location=(-1.2, 0, 0.8))
    gold = material("Gold", "ShaderNodeBsdfGlossy", Color=(0.95, 0.7, 0.3, 1), Roughness=0.15)
    gold.node_tree.nodes["Glossy BSDF"].distribution = "GGX"
    ring = add("cylinder", gold, vertices=128, radius=0.9, depth=0.7, end_fill_type="NOTHING", location=(1.2, 0.3, 0.36))
    ring.modifiers.new("Thickness", "SOLIDIFY").thickness = 0.06
    monkey = add("monkey", material("Paint", "ShaderNodeBsdfPrincipled", Base_Color=(0.1, 0.25, 0.5, 1), Roughness=0.3),
                 size=1.5, location=(0.2, 2.6, 0.75), rotation=(math.radians(-25), 0, math.radians(-15)))
    monkey.modifiers.new("Smooth", "SUBSURF").render_levels = 2

    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 600, 0.05
    thing = bpy.data.objects.new("Lamp", lamp)
    thing.location = (3, 3, 4)
    scene.collection.objects.link(thing)

    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -5.5, 3.2), (math.radians(63), 0, 0)
    camera.data.lens = 35
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 480, 270
    scene.view_settings.view_transform = "Standard"
    return scene


def render(scene, engine, path):
    scene.render.engine = engine
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def main(folder, seconds):
    scene = make_scene()
    scene.metrolux.time = seconds
    render(scene, "METROLUX", os.path.join(folder, "blender-metrolux.png"))
    scene.cycles.time_limit, scene.cycles.samples = seconds, 1 << 20
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    render(scene, "CYCLES", os.path.join(folder, "blender-cycles.png"))


if __name__ == "__main__":
    if "--" in sys.argv:
        arguments = sys.argv[sys.argv.index("--") + 1 :]
        main(arguments[0], float(arguments[1]))
    else:
        make_scene().render.engine = "METROLUX"
