"""What several tests share: small scenes, the command, a temporary folder."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import metrolux

SOURCE = pathlib.Path(os.environ["METROLUX_SOURCE_DIR"])
COMMAND = os.environ["METROLUX_COMMAND"]

BALL_XML = """<scene version="3.0.0">
    <default name="width" value="24"/><default name="gray" value="0.5"/>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, 2, 6" target="0, 0.5, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="$width"/><integer name="height" value="16"/>
            <rfilter type="tent"/></film>
    </sensor>
    <bsdf type="diffuse" id="gray"><rgb name="reflectance" value="$gray, 0.4, 0.3"/></bsdf>
    <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
        <ref id="gray"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0.7" z="0"/><float name="radius" value="0.7"/>
        <bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf></shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate y="4"/></transform>
        <emitter type="area"><rgb name="radiance" value="10, 9, 8"/></emitter></shape>
    <emitter type="constant"><rgb name="radiance" value="0.1, 0.1, 0.2"/></emitter>
</scene>"""


def ball(**values):
    """The same in the form of load_dict; `values` replace or add objects."""
    transform = metrolux.Transform()
    scene = {
        "type": "scene",
        "camera": {
            "type": "perspective",
            "fov": 40,
            "to_world": transform.look_at(origin=[0, 2, 6], target=[0, 0.5, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 24, "height": 16, "filter": {"type": "tent"}},
        },
        "gray": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5, 0.4, 0.3]}},
        "floor": {
            "type": "rectangle",
            "to_world": transform.rotate([1, 0, 0], -90).scale(3),
            "bsdf": {"type": "ref", "id": "gray"},
        },
        "ball": {
            "type": "sphere",
            "center": [0, 0.7, 0],
            "radius": 0.7,
            "glass": {"type": "dielectric", "int_ior": 1.5},
        },
        "lamp": {
            "type": "rectangle",
            "to_world": transform.translate([0, 4, 0]).rotate([1, 0, 0], 90).scale(0.5),
            "light": {"type": "area", "radiance": {"type": "rgb", "value": [10, 9, 8]}},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.1, 0.1, 0.2]}},
    }
    return scene | values


class TestCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, text):
        file = self.folder / name
        file.write_text(text)
        return file

    def command(self, *words):
        """Runs the command in the folder; what it printed if it failed."""
        words = [COMMAND, *map(str, words)]
        return subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=False)

    def assertSameBits(self, a, b, message=None):
        self.assertEqual(a.shape, b.shape, message)
        self.assertTrue(numpy.array_equal(numpy.asarray(a).view(numpy.uint32), numpy.asarray(b).view(numpy.uint32)), message)
