#!/usr/bin/env bash
# Makes the pictures of docs/tutorial/python*.md by running their scripts with the Python package of a build.
# usage: tools/tutorial_pictures.sh BUILD
set -euo pipefail
[ $# = 1 ] || { sed -n '3s/^# //p' "$0" >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
PYTHONPATH=$(cd "$1" && pwd)/python
export PYTHONPATH
python=$(sed -n 's/^_Python3_EXECUTABLE:[^=]*=//p' "$1/CMakeCache.txt")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$python" "$root/docs/tutorial/python/first_render.py" 60
"$python" "$root/docs/tutorial/python/compare.py" "$root"/{scenes/water-sds/scene.xml,tests/agreement/references/water-sds.exr} 12
"$python" "$root/docs/tutorial/python/lamp.py"
for picture in ring curves lamp; do
    cp $picture.png "$root/docs/tutorial/pictures/python-$picture.png"
done
