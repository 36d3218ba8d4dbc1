"""Lights, with the radiometry of Cycles (P is the power in Blender's watts, c the light's color):

- Point, Spot: intensity P c / (4 pi); with a radius r, a sphere of radiance P c / (4 pi^2 r^2).
- Area of area A: radiance P c / (pi A) on one side, before Blender 4.0 P c / (4 A).
- Sun: irradiance P c on a surface that faces it; with an angle, a disk in the sky (world.py).
"""

import math
import os

import numpy as np

from .. import compat
from .graph import input_of, output_node
from .textures import TextureReader
from .values import WHITE
from .xml import add, plugin, rgb, transform, vector

LIGHTS = {
    "POINT": ("Point", "`point`; with a radius a `sphere` that emits"),
    "SPOT": ("Spot", "`goniometric` with Cycles' falloff; its radius is left out (named)"),
    "SUN": ("Sun", "`directional`; with an angle a disk in the `envmap`"),
    "AREA": ("Area", "`rectangle` or `disk` that emits; a spread below 180° is left out (named)"),
}
_TURN = np.diag([-1.0, 1.0, -1.0, 1.0])  # Blender's lights shine along -z, Mitsuba's along +z


def strength(light, problems, thing):
    """Color times power, with what an Emission node in the light's tree says."""
    color = np.array(light.color[:]) * light.energy
    if not light.use_nodes or light.node_tree is None:
        return color
    reader = TextureReader(problems, thing)
    output = output_node(light.node_tree, "ShaderNodeOutputLight")
    surface = output and input_of(output, (), "Surface")
    if not surface or surface.node is None:
        return color * 0
    if surface.node.bl_idname != "ShaderNodeEmission":
        reader.problem(f"the node {surface.node.bl_label} of a light is not supported; it is left out")
        return color
    emission = [reader.input(surface.node, surface.groups, name) for name in ("Color", "Strength")]
    for value in emission:
        if not value.is_constant:
            reader.problem("a texture of a light is not supported; white is taken")
    tint, factor = (value if value.is_constant else WHITE for value in emission)
    return color * np.array(tint.color) * factor.scalar


def is_sun_disk(light):
    """Whether a sun is drawn into the sky: smaller ones are as good as a direction."""
    return light.type == "SUN" and light.angle > math.radians(0.05)


class Lights:
    """Exports lights into `elements`; `shapes` are those that a camera could see."""

    def __init__(self, folder, problems):
        self._folder, self._problems, self._count = folder, problems, 0
        self.elements, self.shapes = [], []

    def add(self, light, name, matrix):
        thing = f"light {name}"
        power = strength(light, self._problems, thing)
        if not np.any(power > 0):
            return
        if np.any(power < 0):
            self._problems.add(thing, "light that is taken away is not supported; negative channels are 0")
            power = np.maximum(power, 0)
        if not getattr(light, "use_shadow", True) or not compat.cycles_setting(light, "cast_shadow", True):
            self._problems.add(thing, "lights without shadows are not supported; it casts them")
        if not compat.light_is_normalized(light):
            self._problems.add(thing, "a power that is not normalized is read as if it were")
        {"POINT": self._point, "SPOT": self._spot, "SUN": self._sun, "AREA": self._area}[light.type](
            light, thing, np.array(matrix), power
        )

    def _shape(self, thing, element, radiance, position):
        element.append(plugin("bsdf", "null"))  # light goes through the lamps of Cycles
        element.append(plugin("emitter", "area", radiance=rgb(radiance)))
        self.elements.append(element)
        self.shapes.append((thing, position))

    def _point(self, light, thing, matrix, power):
        position, radius = matrix[:3, 3], light.shadow_soft_size
        if radius <= 0:
            emitter = plugin("emitter", "point", intensity=rgb(power / (4 * math.pi)))
            add(emitter, "position", vector("point", position))
            self.elements.append(emitter)
            return
        shape = plugin("shape", "sphere", radius=float(radius))
        add(shape, "center", vector("point", position))
        self._shape(thing, shape, power / (4 * math.pi**2 * radius**2), position)

    def _spot(self, light, thing, matrix, power):
        if light.shadow_soft_size > 0:
            self._problems.add(thing, "the radius of a Spot is not supported; its shadows are sharp")
        axes = np.linalg.norm(matrix[:3, :3], axis=0)
        if np.ptp(axes) > 1e-4 * axes.max():
            self._problems.add(thing, "a Spot with an uneven scale is read as round")
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = matrix[:3, :3] / axes, matrix[:3, 3]
        to_world = transform(frame @ _TURN)
        file = f"spot-{self._count}.ies"
        self._count += 1
        write_spot(os.path.join(self._folder, file), light.spot_size / 2, light.spot_blend)
        emitter = plugin("emitter", "goniometric", filename=file, intensity=rgb(power / (4 * math.pi)))
        add(emitter, "to_world", to_world)
        self.elements.append(emitter)

    def _sun(self, light, thing, matrix, power):
        direction = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        emitter = plugin("emitter", "directional", irradiance=rgb(power))
        add(emitter, "direction", vector("vector", direction))
        self.elements.append(emitter)

    def _area(self, light, thing, matrix, power):
        if compat.cycles_setting(light, "is_portal", False):
            return  # a portal only guides Cycles
        if compat.light_spread(light) < math.pi - 1e-3:
            self._problems.add(thing, "a spread below 180 degrees is not supported; it shines to all of its side")
        width = light.size
        height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else width
        is_round = light.shape in ("DISK", "ELLIPSE")
        sizes = np.linalg.norm(matrix[:3, :2], axis=0) * np.array([width, height])
        area = sizes[0] * sizes[1] * (math.pi / 4 if is_round else 1)
        if area <= 0:
            return
        shape = plugin("shape", "disk" if is_round else "rectangle")
        frame = np.eye(4)
        for axis in range(3):
            frame[:3, axis] = matrix[:3, axis] / np.linalg.norm(matrix[:3, axis])
        # Cycles shines along -z whatever the scale is.
        to_world = matrix.copy()
        to_world[:3, 2] = frame[:3, 2]
        add(shape, "to_world", transform(to_world @ _TURN @ np.diag([width / 2, height / 2, 1, 1])))
        self._shape(thing, shape, compat.area_radiance(power, area), matrix[:3, 3])


def write_spot(path, half_angle, blend):
    """An IES file of type C with the falloff of a spot; the middle has one candela."""
    degrees = math.degrees(half_angle)
    angles = np.unique(np.round(np.concatenate([np.linspace(0, degrees, 1025), [degrees + 1e-3, 180]]), 6))
    candelas = compat.spot_falloff(np.cos(np.radians(angles)), half_angle, blend)
    text = ["IESNA:LM-63-1995", "TILT=NONE", f"1 -1 1 {len(angles)} 1 1 2 0 0 0", "1 1 0"]
    text += [" ".join(f"{a:.6f}" for a in angles), "0", " ".join(f"{c:.7g}" for c in candelas)]
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(text) + "\n")
