#!/usr/bin/env bash
# The picture of docs/how-to/watch-a-render.md: tools/view_picture.sh BUILD. Needs chromium.
set -euo pipefail
build=$(realpath "${1:-build}")
cd "$(dirname "$0")/.."
log=$(mktemp)
"$build/metrolux" view scenes/water-sds/scene.xml --resolution 480x480 --exposure 0 -o "$log.exr" --no-open 2> "$log" &
view=$!
trap 'kill $view; wait $view || true; rm -f "$log" "$log".*' EXIT
until grep -q 'http://' "$log"; do sleep 0.1; done
url=$(grep -om1 'http://[^ ]*' "$log")
picture=$PWD/docs/how-to/pictures/view.jpg
mkdir -p docs/how-to/pictures
(cd "$build/web" && node test/picture.mjs "$url" "$picture" 60)
