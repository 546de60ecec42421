# A tree that works wherever it is moved: everything finds the rest relative to itself. The folders'
# names are fixed, since the program looks for plugins in ../lib/kinome/plugins.
include(CMakePackageConfigHelpers)
set(kinome_package_dir lib/cmake/kinome)

set_target_properties(kinome PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
install(TARGETS kinome kinome_core EXPORT KinomeTargets
  RUNTIME DESTINATION bin
  LIBRARY DESTINATION lib)
install(DIRECTORY include/kinome DESTINATION include)
# The comparison of pictures: the program looks for its package in ../lib/kinome/python.
install(PROGRAMS "${PROJECT_SOURCE_DIR}/validation/kinome-compare" DESTINATION bin)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/validation/compare" DESTINATION lib/kinome/python
  FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE)
install(EXPORT KinomeTargets NAMESPACE kinome:: DESTINATION "${kinome_package_dir}")

configure_package_config_file(cmake/KinomeConfig.cmake.in KinomeConfig.cmake
  INSTALL_DESTINATION "${kinome_package_dir}")
write_basic_package_version_file(KinomeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  "${CMAKE_CURRENT_BINARY_DIR}/KinomeConfig.cmake"
  "${CMAKE_CURRENT_BINARY_DIR}/KinomeConfigVersion.cmake"
  cmake/KinomePlugin.cmake
  DESTINATION "${kinome_package_dir}")
