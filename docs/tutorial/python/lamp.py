import sys

import matplotlib
import metrolux
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot

passes = int(sys.argv[1]) if len(sys.argv) > 1 else 32
place = metrolux.Transform()


def lamp(angle):
    """A spot under the ceiling, turned by so many degrees from straight down."""
    return place.translate([0, 3, 0]).rotate([0, 0, 1], angle).rotate([1, 0, 0], 90)


scene = metrolux.load_dict({
    "type": "scene",
    "camera": {
        "type": "perspective",
        "fov": 60,
        "to_world": place.look_at(origin=[0, 2, 6], target=[0, 1.2, 0], up=[0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 64, "height": 48, "filter": {"type": "box"}},
    },
    "white": {"type": "diffuse", "reflectance": 0.6},
    "floor": {"type": "rectangle", "to_world": place.rotate([1, 0, 0], -90).scale(4), "bsdf": {"type": "ref", "id": "white"}},
    "wall": {"type": "rectangle", "to_world": place.translate([0, 2, -3]).scale(4), "bsdf": {"type": "ref", "id": "white"}},
    "ball": {"type": "sphere", "center": [1, 0.8, -0.5], "radius": 0.8, "bsdf": {"type": "ref", "id": "white"}},
    "lamp": {"type": "spot", "to_world": lamp(0), "intensity": 30, "cutoff_angle": 40, "beam_width": 15},
})  # fmt: skip


def picture(angle, seed=0):
    image = scene.with_values({"lamp.to_world": lamp(angle)}).render("path", passes=passes, seed=seed)
    return np.asarray(image, dtype=np.float64)


wanted = picture(angle=25, seed=1)  # a photograph, as it were: nobody tells us the angle

# Gauss-Newton: the derivative from two pictures with the same seed, whose noise cancels.
angle, width, angles = 0.0, 1.0, [0.0]
for step in range(8):
    here, there = picture(angle), picture(angle + width)
    slope, rest = (there - here) / width, wanted - here
    change = np.sum(slope * rest) / np.sum(slope * slope)
    angle += np.clip(change, -15, 15)
    angles.append(angle)
    print(f"step {step + 1}: {angle:.3f} degrees, squared error {np.sum(rest**2):.4g}")

figure, axes = pyplot.subplots(1, 4, figsize=(13, 2.8))
for ax, title, pixels in zip(axes, ["wanted", "start", "found"], [wanted, picture(0), picture(angle)]):
    ax.imshow(np.clip(pixels, 0, 1) ** (1 / 2.2))
    ax.set_title(title)
    ax.axis("off")
axes[3].plot(angles, marker="o")
axes[3].axhline(25, linestyle=":", color="gray")
axes[3].set_xlabel("step")
axes[3].set_ylabel("degrees")
figure.tight_layout()
figure.savefig("lamp.png", dpi=80)
