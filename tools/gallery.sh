#!/bin/bash
# Renders the pictures of the README with the program that is built: `make gallery`.
#
# GALLERY_PASSES, GALLERY_SIZE and GALLERY_THREADS change passes, resolution and threads; names of scenes as arguments
# render these alone. METROLUX is the program.
set -euo pipefail
cd "$(dirname "$0")/.."

scenes=("$@")
if [ ${#scenes[@]} = 0 ]; then
    for file in scenes/*/scene.xml; do scenes+=("$(basename "$(dirname "$file")")"); done
fi
threads=${GALLERY_THREADS:+--threads $GALLERY_THREADS}
mkdir -p docs/gallery
for name in "${scenes[@]}"; do
    passes=${GALLERY_PASSES:-64}
    case $name in  # noisier than the others
        door-ajar) passes=$((3 * passes)) ;;
        environment) passes=$((2 * passes)) ;;
        haze | murky-pool | wax | cloud) passes=$((4 * passes)) ;;
    esac
    # shellcheck disable=SC2086
    "${METROLUX:-build/metrolux}" render "scenes/$name/scene.xml" --resolution "${GALLERY_SIZE:-336x252}" \
        --passes "$passes" $threads --save-every 0 -o "docs/gallery/$name.png"
done
