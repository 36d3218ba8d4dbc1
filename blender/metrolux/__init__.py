"""Metrolux as a render engine of Blender: docs/reference/blender.md."""

bl_info = {
    "name": "Metrolux",
    "description": "Renders with the command metrolux, and exports Mitsuba scenes",
    "author": "The authors of Metrolux",
    "version": (0, 3, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Render Engine > Metrolux",
    "category": "Render",
}


def register():
    import bpy

    from . import engine, operators, settings, ui

    settings.register()
    bpy.utils.register_class(engine.MetroluxEngine)
    ui.register()
    operators.register()


def unregister():
    import bpy

    from . import engine, operators, settings, ui

    operators.unregister()
    ui.unregister()
    bpy.utils.unregister_class(engine.MetroluxEngine)
    settings.unregister()
