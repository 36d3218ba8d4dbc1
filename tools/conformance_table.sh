#!/usr/bin/env bash
# Prints the rows that `make test-conformance` left in build/conformance as one table: scene x integrator.
# `path`: share of pixel-channels above the level of Mitsuba's Z-test (99.75 % pass). The others: least p-value of the blocks
# (above the level in brackets passes), and in braces the difference that the median block would show.
set -euo pipefail
cd "$(dirname "$0")/.."
echo '| scene | path | bdpt | vcm | mcmc_vcm | seconds |'
echo '|---|---|---|---|---|---|'
cat build/conformance/*.row | awk -F' *[|] *' '
    { sub(/.*\//, "", $2); sub(/^test_/, "", $2)
      if ($2 == "scene") $2 = "infinite_mirrors"
      gsub(/level /, "", $4); gsub(/, sees /, " {", $4); sub(/^p /, "", $4)
      if ($4 ~ /{/) $4 = $4 "}"
      value[$2, $3] = $4; seconds[$2, $3] = $5; scenes[$2] }
    END {
        for (s in scenes)
            printf "| %s | %s | %s | %s | %s | %s/%s/%s/%s |\n", s, value[s, "path"], value[s, "bdpt"], value[s, "vcm"],
                   value[s, "mcmc_vcm"], seconds[s, "path"], seconds[s, "bdpt"], seconds[s, "vcm"], seconds[s, "mcmc_vcm"]
    }' | sort
