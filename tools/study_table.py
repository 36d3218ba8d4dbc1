#!/usr/bin/env python3
"""Table of the studies in a folder (tools/study.sh), for README.md and docs/lab/paper.md.

    tools/study_table.py FOLDER... [--base NAME]

NAME: integrator that all are divided by (default: mcmc_vcm). Of several folders the last that has an integrator on a
scene counts, for integrators that were run again.

Each cell: relMSE times seconds, over that of BASE; behind the stroke without the 0.1 % worst pixels; bold: the
smallest of the scene. Then, for each integrator, the worst case over the scenes: its error over the best's.
"""

import argparse
import json
import sys
from pathlib import Path

METRICS = ("rel_mse", "trimmed_rel_mse")


def read(folders):
    """Costs by (scene, integrator, metric), with scenes and integrators in their order."""
    costs, scenes, labels = {}, [], []
    for file in [f for folder in folders for f in sorted(folder.glob("*/study.json"))]:
        scene = file.parent.name
        if scene not in scenes:
            scenes.append(scene)
        for entrant in json.loads(file.read_text())["entrants"]:
            summary = entrant["summary"]
            if not summary or not summary.get("final"):
                continue
            label = entrant["label"]
            if label not in labels:
                labels.append(label)
            for metric in METRICS:
                costs[scene, label, metric] = summary["final"][metric]["mean"] * summary["seconds"]
    return costs, scenes, labels


def number(x):
    return f"{x:.2f}" if x < 9.95 else f"{x:.0f}" if x < 9999 else f"{x:.0e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--base", default="mcmc_vcm", metavar="NAME")
    arguments = parser.parse_args()
    base = arguments.base
    for folder in arguments.folders:
        if not any(folder.glob("*/study.json")):
            print(f"study_table.py: {folder}: found no SCENE/study.json", file=sys.stderr)
            return 2
    costs, scenes, labels = read(arguments.folders)
    for scene in scenes:
        if (scene, base, METRICS[0]) not in costs:
            print(f"study_table.py: {scene}: {base} is not among its integrators", file=sys.stderr)
            return 2
    best = {(s, m): min(costs[s, l, m] for l in labels if (s, l, m) in costs) for s in scenes for m in METRICS}

    def cell(scene, label, metric):
        if (scene, label, metric) not in costs:
            return "–"
        cost = costs[scene, label, metric]
        text = number(cost / costs[scene, base, metric])
        return f"**{text}**" if cost == best[scene, metric] else text

    print("| | " + " | ".join(scenes) + " |")
    print("|---" * (len(scenes) + 1) + "|")
    for label in labels:
        print(f"| {label} | " + " | ".join(" / ".join(cell(s, label, m) for m in METRICS) for s in scenes) + " |")
    print("\nworst case, over the best of the scene:")
    for metric in METRICS:
        worst = {l: max(costs[s, l, metric] / best[s, metric] for s in scenes if (s, l, metric) in costs) for l in labels}
        ranked = sorted(worst.items(), key=lambda item: item[1])
        print(f"{metric}: " + ", ".join(f"{label} {number(ratio)}" for label, ratio in ranked))
    return 0


if __name__ == "__main__":
    sys.exit(main())
