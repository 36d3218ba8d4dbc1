#!/bin/sh
# libFuzzer on one target: run.sh BUILD_FOLDER TARGET SECONDS. Inputs that it finds stay in fuzz-work/TARGET, one
# that ends the process in fuzz-work/TARGET-*.
set -e
build=$1 target=$2 seconds=$3
here=$(cd "$(dirname "$0")" && pwd)
work=$here/../fuzz-work
mkdir -p "$work/$target"
dictionary=$here/dictionaries/$target.dict
export ASAN_OPTIONS=allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1
exec nice -n 10 "$build/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=30 -rss_limit_mb=3000 -max_len=16384 \
  -print_final_stats=1 -artifact_prefix="$work/$target-" \
  $([ ! -f "$dictionary" ] || echo "-dict=$dictionary") "$work/$target" "$here/corpus/$target"
