#!/usr/bin/env python3
"""Writes the meshes and images of the scenes of the large pictures: tools/make_pictures.py [NAME...]

Needs numpy. The files are committed: run this only after a change.
"""

import importlib
import pathlib
import sys

TOOLS = pathlib.Path(__file__).parent
PICTURES = ["pool", "wine"]  # scenes, and modules of tools/pictures


def main():
    sys.path[:0] = [str(TOOLS / "pictures"), str(TOOLS)]
    for name in sys.argv[1:] or PICTURES:
        folder = TOOLS.parent / "scenes" / name
        folder.mkdir(parents=True, exist_ok=True)
        importlib.import_module(name).write(folder)


if __name__ == "__main__":
    main()
