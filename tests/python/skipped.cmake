# Says why there are no tests NAME (python.package), in the form that tools/test_summary.sh reads.
if(NOT NAME)
  set(NAME python.package)
endif()
message("${NAME}: Skipped\n${REASON}")
