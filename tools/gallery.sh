#!/bin/bash
# Renders the pictures of README.md and docs/README.md with the program that is built: `make gallery`.
#
# Names of scenes as arguments render these alone; METROLUX is the program, PYTHON one with Pillow. GALLERY_THREADS changes
# threads; GALLERY_PASSES and GALLERY_SIZE passes and resolution of the small pictures, which take two minutes on two cores.
# The large ones have no noise left that is seen at 100 %, and take 10 to 20 minutes of one core each.
set -euo pipefail
cd "$(dirname "$0")/.."

scenes=("$@")
if [ ${#scenes[@]} = 0 ]; then
    for file in scenes/*/scene.xml; do scenes+=("$(basename "$(dirname "$file")")"); done
fi
metrolux=${METROLUX:-build/metrolux}
threads=${GALLERY_THREADS:+--threads $GALLERY_THREADS}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p docs/gallery

# NAME WIDTHxHEIGHT PASSES [OPTIONS]: a large picture, denoised, as JPEG
large() {
    # shellcheck disable=SC2086
    "$metrolux" render "scenes/$1/scene.xml" --resolution "$2" --passes "$3" $threads --save-every 0 --curve filmic --denoise \
        -o "$folder/$1.png" "${@:4}"
    "${PYTHON:-python3}" -c 'import sys; from PIL import Image
Image.open(sys.argv[1]).convert("RGB").save(sys.argv[2], quality=90, optimize=True, progressive=True)' \
        "$folder/$1.png" "docs/gallery/$1.jpg"
}

small() {
    local passes=${GALLERY_PASSES:-64}
    case $1 in  # noisier than the others
        door-ajar) passes=$((3 * passes)) ;;
        environment) passes=$((2 * passes)) ;;
        haze | murky-pool | wax | cloud | prism) passes=$((4 * passes)) ;;
    esac
    # shellcheck disable=SC2086
    "$metrolux" render "scenes/$1/scene.xml" --resolution "${GALLERY_SIZE:-336x252}" --passes "$passes" $threads \
        --save-every 0 -o "docs/gallery/$1.png"
}

for name in "${scenes[@]}"; do
    case $name in
        wine) large wine 1200x780 113 ;;
        pool) large pool 1200x800 49 --exposure 1.4 ;;
        *) small "$name" ;;
    esac
done
