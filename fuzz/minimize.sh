#!/bin/sh
# Keeps of what libFuzzer has found for a target the fewest and smallest inputs that reach as much, at most 4 MiB of them:
# minimize.sh BUILD_FOLDER TARGET. The corpus of the repository is not touched, and what it reaches is not kept twice.
set -e
build=$1 target=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$here/../fuzz-work
[ -d "$work/$target" ] || exit 0
small=$work/$target.small
rm -rf "$small"
cp -r "$here/corpus/$target" "$small"
export ASAN_OPTIONS=allocator_may_return_null=1
"$build/fuzz/fuzz_$target" -merge=1 -timeout=30 -rss_limit_mb=3000 -max_len=16384 "$small" "$work/$target"
for file in "$here/corpus/$target"/*; do rm -f "$small/$(basename "$file")"; done
# The largest go first.
ls -lS "$small" | awk 'NR > 1 {size[NR] = $5; name[NR] = $NF; sum += $5}
  END {for (i = 2; i <= NR && sum > 4194304; ++i) {print name[i]; sum -= size[i]}}' |
  while read -r name; do rm -f "$small/$name"; done
rm -rf "${work:?}/$target"
mv "$small" "$work/$target"
echo "$target: $(ls "$work/$target" | wc -l) inputs, $(du -sk "$work/$target" | cut -f1) KiB kept"
