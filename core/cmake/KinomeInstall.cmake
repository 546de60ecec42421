# Installs a relocatable tree: all paths are relative. The folders' names are fixed, because the
# program searches for plugins in ../lib/kinome/plugins.
include(CMakePackageConfigHelpers)
set(kinome_package_dir lib/cmake/kinome)

# There are two components: `runtime`, the default, and `dev`, which is needed to build plugins.
set_target_properties(kinome PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
set_target_properties(kinome_kit PROPERTIES INSTALL_RPATH "$ORIGIN")
install(TARGETS kinome kinome_core kinome_headers_path EXPORT KinomeTargets
  RUNTIME DESTINATION bin
  LIBRARY DESTINATION lib NAMELINK_COMPONENT dev)
# Only `kinome check` uses this library, which is for developers of plugins.
install(TARGETS kinome_kit LIBRARY DESTINATION lib COMPONENT dev)
install(TARGETS kinome_openimageio LIBRARY DESTINATION lib)
if(TARGET kinome_mpi)
  set_target_properties(kinome_mpi PROPERTIES INSTALL_RPATH "$ORIGIN")
  install(TARGETS kinome_mpi LIBRARY DESTINATION lib COMPONENT mpi)
endif()
foreach(room core libs/audit libs/denoise libs/image_files libs/lights libs/meshes libs/output_files
    libs/sampling libs/scene_xml libs/editor libs/session libs/spectra)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/${room}/include/kinome" DESTINATION include
    COMPONENT dev)
endforeach()
# The engine of integrators, for integrators of other projects.
kinome_list_isas(suffixes)
list(TRANSFORM suffixes PREPEND _)
foreach(suffix IN LISTS suffixes ITEMS "")
  set_target_properties(kinome_transport${suffix} PROPERTIES EXPORT_NAME transport${suffix})
  target_include_directories(kinome_transport${suffix} PUBLIC $<INSTALL_INTERFACE:include/kinome/engine>)
  install(TARGETS kinome_transport${suffix} EXPORT KinomeTargets
    ARCHIVE DESTINATION lib COMPONENT dev)
endforeach()
install(DIRECTORY "${PROJECT_SOURCE_DIR}/plugins/integrators/transport"
  DESTINATION include/kinome/engine COMPONENT dev FILES_MATCHING PATTERN "*.h")
# The comparison of images. The program searches for its package in ../lib/kinome/python.
install(PROGRAMS "${PROJECT_SOURCE_DIR}/validation/kinome-compare" DESTINATION bin)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/validation/compare" DESTINATION lib/kinome/python
  FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE)
install(EXPORT KinomeTargets NAMESPACE kinome:: DESTINATION "${kinome_package_dir}" COMPONENT dev)

configure_package_config_file("${PROJECT_SOURCE_DIR}/core/cmake/KinomeConfig.cmake.in" KinomeConfig.cmake
  INSTALL_DESTINATION "${kinome_package_dir}")
write_basic_package_version_file(KinomeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  "${CMAKE_CURRENT_BINARY_DIR}/KinomeConfig.cmake"
  "${CMAKE_CURRENT_BINARY_DIR}/KinomeConfigVersion.cmake"
  "${PROJECT_SOURCE_DIR}/core/cmake/KinomeMachine.cmake"
  "${PROJECT_SOURCE_DIR}/core/cmake/KinomePlugin.cmake"
  DESTINATION "${kinome_package_dir}" COMPONENT dev)

# The rest doesn't belong in a Python wheel.
if(SKBUILD)
  return()
endif()

install(FILES "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/kinome-merge" DESTINATION bin)  # a link to kinome

# The program prints its own manual page and completion.
function(kinome_install_page option name folder)
  set(page "${CMAKE_CURRENT_BINARY_DIR}/${name}")
  install(CODE "execute_process(COMMAND \"$<TARGET_FILE:kinome>\" ${option}
    OUTPUT_FILE \"${page}\" COMMAND_ERROR_IS_FATAL ANY)")
  install(FILES "${page}" DESTINATION "${folder}" RENAME kinome${ARGN})
endfunction()
kinome_install_page(--man kinome.1 share/man/man1 .1)
kinome_install_page(--completion completion share/bash-completion/completions)

# Licence and docs keep their relative paths, so that links between them work.
set(documents share/doc/kinome)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" RENAME copyright DESTINATION "${documents}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" RENAME copyright COMPONENT dev
  DESTINATION "${documents}-dev")
file(GLOB pages RELATIVE "${PROJECT_SOURCE_DIR}"
  "${PROJECT_SOURCE_DIR}/*.md" "${PROJECT_SOURCE_DIR}/docs/*.md" "${PROJECT_SOURCE_DIR}/docs/*.jpg")
foreach(page IN LISTS pages ITEMS LICENSE CITATION.cff scenes/README.md scenes/hebe/hebe.png
    scenes/farm/parts.slurm scenes/farm/parts.sh scenes/farm/parts_dask.py
    plugins/integrators/transport/ENGINE.md plugins/integrators/clustered/CLUSTERED.md
    plugins/integrators/clustered/PRODUCT.md)
  get_filename_component(folder "${page}" DIRECTORY)
  install(FILES "${PROJECT_SOURCE_DIR}/${page}" DESTINATION "${documents}/${folder}")
endforeach()
install(DIRECTORY "${PROJECT_SOURCE_DIR}/plugins/integrators/clustered/pictures"
  DESTINATION "${documents}/plugins/integrators/clustered")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/tests/sdk/project"
  DESTINATION "${documents}-dev/tests/sdk" COMPONENT dev)
