# The revision, which study/build_description.cpp reports, and the flags, which are a part of a checkpoint's identity.
set(revision "unknown")
find_package(Git QUIET)
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0)
    set(revision "${head}")
  endif()
endif()

string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
set(flags "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${type}}")
if(METROLUX_ARCH AND type STREQUAL "RELEASE")
  string(APPEND flags " -march=${METROLUX_ARCH}")
endif()
string(STRIP "${flags}" flags)
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/study/build_description.cpp PROPERTIES
  COMPILE_DEFINITIONS "METROLUX_REVISION=\"${revision}\"")
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/render/build_id.cpp PROPERTIES
  COMPILE_DEFINITIONS "METROLUX_FLAGS=\"${flags}\"")
