# Debian packages, made by `cpack -G DEB` in the build folder: kinome, the program with its plugins,
# and kinome-dev, which is needed to build plugins.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kinome)
set(CPACK_PACKAGE_CONTACT "The Kinome authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip)

# dpkg-shlibdeps finds the libraries' dependencies. PRIVATE_DIRS contains our own libraries.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME kinome)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_BINARY_DIR}/lib")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS
  "python3-numpy, python3-scipy, python3-openimageio, python3-matplotlib")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
  "Reads scenes of Mitsuba 3. Every material, light, camera and algorithm is a plugin.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME kinome-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "kinome (= ${PROJECT_VERSION}), libglm-dev, libhwy-dev, cmake (>= 3.22)")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers, CMake package and examples for plugins of Kinome.")
# MPI has a package of its own, because it is large and few users need it.
if(TARGET kinome_mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_NAME kinome-mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "kinome (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_MPI_DESCRIPTION "Renders one image with several processes, using MPI.")
endif()
include(CPack)
