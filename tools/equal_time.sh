#!/usr/bin/env bash
# Equal-time comparison of integrators: for each scene all of them run side by side with one thread each for the same
# time, so that they share the machine fairly however noisy it is. Prints relMSE against the reference, trimmed relMSE
# (without the 0.1 % worst pixels), bias of the mean, passes and CPU seconds, a row for each integrator.
#
# usage: tools/equal_time.sh SECONDS OUTPUT_FOLDER SCENE.xml:REFERENCE.exr:WIDTHxHEIGHT[:FILTER] ...
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
metrolux=${METROLUX:-$here/build/metrolux}
seconds=$1 out=$2
shift 2
mkdir -p "$out"
printf '| scene | integrator | relMSE | trimmed | bias of mean | passes | CPU s |\n|---|---|---|---|---|---|---|\n'
for item in "$@"; do
    IFS=: read -r scene reference size filter <<<"$item"
    name=$(basename "$(dirname "$scene")")
    for i in path light bdpt vcm mcmc_vcm; do
        (
            TIMEFORMAT='%U'
            { time "$metrolux" render "$scene" -i "$i" --time "${seconds}s" --threads 1 --resolution "$size" \
                ${filter:+--filter "$filter"} --seed 1 -o "$out/$name-$i.exr" -o "$out/$name-$i.png" \
                --stats "$out/$name-$i.json" --quiet 2>>"$out/$name-$i.log"; } 2>"$out/$name-$i.cpu"
        ) &
    done
    wait
    for i in path light bdpt vcm mcmc_vcm; do
        values=$("$metrolux" compare "$out/$name-$i.exr" "$reference")
        field() { sed -n "s/^$1 *\([^ ]*\).*/\1/p" <<<"$values"; }
        printf '| %s | %s | %.4g | %.4g | %s %% | %s | %s |\n' "$name" "$i" "$(field relMSE)" "$(field trimmed)" \
            "$(field bias)" "$(grep -o '"passes": [0-9]*' "$out/$name-$i.json" | head -1 | grep -o '[0-9]*$')" \
            "$(tail -1 "$out/$name-$i.cpu")"
    done
done
