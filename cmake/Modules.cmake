# One static library for each module of docs/explain/architecture.md; tests/unit/module_order_test checks the direction of includes.
add_library(metrolux_options INTERFACE)
target_compile_features(metrolux_options INTERFACE cxx_std_20)
target_compile_options(metrolux_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>  # false positives on Imath vectors in GCC 12
  # GCC packs neighbouring floats that were stored one by one into one load, and waits for those stores
  # longer than the wide operations save (docs/lab/performance.md).
  -fno-math-errno -fno-trapping-math -ffp-contract=off -fno-tree-slp-vectorize)
if(METROLUX_WERROR)
  target_compile_options(metrolux_options INTERFACE -Werror)
endif()
if(METROLUX_SANITIZE)
  target_compile_options(metrolux_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(metrolux_options INTERFACE -fsanitize=address,undefined)
endif()
if(METROLUX_TSAN)
  target_compile_options(metrolux_options INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
  target_link_options(metrolux_options INTERFACE -fsanitize=thread)
endif()
if(METROLUX_FUZZ)
  target_compile_options(metrolux_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(METROLUX_COVERAGE)
  target_compile_options(metrolux_options INTERFACE --coverage)
  target_link_options(metrolux_options INTERFACE --coverage)
endif()


# All modules are built once for METROLUX_ARCH and once more for each of METROLUX_LEVELS, as targets whose names end in the level.
# The dynamic linker takes the library of the processor's level (src/CMakeLists.txt).
foreach(level "" ${METROLUX_LEVELS})
  set(arch ${METROLUX_ARCH})
  set(suffix "")
  if(level)
    set(arch ${level})
    set(suffix -${level})
  endif()
  add_library(metrolux_arch${suffix} INTERFACE)
  if(arch AND CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(metrolux_arch${suffix} INTERFACE -march=${arch})
  endif()
endforeach()

# Where METROLUX_UNITY asks for it, sources are compiled eight at a time: most of what a source takes is the headers of others.
function(metrolux_unity target)
  if(METROLUX_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    # Sources are included there, which makes them headers for this warning.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# metrolux_module(name DEPENDS modules... LIBRARIES external... INSIDE external... GENERATED sources...): headers of modules include
# those of LIBRARIES, and nothing of INSIDE.
function(metrolux_module name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;LIBRARIES;INSIDE;GENERATED" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  if(NOT sources)
    set(sources ${PROJECT_SOURCE_DIR}/cmake/empty.cpp)
  endif()
  foreach(level "" ${METROLUX_LEVELS})
    set(suffix "")
    if(level)
      set(suffix -${level})
    endif()
    set(target metrolux_${name}${suffix})
    add_library(${target} STATIC ${sources} ${ARG_GENERATED})
    target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/include)
    # They are parts of the shared library, which exports what include/metrolux declares.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden
      VISIBILITY_INLINES_HIDDEN ON)
    metrolux_unity(${target})
    target_link_libraries(${target} PUBLIC metrolux_options metrolux_arch${suffix} ${ARG_LIBRARIES})
    target_link_libraries(${target} PRIVATE ${ARG_INSIDE})
    foreach(module ${ARG_DEPENDS})
      target_link_libraries(${target} PUBLIC metrolux_${module}${suffix})
    endforeach()
  endforeach()
endfunction()
