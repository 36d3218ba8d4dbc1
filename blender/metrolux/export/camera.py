"""Cameras as sensors."""

import math

import numpy as np

from .. import compat
from .xml import add, plugin, transform

# Blender looks along -z with +y up; Mitsuba along +z.
_TURN = np.diag([-1.0, 1.0, -1.0, 1.0])


def _world(camera):
    matrix = np.array(camera.matrix_world.normalized())
    return matrix @ _TURN


def film(size, filter):
    element = plugin("film", "hdrfilm", width=size[0], height=size[1])
    element.append(plugin("rfilter", filter))
    return element


def sensor(camera, depsgraph, size, filter, problems):
    """The <sensor> of an evaluated camera object, for an image of `size` pixels."""
    data, thing = camera.data, f"camera {camera.name}"
    render = depsgraph.scene.render
    if abs(render.pixel_aspect_x - render.pixel_aspect_y) > 1e-6:
        problems.add(thing, "pixels that are not square are not supported; they are rendered square")
    if data.type == "PANO":
        element = _panorama(data, problems, thing)
        add(element, "to_world", transform(_world(camera)))
    else:
        # The projection has sensor fit, lens, shift and zoom in it; clip planes cancel out.
        matrix = np.array(camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1]))
        element = (_orthographic if data.type == "ORTHO" else _perspective)(camera, matrix, size, problems, thing)
        add(element, "near_clip", float(data.clip_start) if data.type == "PERSP" else float(max(data.clip_start, 0)))
    element.append(film(size, filter))
    return element


def _perspective(camera, matrix, size, problems, thing):
    data = camera.data
    values = {
        "fov": math.degrees(2 * math.atan(1 / matrix[0, 0])),
        "fov_axis": "x",
        # The lens looks at the middle of the unshifted image: normalized coordinates (-m02, -m12) from -1 to 1.
        "principal_point_offset_x": float(matrix[0, 2] / 2),
        "principal_point_offset_y": float(-matrix[1, 2] / 2),
    }
    radius = _aperture(data, problems, thing)
    if radius > 0:
        distance = _focus_distance(camera)
        element = plugin("sensor", "thinlens", aperture_radius=radius, focus_distance=distance, **values)
    else:
        element = plugin("sensor", "perspective", **values)
    add(element, "to_world", transform(_world(camera)))
    return element


def _aperture(data, problems, thing):
    """The radius of the lens in scene units: half the focal length over the f-number, as in Cycles."""
    dof = data.dof
    if not dof.use_dof:
        return 0.0
    if dof.aperture_blades >= 3:
        problems.add(thing, "blades of an aperture are not supported; it is round")
    if abs(dof.aperture_ratio - 1) > 1e-6:
        problems.add(thing, "the ratio of an aperture is not supported; it is round")
    return float(data.lens * 1e-3 / (2 * max(dof.aperture_fstop, 1e-5)))


def _focus_distance(camera):
    dof = camera.data.dof
    if dof.focus_object is None:
        return float(max(dof.focus_distance, 1e-5))
    matrix = np.array(camera.matrix_world.normalized())
    target = np.array(dof.focus_object.matrix_world)[:3, 3]
    return float(max(abs(np.dot(target - matrix[:3, 3], matrix[:3, 2])), 1e-5))


def _orthographic(camera, matrix, size, problems, thing):
    if camera.data.dof.use_dof:
        problems.add(thing, "depth of field of an orthographic camera is not supported; all is in focus")
    # x and y go from -1 to 1 over the film: the width of the view scales both, and the shift moves the camera.
    half = 1 / matrix[0, 0]
    shift = np.eye(4)
    shift[0, 3] = matrix[0, 3] * half
    shift[1, 3] = -matrix[1, 3] / matrix[1, 1]
    element = plugin("sensor", "orthographic")
    add(element, "to_world", transform(_world(camera) @ shift @ np.diag([half, half, 1, 1])))
    return element


def _panorama(data, problems, thing):
    kind = compat.cycles_setting(data, "panorama_type", "EQUIRECTANGULAR")
    if kind == "FISHEYE_EQUIDISTANT":
        angle = compat.cycles_setting(data, "fisheye_fov", math.pi)
        return plugin("sensor", "fisheye", fov=math.degrees(angle))
    if kind != "EQUIRECTANGULAR":
        problems.add(thing, f"the panorama {kind} is not supported; EQUIRECTANGULAR is taken")
    return plugin("sensor", "spherical")
