#!/usr/bin/env bash
# Checks the format of C++ files, and runs clang-tidy on those of src/ where build/ has compile commands.
# usage: tools/pre_commit.sh [FILE]...     without files: those that are staged for the next commit
# Exit status 1 when something is to be mended; nothing is changed.
set -euo pipefail
cd "$(git rev-parse --show-toplevel)"
files=("$@")
if [ $# = 0 ]; then
    mapfile -t files < <(git diff --cached --name-only --diff-filter=ACMR)
fi
status=0
sources=() units=()
for file in "${files[@]}"; do
    case $file in *.cpp | *.h) sources+=("$file") ;; esac
    case $file in src/*.cpp) units+=("$file") ;; esac
done
if [ ${#sources[@]} != 0 ]; then
    if command -v clang-format >/dev/null; then
        clang-format --dry-run --Werror "${sources[@]}" || { echo "clang-format -i mends this" >&2; status=1; }
    else
        echo "clang-format is not installed: the format was not checked" >&2
    fi
fi
if [ ${#units[@]} != 0 ] && [ -f build/compile_commands.json ]; then
    if command -v clang-tidy >/dev/null; then
        clang-tidy -p build --quiet "${units[@]}" || status=1
    else
        echo "clang-tidy is not installed: $(printf '%s ' "${units[@]}")was not checked" >&2
    fi
fi
exit "$status"
