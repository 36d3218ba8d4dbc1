#!/usr/bin/env python3
"""Measures what a viewer costs a rendering: the same passes with `render --serve` and a viewer that takes every picture, and
without, in turns. usage: tools/view_slowdown.py METROLUX SCENE PASSES PAIRS [OPTION ...]

Prints the seconds of rendering and of processor time (of the renderer alone, serving included) for each pair, and the
mean ratios with their standard errors; and the share of the processor time that the server's thread has used, which a busy
machine does not blur. Pictures are copied by the thread that renders: one percent of its time at most, by construction."""
import http.client
import json
import math
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import threading


def server_seconds(process):
    """Processor time of the thread that serves."""
    for task in pathlib.Path(f"/proc/{process.pid}/task").iterdir():
        try:
            if (task / "comm").read_text() == "metrolux-http\n":
                return int((task / "schedstat").read_text().split()[0]) / 1e9
        except OSError:
            pass  # a thread that has ended meanwhile
    return 0


def view(process, port, stop):
    """Does what the page does: waits for news, takes the picture. Returns how many, and what they cost the server."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)

    def get(path):
        connection.request("GET", path)
        return connection.getresponse().read()

    version = taken = pictures = seconds = 0
    try:
        while not stop.is_set():
            state = json.loads(get(f"/state?after={version}"))
            version = state["version"]
            frame = state["sides"][0]["frame"] if state["sides"] else None
            if frame and frame["version"] > taken:
                get("/frame?side=0")
                taken, pictures, seconds = frame["version"], pictures + 1, server_seconds(process)
    except (OSError, http.client.HTTPException):
        pass  # the rendering has ended
    return pictures, seconds


def render(words, served):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        stats = f"{folder}/stats.json"
        command = [*words, "-o", f"{folder}/image.exr", "--stats", stats, "--progress", "none"]
        process = subprocess.Popen(command + ["--serve"] * served, stderr=subprocess.PIPE, text=True)
        seen, stop = [(0, 0)], threading.Event()
        if served:
            port = int(re.search(r"http://[^:]*:(\d+)/", process.stderr.readline())[1])
            viewer = threading.Thread(target=lambda: seen.__setitem__(0, view(process, port, stop)))
            viewer.start()
        process.communicate()
        stop.set()
        if served:
            viewer.join()
        with open(stats, encoding="utf-8") as file:
            seconds = json.load(file)["seconds"]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, *seen[0]


def main():
    program, scene, passes, pairs, *options = sys.argv[1:]
    words = [program, "render", scene, "--passes", passes, *options]
    ratios = []
    for i in range(int(pairs)):
        plain = render(words, False) if i % 2 == 0 else None
        watched = render(words, True)
        plain = plain or render(words, False)
        ratios.append((watched[0] / plain[0], watched[1] / plain[1], watched[3] / watched[1]))
        print(f"plain {plain[0]:.2f} s, {plain[1]:.2f} s processor; watched {watched[0]:.2f} s, {watched[1]:.2f} s processor, "
              f"{watched[2]} pictures, {watched[3]:.3f} s of the server", flush=True)
    for name, values in zip(("rendering", "processor", "share of the server"), zip(*ratios)):
        error = statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.nan
        print(f"{name}: {statistics.mean(values):.4f} +- {error:.4f}")


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main()
