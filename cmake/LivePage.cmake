# The page of `metrolux view`: the files of web/view, and the parts that it shares with the page of `metrolux study`, are put into
# the program as they are. Browsers load them one by one, and nothing has to be bundled.
set(METROLUX_LIVE_PAGE_SOURCE ${PROJECT_BINARY_DIR}/web/live_page.cpp)
file(GLOB live_page_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/view/*)
list(APPEND live_page_files ${PROJECT_SOURCE_DIR}/web/src/color.js ${PROJECT_SOURCE_DIR}/web/src/pixels.js)
add_custom_command(OUTPUT ${METROLUX_LIVE_PAGE_SOURCE}
  COMMAND ${CMAKE_COMMAND} "-DFILES=${live_page_files}" -DOUTPUT=${METROLUX_LIVE_PAGE_SOURCE}
          -P ${PROJECT_SOURCE_DIR}/cmake/EmbedFiles.cmake
  DEPENDS ${live_page_files} ${PROJECT_SOURCE_DIR}/cmake/EmbedFiles.cmake ${PROJECT_SOURCE_DIR}/cmake/Bytes.cmake
  COMMENT "Embedding the page of metrolux view" VERBATIM)
