"""Materials: each once, as a <bsdf> with an id and what a shape needs besides."""

from dataclasses import dataclass

from .graph import input_of, output_node
from .shaders import ShaderReader
from .surface import Surface, bsdf_of, diffuse
from .values import BLACK, WHITE, constant
from .volumes import VolumeReader, medium
from .writer import ValueWriter
from .xml import plugin


@dataclass
class Material:
    bsdf: str  # the id
    emission: object  # a Value, BLACK without
    uv_map: object  # name, "" for the active one, None if none is needed
    mesh_color: object  # name or None
    writer: object
    is_opaque: bool
    medium: object = None  # the id of what is inside

    @property
    def emits(self):
        return self.emission != BLACK

    def emitter(self):
        return plugin("emitter", "area", radiance=self.writer.radiance(self.emission))


class Materials:
    """Exports materials on demand; `elements` has their BSDFs."""

    def __init__(self, files, problems):
        self._files, self._problems, self._known = files, problems, {}
        self.elements = []

    def get(self, material):
        key = material.name_full if material else None
        if key not in self._known:
            self._known[key] = self._export(material)
        return self._known[key]

    def _export(self, material):
        thing = f"material {material.name}" if material else "objects without a material"

        def problem(message):
            self._problems.add(thing, message)

        writer = ValueWriter(self._files, problem)
        surface = diffuse(constant(0.8)) if material is None else self._surface(material, thing)
        bsdf = bsdf_of(surface, writer, problem)
        name = f"material-{len(self._known)}"
        bsdf.set("id", name)
        if surface.emission != BLACK:
            writer.radiance(surface.emission)  # notes the UV map that it needs
        self.elements.append(bsdf)
        inside = self._medium(material, thing, f"medium-{len(self._known)}")
        return Material(name, surface.emission, writer.uv_map, writer.mesh_color, writer, surface.is_opaque, inside)

    def _medium(self, material, thing, name):
        """The id of the medium of a material's volume, which is exported; None without one."""
        if material is None or not material.use_nodes or material.node_tree is None:
            return None
        output = output_node(material.node_tree, "ShaderNodeOutputMaterial")
        element = medium(VolumeReader(self._problems, thing), input_of(output, (), "Volume")) if output else None
        if element is None:
            return None
        element.set("id", name)
        self.elements.append(element)
        return name

    def _surface(self, material, thing):
        reader = ShaderReader(self._problems, thing)
        if not material.use_nodes or material.node_tree is None:
            return diffuse(constant(material.diffuse_color))
        output = output_node(material.node_tree, "ShaderNodeOutputMaterial")
        if output is None:
            reader.problem("it has no output node; it is black")
            return Surface()
        volume = input_of(output, (), "Volume")
        displacement = input_of(output, (), "Displacement")
        if displacement is not None and displacement.node is not None:
            reader.problem("displacement is not supported; it is left out")
        surface = input_of(output, (), "Surface")
        if surface.node is None and volume is not None and volume.node is not None:
            return Surface(transparency=WHITE)
        return reader.surface(surface)
