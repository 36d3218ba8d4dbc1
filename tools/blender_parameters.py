#!/usr/bin/env python3
"""Writes blender/metrolux/parameters.json, from which the add-on makes its settings, from what the command says.

usage: tools/blender_parameters.py METROLUX > blender/metrolux/parameters.json
"""

import json
import subprocess
import sys


def integrators(markdown):
    """The integrators of `metrolux integrators --markdown`: what each is, and its parameters (name, default, expected)."""
    result, current = {}, None
    for line in markdown.splitlines():
        if line.startswith("## "):
            current = result[line[3:].strip()] = {"text": "", "parameters": []}
        elif current is None or not line:
            continue
        elif line.startswith("| "):
            cells = [cell.strip().replace("`", "") for cell in line.strip("|").split("|")]
            if cells[0] not in ("parameter",):
                current["parameters"].append(cells)
        elif not current["text"] and not line.startswith("|"):
            current["text"] = line
    return result


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip().splitlines()[-1])
    text = subprocess.run([sys.argv[1], "integrators", "--markdown"], check=True, capture_output=True, text=True).stdout
    json.dump({"integrators": integrators(text)}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
