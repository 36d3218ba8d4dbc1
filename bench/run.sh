#!/bin/bash
# Measures kernels and whole renders: bench/run.sh BUILD. JSON files and table.txt go to BUILD/bench/results.
# Environment: SCENES (scene files), INTEGRATORS, RESOLUTION, PASSES, THREADS; QUICK=1 for a look in some minutes.
set -euo pipefail
BUILD=$(realpath "${1:?usage: bench/run.sh BUILD}")
ROOT=$(realpath "$(dirname "$0")/..")
METROLUX=$BUILD/metrolux
RESULTS=$BUILD/bench/results
THREADS=${THREADS:-2}
if [ -n "${QUICK:-}" ]; then
  RESOLUTION=${RESOLUTION:-128x128} PASSES=${PASSES:-3} TRIANGLES="1000 10000 100000" LIGHTS="1 100"
else
  RESOLUTION=${RESOLUTION:-512x512} PASSES=${PASSES:-5} TRIANGLES="1000 10000 100000 1000000 10000000"
  LIGHTS="1 10 100 1000 10000"
fi
INTEGRATORS=${INTEGRATORS:-path bdpt vcm mcmc_vcm}
SCENES=${SCENES:-$(ls "$ROOT"/scenes/*/scene.xml "$ROOT"/../shared/scenes/*/scene.xml 2>/dev/null)}
mkdir -p "$RESULTS"
: > "$RESULTS/table.txt"

# measure NAME SCENE OPTIONS...: a line of JSON in a file, a table for people.
measure() {
  local name=$1 scene=$2
  shift 2
  echo "== $name" | tee -a "$RESULTS/table.txt"
  "$METROLUX" bench "$scene" --threads "$THREADS" --passes "$PASSES" --json "$RESULTS/$name.json" "$@" |
    tee -a "$RESULTS/table.txt"
}

"$BUILD/bench/bench_kernels" ${QUICK:+--benchmark_min_time=0.05} --benchmark_out="$RESULTS/kernels.json" \
  --benchmark_out_format=json | tee -a "$RESULTS/table.txt"

for scene in $SCENES; do
  for integrator in $INTEGRATORS; do
    measure "scene-$(basename "$(dirname "$scene")")-$integrator" "$scene" -i "$integrator" --resolution "$RESOLUTION"
  done
done

for n in $TRIANGLES; do
  "$BUILD/bench/bench_scene" triangles "$n" "$BUILD/bench/triangles-$n"
  measure "triangles-$n" "$BUILD/bench/triangles-$n/scene.xml" -i mcmc_vcm
done
for n in $LIGHTS; do
  "$BUILD/bench/bench_scene" lights "$n" "$BUILD/bench/lights-$n"
  measure "lights-$n" "$BUILD/bench/lights-$n/scene.xml" -i path
done
GROWTH=$(echo "$SCENES" | grep veach-ajar || echo "$SCENES" | head -n 1)
for size in 128 256 512 1024; do
  [ -n "${QUICK:-}" ] && [ "$size" -gt 256 ] && continue
  measure "pixels-$size" "$GROWTH" -i mcmc_vcm --resolution "${size}x${size}"
done
for depth in 2 4 8 16 32; do
  measure "depth-$depth" "$GROWTH" -i mcmc_vcm --max-depth "$depth" --resolution 128x128
done
echo "wrote $RESULTS"
