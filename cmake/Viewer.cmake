# The page of `metrolux study`, bundled with node and put into the program as a string. Without node or npm's registry the program
# is built all the same; `metrolux study` then says why it writes no page. `make viewer` tries again.
set(METROLUX_PAGE_SOURCE ${PROJECT_BINARY_DIR}/web/page_template.cpp)
file(GLOB_RECURSE web_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/src/* ${PROJECT_SOURCE_DIR}/web/test/*)
# The programs are named here, so that the page is bundled anew once they are installed.
find_program(METROLUX_NODE NAMES node nodejs)
find_program(METROLUX_NPM npm)
add_custom_command(OUTPUT ${METROLUX_PAGE_SOURCE}
  COMMAND ${CMAKE_COMMAND} -DNODE=${METROLUX_NODE} -DNPM=${METROLUX_NPM}
          -DSOURCE=${PROJECT_SOURCE_DIR}/web -DBINARY=${PROJECT_BINARY_DIR}/web -DOUTPUT=${METROLUX_PAGE_SOURCE} -P ${PROJECT_SOURCE_DIR}/cmake/BundleViewer.cmake
  DEPENDS ${web_sources} ${PROJECT_SOURCE_DIR}/web/build.mjs ${PROJECT_SOURCE_DIR}/web/package.json
          ${PROJECT_SOURCE_DIR}/web/package-lock.json ${PROJECT_SOURCE_DIR}/cmake/BundleViewer.cmake
  COMMENT "Bundling the page of metrolux study" VERBATIM)
