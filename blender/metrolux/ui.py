"""Panels: four settings, a fold with the rest, passes; and Blender's own panels that hold for this engine, too."""

import bpy

from . import compat
from .settings import INTEGRATORS

ENGINE = "METROLUX"
# Of Eevee's panels, these say what Metrolux reads.
_EEVEE_PANELS = ("DATA_PT_EEVEE_light", "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface",
                 "EEVEE_WORLD_PT_surface", "DATA_PT_EEVEE_light_distance")
_NOT_OURS = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_eevee"}


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


class METROLUX_PT_render(_Panel, bpy.types.Panel):
    bl_label = "Metrolux"
    bl_context = "render"

    def draw(self, context):
        settings, layout = context.scene.metrolux, self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("time", "error", "integrator", "threads"):
            layout.prop(settings, name)


class METROLUX_PT_advanced(_Panel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_context = "render"
    bl_parent_id = "METROLUX_PT_render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings, layout = context.scene.metrolux, self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("passes", "max_depth", "seed", "animate_seed", "filter", "hide_lamps", "update_every", "memory"):
            layout.prop(settings, name)
        own = INTEGRATORS[settings.integrator]["parameters"]
        if own:
            layout.separator()
            layout.label(text=f"Parameters of {settings.integrator} (empty: default)")
        for name, _, _ in own:
            layout.prop(settings.parameters, name)


class METROLUX_PT_passes(_Panel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        view_layer, layout = context.view_layer, self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(view_layer, "use_pass_z", text="Depth")
        layout.prop(view_layer, "use_pass_normal", text="Normal")
        layout.prop(view_layer.metrolux, "use_albedo")
        layout.prop(view_layer.metrolux, "use_variance")


class METROLUX_PT_no_preview(_Panel, bpy.types.Panel):
    bl_label = "Preview"
    bl_context = "material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.label(text="Metrolux has no preview of materials; the viewport shows Eevee's.", icon="INFO")


CLASSES = (METROLUX_PT_render, METROLUX_PT_advanced, METROLUX_PT_passes, METROLUX_PT_no_preview)


def _shared_panels():
    """Blender's panels for all engines of its own, and some of Eevee's."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is None or panel.__name__ in _NOT_OURS:
            continue
        if "BLENDER_RENDER" in engines or (panel.__name__ in _EEVEE_PANELS and engines.intersection(compat.EEVEE)):
            yield engines


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for engines in _shared_panels():
        engines.add(ENGINE)


def unregister():
    for engines in _shared_panels():
        engines.discard(ENGINE)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
