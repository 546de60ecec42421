# kinome_add_plugin(CATEGORY NAME SOURCE... [ALIASES NAME...] [LINK TARGET...])
#
# Builds one plugin as plugins/CATEGORY/NAME.so of the build folder. In-tree and out-of-tree plugins
# are made by this same function: out of tree, that `plugins` is a folder for KINOME_PLUGIN_PATH and
# --plugin-path, and an installed plugin comes to lie beside Kinome's own. CATEGORY is a tag of the
# scene language: bsdf, emitter, film, integrator, rfilter, sampler, sensor, shape or texture. An
# alias is a symbolic link: another name for the same plugin.
function(kinome_add_plugin category name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "ALIASES;LINK")
  set(target kinome_${category}_${name})
  add_library(${target} MODULE ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${target} PRIVATE kinome::core ${arg_LINK})
  if(TARGET kinome_options)
    target_link_libraries(${target} PRIVATE kinome_options)
    target_precompile_headers(${target} REUSE_FROM kinome_headers)
  endif()
  set_target_properties(${target} PROPERTIES
    PREFIX "" OUTPUT_NAME ${name} SUFFIX .so
    CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/plugins/${category}"
    INSTALL_RPATH "$ORIGIN/../../..")
  set(destination "lib/kinome/plugins/${category}")
  install(TARGETS ${target} LIBRARY DESTINATION "${destination}")
  foreach(alias IN LISTS arg_ALIASES)
    add_custom_command(TARGET ${target} POST_BUILD VERBATIM
      COMMAND ${CMAKE_COMMAND} -E create_symlink ${name}.so
              "${CMAKE_BINARY_DIR}/plugins/${category}/${alias}.so")
    install(FILES "${CMAKE_BINARY_DIR}/plugins/${category}/${alias}.so"
            DESTINATION "${destination}")
  endforeach()
  set_property(GLOBAL APPEND PROPERTY KINOME_PLUGIN_TARGETS ${target})
endfunction()
