"""Volume shaders as homogeneous media. What each becomes stands in the table that docs/reference/blender.md shows."""

from dataclasses import dataclass, field

import numpy as np

from .graph import Input, input_of
from .textures import TextureReader
from .values import MeshColor
from .xml import plugin, rgb, scalar

VOLUMES = {}  # bl_idname: (name in Blender, what becomes of it, function)
_MOST_NODES = 64


def volume(kind, name, becomes):
    def register(function):
        VOLUMES[kind] = (name, becomes, function)
        return function

    return register


@dataclass
class Volume:
    """Coefficients per unit of length, and the mean cosine of each part that scatters with the weight of that part."""

    absorption: np.ndarray = field(default_factory=lambda: np.zeros(3))
    scattering: np.ndarray = field(default_factory=lambda: np.zeros(3))
    cosines: list = field(default_factory=list)  # (weight, g)

    def plus(self, other, share=1.0, other_share=1.0):
        return Volume(
            share * self.absorption + other_share * other.absorption,
            share * self.scattering + other_share * other.scattering,
            [(share * w, g) for w, g in self.cosines] + [(other_share * w, g) for w, g in other.cosines],
        )

    @property
    def extinction(self):
        return self.absorption + self.scattering


class VolumeReader(TextureReader):
    """Media of volume sockets; only what is the same everywhere can be one."""

    depth = 0

    def volume(self, socket):
        if socket is None or socket.node is None:
            return Volume()
        node = socket.node
        if node.bl_idname not in VOLUMES:
            self.problem(f"the volume {node.bl_label} is not supported; it is left out")
            return Volume()
        self.depth += 1
        try:
            if self.depth > _MOST_NODES:
                self.problem("volumes are nested too deeply; what is deeper is left out")
                return Volume()
            return VOLUMES[node.bl_idname][2](self, node, socket.groups)
        finally:
            self.depth -= 1

    def even(self, node, groups, name, default):
        """The three channels of an input; a texture is named, and its mean taken."""
        socket = input_of(node, groups, name)
        if socket is None:
            return np.full(3, float(default))
        value = self.color(socket)
        if not value.is_constant:
            self.problem(f"{name} of {node.bl_label} cannot have a texture; one value is taken")
            known = not isinstance(value, MeshColor)
            return np.asarray(value.array(), float).reshape(-1, 3).mean(axis=0) if known else np.full(3, 0.5)
        return np.array(value.color[:3], float)

    def density(self, node, groups):
        return max(float(self.even(node, groups, "Density", 1).mean()), 0.0)

    def scattered(self, node, groups, color, density):
        g = float(np.clip(self.even(node, groups, "Anisotropy", 0).mean(), -0.99, 0.99))
        scattering = density * np.maximum(color, 0)
        return Volume(scattering=scattering, cosines=[(float(scattering.mean()), g)])


@volume("ShaderNodeVolumeAbsorption", "Volume Absorption", "`homogeneous` that absorbs: density times (1 - color)")
def _absorption(reader, node, groups):
    color = reader.even(node, groups, "Color", 0.8)
    return Volume(absorption=reader.density(node, groups) * np.maximum(1 - color, 0))


@volume("ShaderNodeVolumeScatter", "Volume Scatter", "`homogeneous` that scatters: density times color; `hg`")
def _scatter(reader, node, groups):
    phase = getattr(node, "phase", "HENYEY_GREENSTEIN")
    if phase != "HENYEY_GREENSTEIN":
        reader.problem(f"the phase function {phase} is read as HENYEY_GREENSTEIN")
    return reader.scattered(node, groups, reader.even(node, groups, "Color", 0.8), reader.density(node, groups))


@volume("ShaderNodeVolumePrincipled", "Principled Volume",
        "`homogeneous` of density, color, absorption color and anisotropy; no emission, no attributes")
def _principled(reader, node, groups):
    color, density = reader.even(node, groups, "Color", 0.5), reader.density(node, groups)
    absorption = np.sqrt(np.maximum(reader.even(node, groups, "Absorption Color", 0), 0))
    for name in ("Emission Strength", "Blackbody Intensity"):
        if reader.even(node, groups, name, 0).mean() > 0:
            reader.problem(f"{name} of {node.bl_label}: volumes that emit are not supported; it only scatters and absorbs")
    result = reader.scattered(node, groups, color, density)
    result.absorption = density * np.maximum(1 - color, 0) * np.maximum(1 - absorption, 0)
    return result


@volume("ShaderNodeAddShader", "Add Shader", "the sum of both")
def _add(reader, node, groups):
    first, second = (reader.volume(Input(node.inputs[i], groups)) for i in (0, 1))
    return first.plus(second)


@volume("ShaderNodeMixShader", "Mix Shader", "the mean of both, by a factor that is constant")
def _mix(reader, node, groups):
    factor = float(np.clip(reader.even(node, groups, "Fac", 0.5).mean(), 0, 1))
    first, second = (reader.volume(Input(node.inputs[i], groups)) for i in (1, 2))
    return first.plus(second, 1 - factor, factor)


def medium(reader, socket):
    """The <medium> of a volume socket; None where nothing is in it."""
    found = reader.volume(socket)
    extinction = found.extinction
    if not np.any(extinction > 0):
        return None
    albedo = np.divide(found.scattering, extinction, out=np.zeros(3), where=extinction > 0)
    element = plugin("medium", "homogeneous", sigma_t=rgb(extinction), albedo=rgb(np.clip(albedo, 0, 1)))
    if found.cosines:
        weights = np.array([w for w, _ in found.cosines])
        cosines = np.array([g for _, g in found.cosines])
        g = float((weights * cosines).sum() / weights.sum()) if weights.sum() > 0 else 0.0
        if np.ptp(cosines) > 1e-6:
            reader.problem("volumes with different anisotropies are added; their mean is taken")
        element.append(plugin("phase", "hg", g=scalar(g)) if g else plugin("phase", "isotropic"))
    return element
