#!/usr/bin/env bash
# Makes the pictures of docs/tutorial/blender.md by running its script in Blender with the add-on and the command of a build.
# usage: tools/blender_pictures.sh BUILD [SECONDS]
set -euo pipefail
[ $# -ge 1 ] || { sed -n '3s/^# //p' "$0" >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export METROLUX_COMMAND="$build/metrolux" BLENDER_USER_SCRIPTS="$folder" BLENDER_USER_CONFIG="$folder"
install="import bpy, addon_utils
bpy.ops.preferences.addon_install(filepath='$build/metrolux-blender.zip')
addon_utils.enable('metrolux', default_set=True)"
blender -b --factory-startup --python-exit-code 1 --python-expr "$install" \
    -P "$root/docs/tutorial/blender/scene.py" -- "$folder" "${2:-30}"
cp "$folder"/blender-{metrolux,cycles}.png "$root/docs/tutorial/pictures/"
