#!/usr/bin/env bash
# The study of docs/lab/paper.md and of the README's table: all integrators on six hard scenes.
#
#   tools/study.sh FOLDER [SCENE...]     scenes: vitrine water-sds torus veach-ajar veach-bidir door-ajar
#
# STUDY_TIME (60s), STUDY_THREADS (1), STUDY_SEEDS (1), STUDY_INTEGRATORS and METROLUX (build/metrolux) may be set. With
# --clock cpu the machine need not be quiet. tools/study_table.py FOLDER makes the table.
# Scenes of ../shared are left out, with a message, where they are absent.
set -euo pipefail
folder=${1:?a folder for the results}
shift
root=$(cd "$(dirname "$0")/.." && pwd)
shared=$root/../shared/scenes
references=$root/tests/agreement/references
metrolux=${METROLUX:-$root/build/metrolux}
integrators=${STUDY_INTEGRATORS:-$("$metrolux" integrators | cut -d' ' -f1 | paste -sd,)}

study() { # scene, reference, resolution, other options
    local scene=$1 reference=$2 resolution=$3
    shift 3
    if [ ! -e "$scene" ] || [ ! -e "$reference" ]; then
        echo "skipped: $scene or its reference $reference is absent" >&2
        return
    fi
    "$metrolux" study "$scene" --ref "$reference" --resolution "$resolution" "$@" \
        --integrators "$integrators" --time "${STUDY_TIME:-60s}" --clock cpu --threads "${STUDY_THREADS:-1}" \
        --seeds "${STUDY_SEEDS:-1}" -o "$folder"
}

for name in "${@:-vitrine water-sds torus veach-ajar veach-bidir door-ajar}"; do
    for scene in $name; do
        case $scene in
            vitrine) study "$root/scenes/vitrine/scene.xml" "$references/vitrine.exr" 192x144 ;;
            water-sds | door-ajar | glossy-room)
                study "$root/scenes/$scene/scene.xml" "$references/$scene.exr" 256x192 ;;
            torus) study "$shared/torus/scene.xml" "$shared/references/torus_256x192.exr" 256x192 --filter box ;;
            veach-ajar)
                study "$shared/veach-ajar/scene.xml" "$shared/references/veach-ajar_256x144.exr" 256x144 --filter box ;;
            veach-bidir)
                study "$shared/veach-bidir/scene.xml" "$shared/references/veach-bidir_256x256.exr" 256x256 --filter box ;;
            *)
                echo "study.sh: unknown scene '$scene'" >&2
                exit 2
                ;;
        esac
    done
done
