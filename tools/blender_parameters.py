#!/usr/bin/env python3
"""Writes blender/metrolux/parameters.json, from which the add-on makes its settings, from what the command says.

usage: tools/blender_parameters.py METROLUX > blender/metrolux/parameters.json
"""

import json
import subprocess
import sys


def integrators(described):
    """Of `metrolux integrators --json`: what each is, and its parameters (name, default, expected)."""
    return {
        integrator["name"]: {
            "text": integrator["summary"][0].upper() + integrator["summary"][1:] + ".",
            "parameters": [[p["name"], p["default"], p["expected"].replace("`", "")] for p in integrator["parameters"]],
        }
        for integrator in described
    }


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip().splitlines()[-1])
    text = subprocess.run([sys.argv[1], "integrators", "--json"], check=True, capture_output=True, text=True).stdout
    json.dump({"integrators": integrators(json.loads(text))}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
