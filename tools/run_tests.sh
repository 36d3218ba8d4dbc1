#!/usr/bin/env bash
# Runs ctest and ends with the line of tools/test_summary.sh.
# usage: tools/run_tests.sh PRESET [OPTION OF CTEST]...
set -uo pipefail
[ $# -ge 1 ] || { sed -n '3s/^# //p' "$0" >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root" || exit 2
report=$(mktemp) || exit 2
trap 'rm -f "$report"' EXIT
ctest --preset "$1" --output-junit "$report" "${@:2}"
status=$?
"$root/tools/test_summary.sh" "$report" "$root/../shared" && exit "$status"
exit 1
