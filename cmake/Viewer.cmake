# The page of `metrolux study`, put into the program as a string: web/viewer.html, which `make viewer` bundles from web/src with
# node. A build needs no node. Where it is there, the tests bundle the page again and compare.
set(METROLUX_PAGE_SOURCE ${PROJECT_BINARY_DIR}/web/page_template.cpp)
add_custom_command(OUTPUT ${METROLUX_PAGE_SOURCE}
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR}/web/viewer.html -DOUTPUT=${METROLUX_PAGE_SOURCE}
          -P ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake
  DEPENDS ${PROJECT_SOURCE_DIR}/web/viewer.html ${PROJECT_SOURCE_DIR}/cmake/EmbedPage.cmake VERBATIM)

find_program(METROLUX_NODE NAMES node nodejs)
find_program(METROLUX_NPM npm)
if(METROLUX_NODE AND METROLUX_NPM)
  set(bundle ${CMAKE_COMMAND} -DNODE=${METROLUX_NODE} -DNPM=${METROLUX_NPM} -DSOURCE=${PROJECT_SOURCE_DIR}/web
    -DBINARY=${PROJECT_BINARY_DIR}/web)
  file(GLOB_RECURSE web_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/src/* ${PROJECT_SOURCE_DIR}/web/test/*)
  # Its name is none of a file that the command makes: without npm's registry there is none, and the build goes on.
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/web/bundled
    COMMAND ${bundle} -DSEVERITY=WARNING -P ${PROJECT_SOURCE_DIR}/cmake/BundleViewer.cmake
    COMMAND ${CMAKE_COMMAND} -E touch ${PROJECT_BINARY_DIR}/web/bundled
    DEPENDS ${web_sources} ${PROJECT_SOURCE_DIR}/web/build.mjs ${PROJECT_SOURCE_DIR}/web/package.json
            ${PROJECT_SOURCE_DIR}/web/package-lock.json ${PROJECT_SOURCE_DIR}/cmake/BundleViewer.cmake
    COMMENT "Bundling the page of metrolux study" VERBATIM)
  if(METROLUX_TESTS)
    add_custom_target(bundled_page ALL DEPENDS ${PROJECT_BINARY_DIR}/web/bundled)
  endif()
  add_custom_target(viewer COMMAND ${bundle} -DSEVERITY=FATAL_ERROR -P ${PROJECT_SOURCE_DIR}/cmake/BundleViewer.cmake
    COMMAND ${CMAKE_COMMAND} -E copy ${PROJECT_BINARY_DIR}/web/viewer.html ${PROJECT_SOURCE_DIR}/web/viewer.html VERBATIM)
endif()
