# Templates of `kinome new`: the examples of tests/sdk/project, each with a scene. They are in
# share/kinome/templates, both in the build folder and in an installation.
set(kinome_templates "${CMAKE_BINARY_DIR}/share/kinome/templates")
configure_file(templates/CMakeLists.txt "${kinome_templates}/CMakeLists.txt" COPYONLY)
foreach(example bsdf/minnaert emitter/sky_gradient film/png integrator/normals medium/mist
        phase/schlick rfilter/hann sampler/golden sensor/fisheye shape/ring texture/waves volume/haze)
  cmake_path(GET example PARENT_PATH category)
  cmake_path(GET example FILENAME name)
  configure_file("${PROJECT_SOURCE_DIR}/tests/sdk/project/${name}.cpp"
                 "${kinome_templates}/${category}/${name}.cpp" COPYONLY)
  configure_file(templates/${category}/scene.xml "${kinome_templates}/${category}/scene.xml" COPYONLY)
endforeach()
install(DIRECTORY "${kinome_templates}" DESTINATION share/kinome COMPONENT dev)
