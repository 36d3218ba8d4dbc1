# Says why there are no tests of the Python package, in the form that tools/test_summary.sh reads.
message("python.package: Skipped\n${REASON}")
