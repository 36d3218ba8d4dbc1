#!/bin/sh
# Makes the corpus of fuzz/checkpoint.cpp anew: make_checkpoints.sh METROLUX. Small checkpoints of each kind of state.
set -e
here=$(cd "$(dirname "$0")" && pwd)
metrolux=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp -r "$here/../scenes/water-sds/." "$folder"
cd "$folder"
make() {  # NAME PASSES, options of `metrolux render`
  name=$1 passes=$2
  shift 2
  "$metrolux" render scene.xml --resolution 6x4 --max-depth 6 --lanes 2 --passes "$passes" --checkpoint "$name" --quiet "$@"
  cp "$name" "$here/corpus/checkpoint/$name"
}
mkdir -p "$here/corpus/checkpoint"
for integrator in $("$metrolux" integrators | cut -d' ' -f1); do make "$integrator" 3 -i "$integrator"; done
make pssmlt_adaptive 3 -i pssmlt --kernel adaptive
make mcmc_vcm_bennett 3 -i mcmc_vcm --normalization bennett
make mcmc_vcm_auto 9 -i mcmc_vcm --split auto
make pssmlt_merge_a 3 -i pssmlt_merge --method A
make slices 6 -i vpt --slices 4
make part 6 -i path --slices 4 --only-slices 1-2
