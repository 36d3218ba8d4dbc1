import sys

import metrolux
import numpy as np

seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20

# A ring of glass: angles around the ring and around its tube, then vertices, normals and triangles.
n, m = 160, 80
u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
normals = np.stack([np.cos(v) * np.cos(u), np.sin(v), np.cos(v) * np.sin(u)], axis=-1)
positions = np.stack([np.cos(u), 0 * u, np.sin(u)], axis=-1) + 0.35 * normals
index = np.arange(n * m).reshape(n, m)
a, b = index, np.roll(index, -1, axis=0)
c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in [(a, c, b), (a, d, c)]])
ring = metrolux.Mesh(positions.reshape(-1, 3), triangles, normals=normals.reshape(-1, 3))

place = metrolux.Transform()
scene = metrolux.load_dict({
    "type": "scene",
    "camera": {
        "type": "perspective",
        "fov": 40,
        "to_world": place.look_at(origin=[0, 3.6, 5.6], target=[0, 0.7, 0], up=[0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 400, "height": 300},
    },
    "floor": {
        "type": "rectangle",
        "to_world": place.rotate([1, 0, 0], -90).scale(8),
        "paint": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.68, 0.62]}},
    },
    "ring": {
        "type": "mesh",
        "arrays": ring,
        "to_world": place.translate([0, 1, 0]).rotate([0, 0, 1], 35).rotate([1, 0, 0], 20),
        "glass": {"type": "dielectric", "int_ior": 1.5},
    },
    "lamp": {
        "type": "sphere",
        "center": [3, 6, -2],
        "radius": 0.15,
        "light": {"type": "area", "radiance": {"type": "rgb", "value": [900, 820, 700]}},
    },
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.05, 0.06, 0.08]}},
})  # fmt: skip
print(scene)

image = scene.render(time=seconds, layers=["depth"], progress=lambda p: print(p, end="\r"))
print(image.shape, image.dtype, image.layers["depth"].shape, image.statistics["passes"], "passes")
metrolux.write("ring.png", image, exposure=0.3, curve="filmic")

other = scene.render("path", time=seconds)
print(metrolux.compare(other, image))

red = scene.with_values({"floor.paint.reflectance": [0.6, 0.1, 0.05], "camera.fov": 25})
red.with_film(resolution=(200, 150)).render(time=seconds / 4).save("red.png")

session = scene.session(seed=1)
for image in session:
    if session.progress.seconds > seconds / 2:
        break
session.save("ring.checkpoint")

later = scene.session(seed=1)
later.resume("ring.checkpoint")
image = later.render(time=seconds)
print(later.progress)
