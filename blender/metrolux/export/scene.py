"""A scene of Blender as a folder with scene.xml, meshes and pictures."""

import os
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from . import camera, world, xml
from .lights import Lights, is_sun_disk, strength
from .materials import Materials
from .meshes import Meshes
from .pictures import PictureFiles
from .problems import Problems
from .xml import add, plugin, reference, transform

_MESHES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
_SILENT = {"EMPTY", "CAMERA", "LIGHT", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}


@dataclass
class Options:
    """What a scene does not say itself. `size`: of the image in pixels."""

    size: tuple
    filter: str = "gaussian"
    max_depth: int = -1
    hide_lamps: bool = True
    copies: bool = False  # pictures of the user's are copied into the folder


class SceneExport:
    """Writes a depsgraph into a folder; `problems` has what could not be written as it is."""

    def __init__(self, folder, depsgraph, options):
        self.problems = Problems()
        self._folder, self._depsgraph, self._options = folder, depsgraph, options
        files = PictureFiles(folder, options.copies)
        self._files = files
        self._materials = Materials(files, self.problems)
        self._meshes = Meshes(folder, self.problems)
        self._lights = Lights(folder, self.problems)
        self._suns = []
        self._shared = {}  # what draws the same mesh: {key: (parts, [matrices])}
        self._emissive = False

    def write(self, file="scene.xml"):
        """Writes everything; returns the path of the scene."""
        scene = self._depsgraph.scene_eval
        self._check_scene(scene)
        self._collect()
        shapes = [shape for key, entry in self._shared.items() for shape in self._shapes(key, *entry)]
        sky = world.emitter(scene.world, self._suns, self._files, self.problems)
        root = ElementTree.Element("scene", {"version": "3.0.0"})
        root.append(self._integrator(scene, sky))
        if scene.camera is None:
            raise ValueError("the scene has no camera")
        eye = scene.camera.evaluated_get(self._depsgraph)
        root.append(camera.sensor(eye, self._depsgraph, self._options.size, self._options.filter, self.problems))
        root.extend(self._materials.elements)
        root.extend(shapes)
        root.extend(self._lights.elements)
        if sky is not None:
            root.append(sky)
        path = os.path.join(self._folder, file)
        xml.write(path, root)
        return path

    def _check_scene(self, scene):
        if scene.render.use_motion_blur:
            self.problems.add("scene", "motion blur is not supported; nothing moves")
        if scene.render.use_multiview:
            self.problems.add("scene", "stereoscopy is not supported; one view is rendered")

    def _integrator(self, scene, sky):
        """Cycles' lamps are invisible to the camera. Metrolux can hide all that emits, or nothing."""
        hides = self._options.hide_lamps and bool(self._lights.shapes) and not self._emissive
        hides = hides and (sky is None or scene.render.film_transparent)
        if scene.render.film_transparent and sky is not None:
            if self._emissive:
                self.problems.add("scene", "a transparent film with meshes that emit shows the sky; its alpha is right")
            else:
                hides = True
        if not hides and self._options.hide_lamps:
            self._name_lamps_in_view(scene)
        return plugin("integrator", "path", max_depth=self._options.max_depth, hide_emitters=hides)

    def _name_lamps_in_view(self, scene):
        from bpy_extras.object_utils import world_to_camera_view
        from mathutils import Vector

        if scene.camera is None:
            return
        for thing, position in self._lights.shapes:
            x, y, z = world_to_camera_view(scene, scene.camera, Vector(position))
            if -0.05 < x < 1.05 and -0.05 < y < 1.05 and z > 0:
                self.problems.add(thing, "the lamp may be seen in the picture, which in Cycles it is not")

    def _collect(self):
        for instance in self._depsgraph.object_instances:
            thing = instance.object
            if not instance.show_self and not instance.is_instance:
                continue
            matrix = np.array(instance.matrix_world)
            if thing.type == "LIGHT":
                self._add_light(thing, matrix)
            elif thing.type in _MESHES:
                self._add_mesh(thing, matrix)
            elif thing.type not in _SILENT:
                self.problems.add(thing.name, f"objects of the type {thing.type} are not supported; it is left out")
            if instance.particle_system and instance.particle_system.settings.render_type == "PATH":
                self.problems.add(thing.name, "hair is not supported; it is left out")

    def _add_light(self, thing, matrix):
        light = thing.data
        if is_sun_disk(light):
            power = np.maximum(strength(light, self.problems, f"light {thing.name}"), 0)
            if np.any(power > 0):
                self._suns.append((matrix[:3, 2] / np.linalg.norm(matrix[:3, 2]), power, light.angle))
            return
        self._lights.add(light, thing.name, matrix)

    def _add_mesh(self, thing, matrix):
        if any(system.settings.type == "HAIR" and system.settings.render_type == "PATH"
               for system in thing.particle_systems):
            self.problems.add(thing.name, "hair is not supported; it is left out")
        if getattr(thing, "is_shadow_catcher", False) or getattr(thing, "is_holdout", False):
            self.problems.add(thing.name, "shadow catchers and holdouts are not supported; it is an ordinary object")
        names = ("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission", "visible_shadow")
        if not all(getattr(thing, name, True) for name in names):
            self.problems.add(thing.name, "ray visibility is not supported; it is visible to all rays")
        slots = tuple(slot.material.name_full if slot.material else "" for slot in thing.material_slots)
        # An instance shares the evaluated data of its object; what modifiers have made is one object's own.
        key = (thing.data.as_pointer() if thing.data else 0, thing.type, slots)
        if key in self._shared:
            self._shared[key][1].append(matrix)
            return
        mesh = thing.to_mesh()
        if mesh is None:
            return
        try:
            materials = {}

            def material_of(slot):
                if slot not in materials:
                    slot_count = len(thing.material_slots)
                    found = thing.material_slots[min(slot, slot_count - 1)].material if slot_count else None
                    materials[slot] = self._materials.get(found)
                return materials[slot]

            parts = self._meshes.write(mesh, thing.name, material_of)
            self._shared[key] = ([(part, material_of(part.slot)) for part in parts], [matrix])
        finally:
            thing.to_mesh_clear()

    def _shapes(self, key, parts, matrices):
        """The shapes of a mesh: with a transform each, or a group and its instances; what emits cannot be in a group."""
        still = [(part, material) for part, material in parts if not material.emits]
        bright = [(part, material) for part, material in parts if material.emits]
        self._emissive = self._emissive or bool(bright)
        result = []
        if len(matrices) > 1 and still:
            group = plugin("shape", "shapegroup")
            name = f"group-{len(self._shared)}-{list(self._shared).index(key)}"
            group.set("id", name)
            for part, material in still:
                group.append(_ply(part.file, material, None))
            result.append(group)
            for matrix in matrices:
                instance = plugin("shape", "instance")
                instance.append(reference(name))
                add(instance, "to_world", transform(matrix))
                result.append(instance)
        elif still:
            result += [_ply(part.file, material, matrices[0]) for part, material in still]
        for matrix in matrices:
            for part, material in bright:
                result.append(_light(_ply(part.file, material, matrix), material))
                if part.reversed_file:
                    # Behind what is not opaque, light goes through the copy; the surface itself scatters once.
                    back = _ply(part.reversed_file, material if material.is_opaque else None, matrix)
                    result.append(_light(back, material))
        return result


def _ply(file, material, matrix):
    shape = plugin("shape", "ply", filename=file)
    if matrix is not None:
        add(shape, "to_world", transform(matrix))
    shape.append(reference(material.bsdf) if material else plugin("bsdf", "null"))
    if material and material.medium:
        inside = reference(material.medium)
        inside.set("name", "interior")
        shape.append(inside)
    return shape


def _light(shape, material):
    shape.append(material.emitter())
    return shape


