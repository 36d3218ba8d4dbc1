"""Settings of a scene, of a view layer and of the add-on; the integrators' parameters come from parameters.json."""

import json
import os

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

with open(os.path.join(os.path.dirname(__file__), "parameters.json"), encoding="utf-8") as _file:
    INTEGRATORS = json.load(_file)["integrators"]


def parameters():
    """The parameters of all integrators: {name: [(integrator, default, expected), ...]}."""
    result = {}
    for integrator, data in INTEGRATORS.items():
        for name, default, expected in data["parameters"]:
            result.setdefault(name, []).append((integrator, default, expected))
    return result


def _parameter_property(name, uses):
    label = name.replace("_", " ").capitalize()
    defaults = "; ".join(f"{integrator}: {default}" for integrator, default, _ in uses)
    return StringProperty(name=label, description=f"{uses[0][2].capitalize()}. Empty for the default ({defaults})")


class MetroluxParameters(bpy.types.PropertyGroup):
    """Parameters of integrators as text; empty is the default"""

    __annotations__ = {name: _parameter_property(name, uses) for name, uses in parameters().items()}


class MetroluxSettings(bpy.types.PropertyGroup):
    """How a scene is rendered"""

    time: FloatProperty(name="Time", description="Seconds to render each frame for; 0: no limit of time", default=60,
                        min=0, soft_max=36000, unit="TIME_ABSOLUTE", subtype="TIME_ABSOLUTE")
    error: FloatProperty(name="Error", description="Stop at this estimated relative error in percent; 0: no such limit",
                         default=0, min=0, max=100, precision=2, subtype="PERCENTAGE")
    integrator: EnumProperty(
        name="Integrator", description="The algorithm",
        items=[(name, name, data["text"], index) for index, (name, data) in enumerate(INTEGRATORS.items())])
    threads: IntProperty(name="Threads", description="Number of threads; 0: one for each core", default=0, min=0, max=1024)
    passes: IntProperty(name="Passes", description="Number of passes; 0: no such limit", default=0, min=0, max=16777215)
    max_depth: IntProperty(name="Path edges", description="Largest number of edges of a path: 1 shows lamps, 2 adds direct light; "
                           "-1: no limit", default=-1, min=-1, max=1000)
    seed: IntProperty(name="Seed", description="Seed of all random numbers", default=0, min=0)
    animate_seed: BoolProperty(name="Another seed each frame", description="Noise that does not stand still", default=True)
    filter: EnumProperty(name="Pixel filter", description="Reconstruction filter",
                         items=[(name, name.capitalize(), "") for name in
                                ("gaussian", "box", "tent", "mitchell", "catmullrom", "lanczos")])
    update_every: FloatProperty(name="Update every", description="Seconds between updates of the picture", default=2, min=1,
                                soft_max=60, unit="TIME_ABSOLUTE", subtype="TIME_ABSOLUTE")
    memory: StringProperty(name="Memory", description="What an iteration may store: 4G, 512M; empty: the default")
    hide_lamps: BoolProperty(name="Hide lamps", description="Lamps are invisible to the camera, as in Cycles, where no mesh emits "
                             "and no sky is seen", default=True)
    show_advanced: BoolProperty(name="Advanced", default=False)
    parameters: PointerProperty(type=MetroluxParameters)


class MetroluxViewLayer(bpy.types.PropertyGroup):
    """Passes that other engines do not have"""

    use_albedo: BoolProperty(name="Albedo", description="The color of surfaces, for denoisers")
    use_variance: BoolProperty(name="Variance", description="Estimated variance of the pixel's luminance")


class MetroluxPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    command: StringProperty(name="Command", description="Path of the command metrolux; empty: the search path",
                            subtype="FILE_PATH")

    def draw(self, context):
        self.layout.prop(self, "command")


def arguments(settings, render, frame):
    """The command's options for settings: limits, integrator and its parameters, machine."""
    words = ["-i", settings.integrator, "--save-every", f"{settings.update_every:g}s"]
    if settings.time > 0:
        words += ["--time", f"{settings.time:g}s"]
    if settings.error > 0:
        words += ["--error", f"{settings.error:g}%"]
    if settings.passes > 0:
        words += ["--passes", str(settings.passes)]
    threads = settings.threads or (render.threads if render.threads_mode == "FIXED" else 0)
    if threads:
        words += ["--threads", str(threads)]
    words += ["--seed", str(settings.seed + (frame if settings.animate_seed else 0))]
    if settings.memory:
        words += ["--memory", settings.memory]
    for name, default, _ in INTEGRATORS[settings.integrator]["parameters"]:
        value = getattr(settings.parameters, name).strip()
        if value:
            words += _option(name, value, default)
    return words


def _option(name, value, default):
    option = name.replace("_", "-")
    if default in ("true", "false"):
        wanted = value.lower() in ("true", "1", "yes", "on")
        if wanted == (default == "true"):
            return []
        return [f"--{option}" if wanted else f"--no-{option}"]
    return [f"--{option}", value]


CLASSES = (MetroluxParameters, MetroluxSettings, MetroluxViewLayer, MetroluxPreferences)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.metrolux = PointerProperty(type=MetroluxSettings)
    bpy.types.ViewLayer.metrolux = PointerProperty(type=MetroluxViewLayer)


def unregister():
    del bpy.types.ViewLayer.metrolux
    del bpy.types.Scene.metrolux
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
