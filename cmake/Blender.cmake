# The Blender add-on as the zip file that Blender installs: build/metrolux-blender.zip.
file(GLOB_RECURSE METROLUX_ADDON_FILES CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/blender
  ${PROJECT_SOURCE_DIR}/blender/metrolux/*.py ${PROJECT_SOURCE_DIR}/blender/metrolux/*.json)
list(TRANSFORM METROLUX_ADDON_FILES PREPEND ${PROJECT_SOURCE_DIR}/blender/ OUTPUT_VARIABLE addon_paths)
set(addon_zip ${PROJECT_BINARY_DIR}/metrolux-blender.zip)
add_custom_command(OUTPUT ${addon_zip}
  COMMAND ${CMAKE_COMMAND} -E tar cf ${addon_zip} --format=zip -- ${METROLUX_ADDON_FILES}
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/blender DEPENDS ${addon_paths} VERBATIM)
add_custom_target(blender_addon ALL DEPENDS ${addon_zip})
