#!/usr/bin/env bash
# Prints one line about a run of ctest: how many tests passed, failed and were skipped, and for which reasons.
# usage: tools/test_summary.sh REPORT SHARED     REPORT: what ctest --output-junit wrote; SHARED: the folder of shared test data
# Exit status 1 when a test failed or did not run, and when one was skipped for want of SHARED although that folder is there.
set -euo pipefail
[ $# = 2 ] || { sed -n '3,4s/^# //p' "$0" >&2; exit 2; }
present=no
[ -d "$2" ] && present=yes
awk -v present="$present" '
    function attribute(name,   from) {
        from = index($0, name "=\"")
        return from ? substr($0, from + length(name) + 2, index(substr($0, from + length(name) + 2), "\"") - 1) : ""
    }
    /<testcase / { test = attribute("name"); status = attribute("status"); reason = ""; expect = 0 }
    expect { reason = $0; expect = 0 }
    /: Skipped$/ { expect = 1 }
    /<skipped / && !/SKIP_REGULAR_EXPRESSION_MATCHED|SKIP_RETURN_CODE/ { status = "fail" }  # not built, no such program
    /<\/testcase>/ {
        if (status == "run") ++passed
        else if (status == "fail") failed[++failures] = test
        else {
            ++skipped
            if (reason ~ /^for want of \.\.\/shared/) { reason = "for want of ../shared"; ++wanting }
            gsub(/&quot;/, "\"", reason); gsub(/&lt;/, "<", reason); gsub(/&gt;/, ">", reason); gsub(/&amp;/, "\\&", reason)
            if (reason == "") reason = status == "disabled" ? "disabled" : "no reason given"
            if (!count[reason]++) reasons[++kinds] = reason
        }
    }
    END {
        line = (passed + 0) " tests passed"
        if (failures) {
            line = line ", " failures " FAILED ("
            for (i = 1; i <= failures; ++i) line = line (i > 1 ? ", " : "") failed[i]
            line = line ")"
        }
        line = line ", " (skipped + 0) " skipped"
        for (i = 1; i <= kinds; ++i) line = line (i > 1 ? ", " : ": ") count[reasons[i]] " " reasons[i]
        print line
        if (wanting && present == "yes") print "../shared is there, and yet tests were skipped for want of it: that is a failure"
        exit failures || (wanting && present == "yes") || !passed
    }' "$1"
