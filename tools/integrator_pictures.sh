#!/usr/bin/env bash
# Renders the pictures of docs/lab/integrators.md and prints the errors: `make integrator-pictures`. Every integrator makes as many
# passes as take ten seconds of processor time (of the machine that the table below was measured on), so that the
# pictures are equal-time ones and the same bits everywhere, however busy the machine is.
#
# METROLUX is the program, SCENES and INTEGRATORS say which ones; FACTOR multiplies all passes.
set -euo pipefail
cd "$(dirname "$0")/.."
metrolux=${METROLUX:-build/metrolux}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
mkdir -p docs/lab/pictures

passes() {
    case $1-$2 in
        water-sds-path) echo 37 ;; water-sds-light) echo 125 ;; water-sds-bdpt) echo 32 ;;
        water-sds-vcm) echo 25 ;; water-sds-mcmc_vcm) echo 15 ;; water-sds-sppm) echo 72 ;;
        water-sds-vpt) echo 55 ;; water-sds-split_mcmc) echo 23 ;; water-sds-pssmlt) echo 29 ;;
        water-sds-mmlt) echo 63 ;; water-sds-pssmlt_merge) echo 13 ;;
        *) echo "left out: no number of passes is known for $2 on $1" >&2; return 1 ;;
    esac
}

printf '| scene | integrator | passes | relMSE | trimmed | bias of mean | CPU s |\n|---|---|---|---|---|---|---|\n'
for scene in ${SCENES:-water-sds}; do
    for i in ${INTEGRATORS:-$("$metrolux" integrators | cut -d' ' -f1)}; do
        n=$(passes "$scene" "$i") || continue
        n=$((n * ${FACTOR:-1}))
        TIMEFORMAT='%U'
        { time "$metrolux" render "scenes/$scene/scene.xml" -i "$i" --passes "$n" --resolution 256x192 --seed 1 --save-every 0 \
            --quiet -o "$out/a.exr" -o "docs/lab/pictures/$scene-$i.png"; } 2>"$out/cpu"
        values=$("$metrolux" compare "$out/a.exr" "tests/agreement/references/$scene.exr")
        field() { sed -n "s/^$1 *\([^ ]*\).*/\1/p" <<<"$values"; }
        printf '| %s | %s | %s | %.4g | %.4g | %+.2f %% | %s |\n' "$scene" "$i" "$n" "$(field relMSE)" "$(field trimmed)" \
            "$(field bias)" "$(tail -1 "$out/cpu")"
    done
done
