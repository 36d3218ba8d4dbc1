"""What could not be rendered as it is, in one list: a text of the document, and a warning after the render."""

import bpy

from . import compat

TEXT = "Metrolux report"


def preferred_command():
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences.command if addon and addon.preferences else ""


class Collected:
    """Messages of one render."""

    def __init__(self):
        self.lines = []

    def extend(self, lines):
        self.lines += [line for line in lines if line not in self.lines]

    def show(self, reporter, scene):
        """Writes the text (an empty list empties that of the render before) and reports how long the list is."""
        lines, frame, name = list(self.lines), scene.frame_current, scene.name
        compat.later(lambda: write_text(lines, name, frame))
        if not lines:
            return
        first = lines[0] if len(lines) == 1 else f"{lines[0]} (and {len(lines) - 1} more)"
        reporter.report({"WARNING"}, f"Metrolux: {first}; see the text {TEXT!r}")
        for line in lines:
            print(f"Metrolux: {line}")


def write_text(lines, scene, frame):
    text = bpy.data.texts.get(TEXT)
    if text is None:
        if not lines:
            return
        text = bpy.data.texts.new(TEXT)
    text.clear()
    text.write(f"Scene {scene}, frame {frame}\n\n")
    text.write("\n".join(f"- {line}" for line in lines) + "\n" if lines else "Everything was rendered as it is.\n")
