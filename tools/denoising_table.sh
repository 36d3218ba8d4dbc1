#!/usr/bin/env bash
# Table of docs/lab/denoising.md: errors of eight scenes after 64 passes, as rendered and denoised by our own filter.
# usage: tools/denoising_table.sh METROLUX FOLDER
# References that FOLDER lacks are rendered (SCENE.exr, with another seed: half an hour on two cores); pictures are left there.
set -euo pipefail
metrolux=$1
folder=$2
here=$(cd "$(dirname "$0")/.." && pwd)
export METROLUX_OIDN=off

mkdir -p "$folder"
printf '| scene | relMSE | denoised | falls by | trimmed | denoised | falls by | seconds |\n|---|---|---|---|---|---|---|---|\n'
value() { "$metrolux" compare "$@" --json | grep "\"$field\"" | grep -o ': [0-9.e+-]*' | cut -c3-; }
row() {  # SCENE FILE REFERENCE OPTIONS
  local name=$1 file=$2 reference=$3 image=$folder/$1-64.exr
  shift 3
  if [ ! -e "$reference" ]; then
    "$metrolux" render "$file" "$@" --passes 1200 --seed 11 -o "$reference" --quiet
  fi
  "$metrolux" render "$file" "$@" --passes 64 --seed 5 --denoise --quiet --overwrite \
    -o "$image" -o "$folder/$name-denoised.png" --stats "$folder/$name.json"
  local line="| $name |" field before after
  for field in rel_mse trimmed_rel_mse; do
    before=$(value "$image" "$reference")
    after=$(value "$image" "$reference" --layer denoised)
    line+=$(awk -v a="$before" -v b="$after" 'BEGIN { printf " %.5f | %.5f | %.2f |", a, b, a / b }')
  done
  echo "$line $(grep seconds_for_denoising "$folder/$name.json" | grep -o '[0-9]*\.[0-9]' | head -1) |"
}

own=$here/tests/agreement/references
shared=$here/../shared/scenes
for scene in glass-sphere textured spot-directional environment; do
  row $scene "$here/scenes/$scene/scene.xml" "$folder/$scene.exr"
done
row water-sds "$here/scenes/water-sds/scene.xml" "$own/water-sds.exr"
row door-ajar "$here/scenes/door-ajar/scene.xml" "$own/door-ajar.exr"
row vitrine "$here/scenes/vitrine/scene.xml" "$own/vitrine.exr" --resolution 192x144
row veach-bidir "$shared/veach-bidir/scene.xml" "$shared/references/veach-bidir_256x256.exr" --resolution 256x256 --filter box
