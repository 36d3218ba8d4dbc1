#!/usr/bin/env bash
# Equal-time comparison of integrators: each renders each scene for the same time, one after the other, with THREADS threads
# (default 2; the machine should be quiet). Prints relMSE against the reference, trimmed relMSE (without the 0.1 % worst pixels),
# bias of the mean, passes and processor seconds, a row for each integrator of INTEGRATORS.
#
# usage: tools/equal_time.sh SECONDS OUTPUT_FOLDER SCENE.xml:REFERENCE.exr:WIDTHxHEIGHT[:FILTER] ...
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
metrolux=${METROLUX:-$here/build/metrolux}
integrators=${INTEGRATORS:-path bdpt vcm mcmc_vcm}
seconds=$1 out=$2
shift 2
mkdir -p "$out"
printf '| scene | integrator | relMSE | trimmed | bias of mean | passes | CPU s |\n|---|---|---|---|---|---|---|\n'
for item in "$@"; do
    IFS=: read -r scene reference size filter <<<"$item"
    name=$(basename "$(dirname "$scene")")
    for i in $integrators; do
        to=$out/$name-$i
        TIMEFORMAT='%U'
        { time "$metrolux" render "$scene" -i "$i" --time "${seconds}s" --threads "${THREADS:-2}" --resolution "$size" \
            ${filter:+--filter "$filter"} --seed 1 --save-every 0 -o "$to.exr" -o "$to.png" \
            --stats "$to.json" --quiet 2>>"$to.log"; } 2>"$to.cpu"
        values=$("$metrolux" compare "$to.exr" "$reference")
        field() { sed -n "s/^$1 *\([^ ]*\).*/\1/p" <<<"$values"; }
        printf '| %s | %s | %.4g | %.4g | %+.2f %% | %s | %s |\n' "$name" "$i" "$(field relMSE)" "$(field trimmed)" \
            "$(field bias)" "$(grep -o '"passes": [0-9]*' "$to.json" | head -1 | grep -o '[0-9]*$')" "$(tail -1 "$to.cpu")"
    done
done
