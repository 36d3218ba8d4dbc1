"""Scenes: load_dict, meshes, transforms, changes."""

import pathlib
import unittest

import numpy
from support import BALL_XML, TestCase, ball

import metrolux

T = metrolux.Transform


def rendered(scene):
    return scene.render("mcmc_vcm", passes=2, seed=3)


class LoadDict(TestCase):
    def test_is_the_scene_of_the_file(self):
        scene = metrolux.load_dict(ball())
        file = metrolux.load(self.write("ball.xml", BALL_XML))
        self.assertEqual(scene.warnings, [])
        self.assertEqual(scene.sizes, file.sizes)
        self.assertSameBits(rendered(scene), rendered(file))

    def test_takes_what_numpy_has(self):
        values = ball(
            ball={
                "type": "sphere",
                "center": numpy.array([0, 0.7, 0], dtype=numpy.float32),
                "radius": numpy.float64(0.7),
                "flip_normals": numpy.bool_(False),
                "glass": {"type": "dielectric", "int_ior": numpy.array(1.5)},
            },
        )
        values["camera"]["film"]["width"] = numpy.int16(24)
        values["camera"]["to_world"] = values["camera"]["to_world"].matrix
        self.assertSameBits(rendered(metrolux.load_dict(values)), rendered(metrolux.load_dict(ball())))

    def test_colors_and_spectra(self):
        light = {"type": "area", "radiance": {"type": "spectrum", "value": [(400, 1), (600, 3), (700, 2)]}}
        scene = metrolux.load_dict(ball(lamp=ball()["lamp"] | {"light": light}))
        spectrum = scene.values["lamp.light.radiance"]["value"]
        self.assertEqual(spectrum.tolist(), [[400, 1], [600, 3], [700, 2]])
        for radiance in ({"type": "blackbody", "temperature": 4000}, {"type": "spectrum", "value": 2}, 3.5):
            light = {"type": "area", "radiance": radiance}
            scene = metrolux.load_dict(ball(lamp=ball()["lamp"] | {"light": light}))
            self.assertGreater(rendered(scene).mean(), 0)
            self.assertSameBits(rendered(scene.with_values(scene.values)), rendered(scene))

    def test_files_are_looked_for_in_the_folder(self):
        metrolux.write(self.folder / "a.exr", numpy.full((2, 2, 3), 0.5, numpy.float32))
        texture = {"type": "bitmap", "filename": pathlib.Path("a.exr"), "raw": True}
        textured = ball(gray={"type": "diffuse", "reflectance": texture})
        self.assertGreater(rendered(metrolux.load_dict(textured, folder=self.folder)).mean(), 0)
        with self.assertRaisesRegex(metrolux.Error, "a.exr"):
            metrolux.load_dict(textured)

    def test_arrays_are_pixels(self):
        pixels = numpy.random.default_rng(1).random((4, 6, 3), dtype=numpy.float32)
        metrolux.write(self.folder / "a.exr", pixels)

        def scene(texture, sky):
            return metrolux.load_dict(
                ball(
                    gray={"type": "diffuse", "reflectance": {"type": "bitmap"} | texture},
                    sky={"type": "envmap"} | sky,
                ),
                folder=self.folder,
            )

        made, read = scene({"data": pixels}, {"data": pixels}), scene({"filename": "a.exr"}, {"filename": "a.exr"})
        self.assertSameBits(rendered(made), rendered(read))
        self.assertSameBits(made.values["gray.reflectance.data"], pixels)
        changed = made.with_values({"gray.reflectance.data": pixels[:, ::-1]})
        self.assertFalse(numpy.array_equal(rendered(changed), rendered(made)))

    def test_errors_say_where(self):
        for text, scene in {
            "scene:ball.radus: .*did you mean \"radius\"": ball(ball={"type": "sphere", "radus": 1}),
            "scene:ball: unknown type \"spere\"": ball(ball={"type": "spere"}),
            "scene:ball: found a dictionary without a string \"type\"": ball(ball={"radius": 1}),
            "scene:ball.radius: found set, expected": ball(ball={"type": "sphere", "radius": {1}}),
            "scene:ball.radius: found NoneType": ball(ball={"type": "sphere", "radius": None}),
            r"scene:ball.center: found an array of shape \(2,\)": ball(ball={"type": "sphere", "center": [1, 2]}),
            "scene:ball: found the key 3, expected a string": ball(ball={"type": "sphere", 3: 1}),
            "did you mean \"gray\"": ball(ball={"type": "sphere", "bsdf": {"type": "ref", "id": "grey"}}),
            "expected \"scene\"": {"type": "sphere"},
            "expected a finite number": ball(ball={"type": "sphere", "radius": float("nan")}),
            "no <sensor>": {"type": "scene"},
        }.items():
            with self.assertRaisesRegex(metrolux.Error, text):
                metrolux.load_dict(scene)

    def test_a_dictionary_that_contains_itself_is_refused(self):
        scene = ball()
        scene["ball"]["glass"]["again"] = scene["ball"]
        with self.assertRaises(RecursionError):
            metrolux.load_dict(scene)
        nested = 2.0
        for _ in range(300):
            nested = {"type": "diffuse", "inner": nested}
        with self.assertRaisesRegex(metrolux.Error, "nested more than 256 levels deep"):
            metrolux.load_dict(ball(gray=nested))

    def test_warnings_go_to_logging(self):
        with self.assertLogs("metrolux", "WARNING") as logs:
            scene = metrolux.load_dict(ball(ball={"type": "sphere", "radus": 1}), lenient=True)
        self.assertEqual(len(scene.warnings), 1)
        self.assertIn("radus", logs.output[0])


class Meshes(TestCase):
    positions = numpy.array([[-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]], dtype=numpy.float64)
    triangles = numpy.array([[0, 1, 2], [0, 2, 3]])

    def test_arrays_become_shapes(self):
        mesh = metrolux.Mesh(self.positions, self.triangles)
        floor = {"type": "mesh", "arrays": mesh, "bsdf": {"type": "ref", "id": "gray"}}
        with_mesh, with_rectangle = metrolux.load_dict(ball(floor=floor)), metrolux.load_dict(ball())
        self.assertEqual(with_mesh.sizes["primitives"], with_rectangle.sizes["primitives"])
        difference = metrolux.compare(with_mesh.render("path", passes=64), with_rectangle.render("path", passes=64))
        self.assertLess(abs(difference.bias), 4 * difference.bias_error)

    def test_has_what_it_was_given(self):
        colors = numpy.eye(4, 3)
        mesh = metrolux.Mesh(
            self.positions, self.triangles.astype(numpy.uint8), normals=numpy.tile([0, 1, 0], (4, 1)),
            uvs=self.positions[:, ::2], vertex_color=colors, face_weight=[1, 2],
        )  # fmt: skip
        self.assertTrue(numpy.array_equal(mesh.positions, self.positions))
        self.assertEqual(mesh.triangles.dtype, numpy.uint32)
        self.assertFalse(mesh.positions.flags.writeable)
        self.assertEqual(repr(mesh), "<metrolux.Mesh of 4 vertices, 2 triangles>")
        texture = {"type": "mesh_attribute", "name": "vertex_color"}
        floor = {"type": "mesh", "arrays": mesh, "bsdf": {"type": "diffuse", "reflectance": texture}}
        albedo = metrolux.load_dict(ball(floor=floor)).render("path", passes=1, layers=["albedo"]).layers["albedo"]
        self.assertGreater(numpy.ptp(albedo[-1], axis=0)[:2].min(), 0.05, "from red to green")

    def test_errors_name_the_array(self):
        for text, arguments in {
            r"positions: found an array of shape \(4, 2\), expected \(vertices, 3\)": (self.positions[:, :2], self.triangles),
            "triangles: found an array of float64": (self.positions, self.triangles * 1.0),
            "triangles: found the vertex -1": (self.positions, self.triangles - 1),
            "positions: found set": ({1}, self.triangles),
        }.items():
            with self.assertRaisesRegex(metrolux.Error, text):
                metrolux.Mesh(*arguments)
        far = metrolux.Mesh(self.positions, self.triangles + 1)
        with self.assertRaisesRegex(metrolux.Error, "scene:floor: .*a face refers to vertex 4"):
            metrolux.load_dict(ball(floor={"type": "mesh", "arrays": far}))
        with self.assertRaisesRegex(metrolux.Error, "vertex_color: found an array of shape"):
            metrolux.Mesh(self.positions, self.triangles, vertex_color=numpy.zeros((4, 2)))


class Transforms(unittest.TestCase):
    def test_compose_as_matrices_do(self):
        a, b = T().translate([1, 2, 3]), T().rotate([0, 0, 1], 90)
        self.assertTrue(numpy.allclose((a @ b).matrix, a.matrix @ b.matrix))
        self.assertTrue(numpy.array_equal((a @ b).matrix, T().translate([1, 2, 3]).rotate([0, 0, 1], 90).matrix))
        self.assertTrue(numpy.allclose(b.matrix @ [1, 0, 0, 1], [0, 1, 0, 1], atol=1e-6))
        self.assertTrue(numpy.allclose(T().scale(2).inverse.matrix, numpy.diag([0.5, 0.5, 0.5, 1])))
        self.assertTrue(numpy.array_equal(T(T().scale([1, 2, 3]).matrix).matrix, numpy.diag([1, 2, 3, 1.0])))
        with self.assertRaisesRegex(metrolux.Error, r"found an array of shape \(3, 3\), expected a Transform"):
            T(numpy.eye(3))


class Changes(TestCase):
    def test_values_by_path(self):
        scene = metrolux.load_dict(ball())
        self.assertEqual(scene.values["camera.film.width"], 24)
        self.assertEqual(scene.values["ball.glass.int_ior"], 1.5)
        red = scene.with_values({"gray.reflectance": [0.6, 0.1, 0.1]})
        fresh = metrolux.load_dict(
            ball(gray={"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.1, 0.1]}})
        )
        self.assertSameBits(rendered(red), rendered(fresh))
        self.assertSameBits(rendered(scene), rendered(metrolux.load_dict(ball())), "it never changes")
        gold = scene.with_values({"gray": {"type": "conductor", "material": "Au"}})
        fresh = metrolux.load_dict(ball(gray={"type": "conductor", "material": "Au"}))
        self.assertSameBits(rendered(gold), rendered(fresh))
        with self.assertRaisesRegex(metrolux.Error, 'nothing with the name "gary"; did you mean "gray"?'):
            scene.with_values({"gary.reflectance": 1})

    def test_camera_film_and_paths_share_the_geometry(self):
        scene = metrolux.load_dict(ball())
        place = T().look_at(origin=[4, 1, 0], target=[0, 0, 0], up=[0, 1, 0])
        moved = scene.with_camera(place)
        self.assertTrue(moved.shares_geometry_with(scene))
        self.assertSameBits(rendered(moved), rendered(scene.with_values({"camera.to_world": place.matrix})))
        self.assertSameBits(rendered(moved), rendered(scene.with_camera(place.matrix)))
        small = scene.with_film(resolution=(12, 8), crop=(2, 2, 6, 4), filter="box")
        self.assertEqual((small.resolution, small.window), ((12, 8), (2, 2, 6, 4)))
        self.assertEqual(rendered(small).shape, (4, 6, 3))
        direct = scene.with_paths(max_depth=2)
        self.assertSameBits(rendered(direct), scene.render("mcmc_vcm", passes=2, seed=3, max_depth=2))
        flat = scene.with_camera({"type": "orthographic", "to_world": place})
        self.assertEqual(flat.resolution, (24, 16))
        self.assertFalse(scene.with_values({"ball.radius": 0.5}).shares_geometry_with(scene))


if __name__ == "__main__":
    unittest.main()
