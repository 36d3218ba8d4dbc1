#!/usr/bin/env python3
"""Measures what a viewer costs a rendering: the same passes with `render --serve` and a viewer that takes every picture, and
without, in turns. usage: tools/view_slowdown.py METROLUX SCENE PASSES PAIRS [OPTION ...]

Prints the seconds of rendering and of processor time (of the renderer alone, serving included) for each pair, and the
mean ratios with their standard errors. Only the processor time means something on a machine that others use, too."""
import http.client
import json
import math
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import threading


def view(port, stop):
    """Does what the page does: waits for news, takes the picture."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)

    def get(path):
        connection.request("GET", path)
        return connection.getresponse().read()

    version = taken = pictures = 0
    try:
        while not stop.is_set():
            state = json.loads(get(f"/state?after={version}"))
            version = state["version"]
            frame = state["sides"][0]["frame"] if state["sides"] else None
            if frame and frame["version"] > taken:
                get("/frame?side=0")
                taken, pictures = frame["version"], pictures + 1
    except (OSError, http.client.HTTPException):
        pass  # the rendering has ended
    return pictures


def render(words, served):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        stats = f"{folder}/stats.json"
        command = [*words, "-o", f"{folder}/image.exr", "--stats", stats, "--progress", "none"]
        process = subprocess.Popen(command + ["--serve"] * served, stderr=subprocess.PIPE, text=True)
        pictures, stop = [0], threading.Event()
        if served:
            port = int(re.search(r"http://[^:]*:(\d+)/", process.stderr.readline())[1])
            viewer = threading.Thread(target=lambda: pictures.__setitem__(0, view(port, stop)))
            viewer.start()
        process.communicate()
        stop.set()
        if served:
            viewer.join()
        with open(stats, encoding="utf-8") as file:
            seconds = json.load(file)["seconds"]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, pictures[0]


def main():
    program, scene, passes, pairs, *options = sys.argv[1:]
    words = [program, "render", scene, "--passes", passes, *options]
    ratios = []
    for i in range(int(pairs)):
        plain = render(words, False) if i % 2 == 0 else None
        watched = render(words, True)
        plain = plain or render(words, False)
        ratios.append((watched[0] / plain[0], watched[1] / plain[1]))
        print(f"plain {plain[0]:.2f} s, {plain[1]:.2f} s processor; watched {watched[0]:.2f} s, {watched[1]:.2f} s processor, "
              f"{watched[2]} pictures", flush=True)
    for name, values in zip(("rendering", "processor"), zip(*ratios)):
        error = statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.nan
        print(f"{name}: x {statistics.mean(values):.4f} +- {error:.4f}")


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main()
