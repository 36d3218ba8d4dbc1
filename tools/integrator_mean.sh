#!/usr/bin/env bash
# Mean of the image that an integrator makes of a scene, over independent seeds, with its standard error from the scatter
# between them: what tells bias from noise.
#
# usage: tools/integrator_mean.sh SCENE.xml WIDTHxHEIGHT PASSES SEEDS [options of `metrolux render`]
#        METROLUX is the program, FIRST the first seed (default 2000)
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
metrolux=${METROLUX:-$here/build/metrolux}
scene=$1 size=$2 passes=$3 seeds=$4
shift 4
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for ((seed = ${FIRST:-2000}; seed < ${FIRST:-2000} + seeds; ++seed)); do
    "$metrolux" render "$scene" --resolution "$size" --passes "$passes" --seed "$seed" --save-every 0 --quiet -o "$out/a.exr" "$@"
    "$metrolux" compare "$out/a.exr" "$out/a.exr" --json | grep -o '"mean": *[-0-9.e]*' | grep -o '[-0-9.e]*$'
done | awk '{ n++; s += $1; q += $1 * $1 }
    END { m = s / n; e = sqrt((q / n - m * m) / (n - 1)); printf "%.6f +- %.6f (%.2f %%) over %d seeds\n", m, e, 100 * e / m, n }'
