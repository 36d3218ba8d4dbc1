#!/usr/bin/env python3
"""Compares two builds of the command: do they make the same images, and how fast is one beside the other?

    tools/compare_builds.py bits  BASE NEW [-i a,b] [--passes N] [--resolution WxH] [SCENE ...]
    tools/compare_builds.py speed BASE NEW [-i a,b] [--passes N] [--resolution WxH] [--pairs N] [SCENE ...]

BASE and NEW are paths of `metrolux`. Without SCENE: six scenes of this repository; without -i: all integrators of
NEW for `bits`, the four that people compare for `speed`.

bits   renders with both and compares every pixel; exits with 1 when one differs.
speed  renders in turn (the order changes from pair to pair) on one thread and prints the median over the pairs of
       the ratio NEW / BASE of user processor seconds, with the smallest and the largest: ratios of one run side by
       side hold on a noisy machine, absolute times do not.
"""
import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENES = ["door-ajar", "environment", "glossy-room", "spot-directional", "textured", "vitrine"]
SPEED_INTEGRATORS = ["path", "bdpt", "vcm", "mcmc_vcm"]


def integrators_of(program):
    text = subprocess.run([program, "integrators"], check=True, capture_output=True, text=True).stdout
    return [line.split()[0] for line in text.splitlines() if line and not line[0].isspace()]


def render(program, scene, integrator, arguments, output):
    """User processor seconds of one rendering."""
    command = [program, "render", scene, "-i", integrator, "--passes", str(arguments.passes),
               "--resolution", arguments.resolution, "--save-every", "0", "--quiet", "-o", output]
    if arguments.threads:
        command += ["--threads", str(arguments.threads)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(command, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def difference(program, a, b):
    """The worst that two images have of each other; None when all pixels are the same."""
    text = subprocess.run([program, "compare", a, b, "--json"], check=True, capture_output=True, text=True).stdout
    result = json.loads(text)
    if result["mse"] == 0 and result["non_finite_pixels"] == 0:
        return None
    return f"relMSE {result['rel_mse']}, bias {result['bias']}"


def bits(arguments, folder):
    different = 0
    compared = 0
    for scene in arguments.scenes:
        for integrator in arguments.integrators:
            files = [os.path.join(folder, name) for name in ("base.exr", "new.exr")]
            for program, file in zip((arguments.base, arguments.new), files):
                render(program, scene, integrator, arguments, file)
            found = difference(arguments.new, *files)
            compared += 1
            different += found is not None
            if found:
                print(f"DIFFERENT {label(scene)} {integrator}: {found}", flush=True)
    print(f"{compared} images compared, {different} differ")
    return different > 0


def speed(arguments, folder):
    output = os.path.join(folder, "speed.exr")
    print(f"user seconds NEW / BASE, medians of {arguments.pairs} pairs, {arguments.passes} passes of "
          f"{arguments.resolution}, one thread")
    for scene in arguments.scenes:
        for integrator in arguments.integrators:
            ratios = []
            for pair in range(arguments.pairs):
                seconds = {}
                order = (arguments.base, arguments.new) if pair % 2 == 0 else (arguments.new, arguments.base)
                for program in order:
                    seconds[program] = render(program, scene, integrator, arguments, output)
                ratios.append(seconds[arguments.new] / seconds[arguments.base])
            print(f"{label(scene):18} {integrator:10} {statistics.median(ratios):.3f}  "
                  f"({min(ratios):.3f} to {max(ratios):.3f})", flush=True)
    return False


def label(scene):
    return os.path.basename(os.path.dirname(os.path.abspath(scene)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["bits", "speed"])
    parser.add_argument("base")
    parser.add_argument("new")
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("-i", "--integrators", type=lambda text: text.split(","))
    parser.add_argument("--passes", type=int, default=3)
    parser.add_argument("--resolution", default="64x48")
    parser.add_argument("--pairs", type=int, default=5)
    arguments = parser.parse_args()
    arguments.base, arguments.new = os.path.abspath(arguments.base), os.path.abspath(arguments.new)
    arguments.scenes = arguments.scenes or [f"{ROOT}/scenes/{name}/scene.xml" for name in SCENES]
    arguments.threads = 1 if arguments.what == "speed" else 0
    if not arguments.integrators:
        arguments.integrators = integrators_of(arguments.new) if arguments.what == "bits" else SPEED_INTEGRATORS
    with tempfile.TemporaryDirectory() as folder:
        return (bits if arguments.what == "bits" else speed)(arguments, folder)


if __name__ == "__main__":
    sys.exit(main())
