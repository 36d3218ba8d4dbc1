import sys

import matplotlib
import metrolux
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot

scene_file, reference_file = sys.argv[1:3]
seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 15

scene = metrolux.load(scene_file)
reference = metrolux.read(reference_file)


def errors_over_time(integrator):
    """Seconds and errors after each pass, and the last image."""
    seconds_and_errors = []
    session = scene.session(integrator, time=seconds)
    for image in session:
        error = metrolux.compare(image, reference).trimmed_rel_mse
        seconds_and_errors.append((session.progress.seconds, error))
    return np.array(seconds_and_errors), image.copy()


figure, (curves, *maps) = pyplot.subplots(1, 4, figsize=(13, 3.2), width_ratios=[1.3, 1, 1, 1])
for integrator, axes in zip(["path", "vcm", "mcmc_vcm"], maps):
    steps, image = errors_over_time(integrator)
    curves.loglog(*steps.T, label=integrator)
    axes.imshow(metrolux.compare(image, reference).heat_map)
    axes.set_title(f"{integrator}, {len(steps)} passes")
    axes.axis("off")
    print(f"{integrator}: {len(steps)} passes, trimmed relMSE {steps[-1, 1]:.4g}")
curves.set_xlabel("seconds")
curves.set_ylabel("trimmed relMSE")
curves.legend()
figure.tight_layout()
figure.savefig("curves.png", dpi=80)
