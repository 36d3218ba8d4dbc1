#!/usr/bin/env bash
# Renders the pictures of docs/integrators.md: every integrator for the same time on the same scenes, one after the
# other, and prints their errors (tools/equal_time.sh). The machine should be quiet. `make integrator-pictures`
#
# usage: tools/integrator_pictures.sh [SECONDS]     METROLUX is the program, INTEGRATORS and SCENES say which ones.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-20}
export INTEGRATORS=${INTEGRATORS:-path light bdpt vcm mcmc_vcm sppm vpt split_mcmc pssmlt mmlt pssmlt_merge}
scenes=${SCENES:-water-sds door-ajar}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
items=()
for scene in $scenes; do
    items+=("scenes/$scene/scene.xml:tests/agreement/references/$scene.exr:256x192")
done
tools/equal_time.sh "$seconds" "$out" "${items[@]}"
mkdir -p docs/integrators
cp "$out"/*.png docs/integrators/
