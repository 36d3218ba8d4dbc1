"""The render engine: exports the scene into a folder of its own, runs the command there, shows what it writes."""

import os
import shutil
import tempfile
import time

import bpy
import numpy as np

from . import command, report, result
from .export.scene import Options, SceneExport


def frame_size(scene):
    """The full image in pixels, by Blender's own rounding down."""
    render = scene.render
    return tuple(max(int(n * render.resolution_percentage / 100), 1) for n in (render.resolution_x, render.resolution_y))


def border(scene):
    """The part of the image to render: (x, y, width, height), y from the bottom; None for all of it."""
    render = scene.render
    if not render.use_border:
        return None
    width, height = frame_size(scene)
    x0, x1 = (int(np.float32(v) * np.float32(width)) for v in (render.border_min_x, render.border_max_x))
    y0, y1 = (int(np.float32(v) * np.float32(height)) for v in (render.border_min_y, render.border_max_y))
    if x1 <= x0 or y1 <= y0:
        return None
    return x0, y0, x1 - x0, y1 - y0


def export_options(scene, copies=False):
    settings = scene.metrolux
    return Options(frame_size(scene), settings.filter, settings.max_depth, settings.hide_lamps, copies)


class MetroluxEngine(bpy.types.RenderEngine):
    """Metrolux: a physically based renderer for light that is hard to find"""

    bl_idname = "METROLUX"
    bl_label = "Metrolux"
    bl_use_preview = False  # ui.py says so where the preview would be
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_save_buffers = False

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        if renderlayer.use_pass_z:
            self.register_pass(scene, renderlayer, "Depth", 1, "Z", "VALUE")
        if renderlayer.use_pass_normal:
            self.register_pass(scene, renderlayer, "Normal", 3, "XYZ", "VECTOR")
        for layer, (name, channels, letters, kind) in result.OWN_PASSES.items():
            if getattr(renderlayer.metrolux, f"use_{layer}"):
                self.register_pass(scene, renderlayer, name, channels, letters, kind)

    def render(self, depsgraph):
        scene = depsgraph.scene
        folder = tempfile.mkdtemp(prefix="metrolux-")
        problems = report.Collected()
        try:
            program = command.find(report.preferred_command())
            self.update_stats("", "Exporting the scene")
            export = SceneExport(folder, depsgraph, export_options(scene))
            path = export.write()
            problems.extend(export.problems.lines())
            self._run(program, path, folder, depsgraph, problems)
        except (command.NotFound, ValueError, OSError) as problem:
            self._fail(str(problem))
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            problems.show(self, scene)

    def _fail(self, text):
        self.report({"ERROR"}, f"Metrolux: {text}")
        self.error_set(f"Metrolux: {text}")

    def _arguments(self, scene, view_layer, part):
        from .settings import arguments

        words = arguments(scene.metrolux, scene.render, scene.frame_current)
        layers = result.layers_for(view_layer)
        if layers:
            words += ["--aov", ",".join(layers)]
        if part:
            x, y, width, height = part
            words += ["--crop", f"{x},{frame_size(scene)[1] - y - height},{width},{height}"]
        return words

    def _run(self, program, path, folder, depsgraph, problems):
        scene, view_layer = depsgraph.scene, depsgraph.view_layer
        part = border(scene)
        size = part[2:] if part else frame_size(scene)
        lens = result.Lens(scene.camera.evaluated_get(depsgraph), depsgraph, frame_size(scene))
        for layer, (name, channels, letters, _) in result.OWN_PASSES.items():
            if getattr(view_layer.metrolux, f"use_{layer}"):
                self.add_pass(name, channels, letters, layer=view_layer.name)
        image = os.path.join(folder, "image.exr")
        rendering = command.Rendering(program, path, image, self._arguments(scene, view_layer, part))
        shown, ended = 0.0, None
        try:
            while rendering.is_running:
                for event in rendering.events(0.1):
                    ended = self._handle(event, problems) or ended
                if self.test_break():
                    self.update_stats("", "Stopping after this pass")
                    rendering.stop()
                    break
                if os.path.exists(image) and os.path.getmtime(image) > shown:
                    shown = os.path.getmtime(image)
                    self._show(image, size, view_layer, lens)
        finally:
            rendering.end()
        for event in rendering.events(0.1):
            ended = self._handle(event, problems) or ended
        if os.path.exists(image):
            self._show(image, size, view_layer, lens)
        elif not self.test_break():
            said = ended.get("text") if ended else rendering.last_words
            self._fail(said or f"the command ended with status {rendering.status}")

    def _handle(self, event, problems):
        """Shows an event; returns it if it is the last."""
        kind = event.get("event")
        if kind == "begin":
            self.update_stats("", f"{event.get('integrator', '')}, {event.get('threads', '?')} threads")
        elif kind == "pass":
            self._show_progress(event)
        elif kind == "log" and event.get("level") == "warning":
            problems.extend([f"metrolux: {event.get('text', '')}"])
        return event if kind in ("end", "error") else None

    def _show_progress(self, event):
        seconds, rest, error = (event.get(name) for name in ("seconds", "seconds_remaining", "relative_error"))
        text = f"Pass {event.get('passes', 0)}"
        if error is not None:
            text += f" | Error {100 * error:.2g} %"
        if rest is not None:
            text += f" | Remaining {time.strftime('%M:%S', time.gmtime(rest))}"
            self.update_progress(seconds / max(seconds + rest, 1e-6))
        self.update_stats("", text)

    def _show(self, image, size, view_layer, lens):
        render_result = self.begin_result(0, 0, *size, layer=view_layer.name)
        try:
            is_plain = not result.layers_for(view_layer)
            result.fill(render_result.layers[0], image, lens, is_plain)
        finally:
            self.end_result(render_result)
