"""File > Export > Mitsuba scene (Metrolux)."""

import os

import bpy
from bpy_extras.io_utils import ExportHelper

from . import engine, report
from .export.scene import SceneExport


class METROLUX_OT_export(bpy.types.Operator, ExportHelper):
    """Writes the scene as Mitsuba 3's XML, with meshes and pictures beside it"""

    bl_idname = "export_scene.metrolux"
    bl_label = "Export Mitsuba scene"
    filename_ext = ".xml"
    filter_glob: bpy.props.StringProperty(default="*.xml", options={"HIDDEN"})

    def execute(self, context):
        folder, file = os.path.split(self.filepath)
        depsgraph = context.evaluated_depsgraph_get()
        try:
            export = SceneExport(folder, depsgraph, engine.export_options(context.scene, copies=True))
            export.write(file)
        except (ValueError, OSError) as problem:
            self.report({"ERROR"}, f"Metrolux: {problem}")
            return {"CANCELLED"}
        problems = report.Collected()
        problems.extend(export.problems.lines())
        problems.show(self, context.scene)
        return {"FINISHED"}


def _menu(self, context):
    self.layout.operator(METROLUX_OT_export.bl_idname, text="Mitsuba scene (Metrolux) (.xml)")


def register():
    bpy.utils.register_class(METROLUX_OT_export)
    bpy.types.TOPBAR_MT_file_export.append(_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_menu)
    bpy.utils.unregister_class(METROLUX_OT_export)
