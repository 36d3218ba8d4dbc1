#!/usr/bin/env python3
"""Tries `metrolux info` on all scenes of some folders and sums up what loads, what is warned of, and what is refused
and why. Needs nothing but Python 3.

Usage: tools/scene_census.py [--metrolux FILE] [--lenient | --strict] [--timeout SECONDS] [--all] FOLDER...

An XML file counts as a scene when its root element is <scene>, a .pbrt file when it has a WorldBegin, and each .gltf and
.glb file does. Of messages only the cause counts: places, ids and file
names are left out. --all lists each file with its outcome. The exit status is 1 when something crashed or took too long.
"""

import argparse
import collections
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def scene_version(file):
    """The version that the root element names, "none" without one; None if the root is no <scene>."""
    head = file.read_bytes()[:65536].decode("utf-8", "replace")
    head = re.sub(r"<!--.*?-->|<\?.*?\?>|<!DOCTYPE.*?>", "", head, flags=re.DOTALL)
    root = re.match(r"\s*\ufeff?\s*<scene\b([^>]*)>", head)
    if not root:
        return None
    version = re.search(r"""version\s*=\s*["']\s*([^"']*)""", root.group(1))
    return version.group(1) if version else "none"


def kind_of(file):
    """The version of a scene of Mitsuba's, "pbrt" or "gltf"; None if the file is no scene."""
    name = file.name.lower()
    if name.endswith(".xml"):
        return scene_version(file)
    if name.endswith(".pbrt"):
        return "pbrt" if b"WorldBegin" in file.read_bytes() else None
    return "gltf" if name.endswith((".gltf", ".glb")) else None


def find_scenes(folders):
    for folder in folders:
        for path, folders_below, names in os.walk(folder):
            folders_below.sort()
            for name in sorted(names):
                file = pathlib.Path(path) / name
                version = kind_of(file) if file.is_file() else None
                if version is not None:
                    yield file, version


def cause(message):
    """What a message is about, without where: the same for all scenes that have the same problem."""
    text = re.sub(r"^(metrolux|error)[^:]*: ", "", message)
    text = re.sub(r"\S*\.(xml|pbrt|gltf|glb)(:[\w.]+)?: ", "", text)
    text = re.sub(r' (id|name)="[^"]*"', "", text)
    text = re.sub(r"\(and \d+ more[^)]*\)|\(looked in: [^)]*\)|\(first at [^)]*\)", "", text)
    text = re.sub(r'"[^"]*[/\\.][^"]*"|\S*/\S+', "FILE", text)
    text = re.sub(r"-?\d+(\.\d+)?(e[-+]?\d+)?", "N", text)
    return text.strip()[:160]


def try_scene(metrolux, file, options, timeout):
    """(outcome, messages): "loads", "refused", "crashed" or "too slow"."""
    command = [metrolux, "info", str(file), "--json", *options]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=timeout, check=False)
    except subprocess.TimeoutExpired:
        return "too slow", []
    if done.returncode == 0:
        return "loads", json.loads(done.stdout)["warnings"]
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    if done.returncode < 0 or done.returncode > 2:
        return "crashed", lines[-1:]
    return "refused", lines[:1]


def print_counts(title, counts):
    if counts:
        print(f"\n{title}")
    for text, count in counts.most_common():
        print(f"  {count:5}  {text}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--metrolux", default=str(ROOT / "build" / "metrolux"), metavar="FILE")
    parser.add_argument("--timeout", type=float, default=300, metavar="SECONDS")
    parser.add_argument("--all", action="store_true", help="list each file")
    rule = parser.add_mutually_exclusive_group()
    rule.add_argument("--lenient", action="store_true")
    rule.add_argument("--strict", action="store_true")
    arguments = parser.parse_args()
    options = ["--lenient"] * arguments.lenient + ["--strict"] * arguments.strict

    outcomes, warned = collections.Counter(), 0
    by_version = collections.defaultdict(collections.Counter)
    causes, warnings = collections.Counter(), collections.Counter()
    for file, version in find_scenes(arguments.folders):
        outcome, messages = try_scene(arguments.metrolux, file, options, arguments.timeout)
        outcomes[outcome] += 1
        by_version[version.split(".")[0] + ".x" if version[:1].isdigit() else version or "none"][outcome] += 1
        counts = warnings if outcome == "loads" else causes
        for text in {cause(message) for message in messages}:
            counts[text] += 1
        warned += outcome == "loads" and bool(messages)
        if arguments.all:
            print(f"{outcome:8}  {file}" + (f"  {messages[0]}" if messages and outcome != "loads" else ""))

    total = sum(outcomes.values())
    print(f"{total} scenes: " + ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common()) +
          f"; {warned} of those that load with warnings")
    for version, counts in sorted(by_version.items()):
        print(f"  version {version:5} " + ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common()))
    print_counts("why scenes were refused (number of scenes)", causes)
    print_counts("warnings (number of scenes)", warnings)
    return 1 if outcomes["crashed"] or outcomes["too slow"] else 0


if __name__ == "__main__":
    sys.exit(main())
