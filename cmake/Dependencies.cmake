# All of them are Debian packages: see packages.txt. Shared with the installed package configuration.
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(embree 3 REQUIRED)
find_package(Imath REQUIRED)
# Debian's OpenImageIOConfig.cmake wants its tools, its Python module and OpenCV's headers installed; the library does not.
if(NOT TARGET OpenImageIO::OpenImageIO)
  find_path(OPENIMAGEIO_INCLUDE_DIR OpenImageIO/imageio.h REQUIRED)
  find_library(OPENIMAGEIO_LIBRARY OpenImageIO REQUIRED)
  find_library(OPENIMAGEIO_UTIL_LIBRARY OpenImageIO_Util REQUIRED)
  add_library(OpenImageIO::OpenImageIO UNKNOWN IMPORTED)
  set_target_properties(OpenImageIO::OpenImageIO PROPERTIES IMPORTED_LOCATION ${OPENIMAGEIO_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OPENIMAGEIO_INCLUDE_DIR} INTERFACE_LINK_LIBRARIES ${OPENIMAGEIO_UTIL_LIBRARY})
endif()
find_package(pugixml REQUIRED)
find_package(tinyobjloader REQUIRED)
find_package(ZLIB REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Boost REQUIRED)
find_package(cereal REQUIRED)
# Optional: without it, --streams is for one process and for `metrolux merge`.
find_package(MPI COMPONENTS C QUIET)
