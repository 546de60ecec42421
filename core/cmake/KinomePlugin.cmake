# kinome_add_plugin(CATEGORY NAME SOURCE... [WIDE] [ALIASES NAME...] [LINK TARGET...])
#
# Builds one plugin as plugins/CATEGORY/NAME.so in the build folder, in this tree and out of it. Out of
# tree, the folder `plugins` can be passed to KINOME_PLUGIN_PATH and --plugin-path, and installation
# puts the plugin beside Kinome's own. CATEGORY is a tag of the scene language: bsdf, emitter, film,
# integrator, medium, phase, rfilter, sampler, sensor, shape, texture or volume. An alias is a symbolic link: another name
# for the same plugin.
#
# WIDE is for plugins that use the SIMD types of kinome/wide. Their sources are built once for
# KINOME_BASELINE. They are also built for each instruction set of KINOME_ISAS that the compiler
# supports, as plugins/CATEGORY/ISA/NAME.so. The program loads the best one that the processor
# supports.
#
# A WIDE integrator may LINK kinome::transport, which has the stages over blocks of samples of Kinome's
# own integrators.
include("${CMAKE_CURRENT_LIST_DIR}/KinomeMachine.cmake")
set(KINOME_ISAS "auto" CACHE STRING
  "auto: build everything once, for this machine's processor. Or a list of the instruction sets that wide plugins are built for in addition to KINOME_BASELINE, for programs that run on other machines: x86-64-v2, -v3, -v4")
# x86-64-v2 has vectors of four floats. With x86-64, Highway uses a single lane, and plugins take four
# to eight times as long as with AVX-512.
set(KINOME_BASELINE "auto" CACHE STRING
  "Minimum instruction set: x86-64, or x86-64-v2 to -v4. auto: the best of this machine if KINOME_ISAS is auto, else x86-64-v2. Ignored if CMAKE_CXX_FLAGS has -march")
include(CheckCXXCompilerFlag)
# kinome_compiler_knows(ISA RESULT): whether the compiler supports -march=ISA. Compilers for other
# processors don't.
function(kinome_compiler_knows isa result)
  string(MAKE_C_IDENTIFIER "KINOME_COMPILER_KNOWS_${isa}" knows)
  check_cxx_compiler_flag("-march=${isa}" ${knows})
  set(${result} ${${knows}} PARENT_SCOPE)
endfunction()

# Sets kinome_baseline to the minimum instruction set, and kinome_isas to the additional ones.
if(KINOME_ISAS STREQUAL "auto")
  set(kinome_isas)
else()
  set(kinome_isas ${KINOME_ISAS})
endif()
foreach(isa IN LISTS kinome_isas)
  if(NOT isa MATCHES "^x86-64-v[234]$")
    message(FATAL_ERROR "KINOME_ISAS: unknown instruction set '${isa}' (available: x86-64-v2, "
                        "x86-64-v3, x86-64-v4, or auto alone)")
  endif()
  kinome_compiler_knows(${isa} kinome_known)
endforeach()
if(NOT "${KINOME_BASELINE}" MATCHES "^(auto|x86-64(-v[234])?)$")
  message(FATAL_ERROR "KINOME_BASELINE: unknown instruction set '${KINOME_BASELINE}' (available: "
                      "x86-64, x86-64-v2, x86-64-v3, x86-64-v4, or auto)")
endif()
set(kinome_baseline ${KINOME_BASELINE})
if(KINOME_BASELINE STREQUAL "auto")
  set(kinome_baseline x86-64-v2)
  if(KINOME_ISAS STREQUAL "auto" AND NOT KINOME_SANITIZER AND NOT CMAKE_CROSSCOMPILING)
    foreach(isa IN ITEMS x86-64-v3 x86-64-v4)
      kinome_machine_has(${isa} kinome_has)
      kinome_compiler_knows(${isa} kinome_known)
      if(kinome_has AND kinome_known)
        set(kinome_baseline ${isa})
      endif()
    endforeach()
  endif()
endif()

# kinome_baseline_option(RESULT): the compiler option for kinome_baseline. Empty if the compiler doesn't
# support it, or if CMAKE_CXX_FLAGS has -march.
function(kinome_baseline_option result)
  set(${result} "" PARENT_SCOPE)
  kinome_compiler_knows(${kinome_baseline} known)
  if(known AND NOT CMAKE_CXX_FLAGS MATCHES "-march=")
    set(${result} "-march=${kinome_baseline}" PARENT_SCOPE)
  endif()
endfunction()

# kinome_list_isas(RESULT): the instruction sets for which wide plugins are built in addition to the
# baseline: those that the compiler supports. The list is empty with sanitizers, because their findings
# don't depend on the instruction set.
function(kinome_list_isas result)
  set(isas)
  foreach(isa IN LISTS kinome_isas)
    string(MAKE_C_IDENTIFIER "KINOME_COMPILER_KNOWS_${isa}" knows)
    if(${knows} AND NOT KINOME_SANITIZER)
      list(APPEND isas ${isa})
    endif()
  endforeach()
  set(${result} "${isas}" PARENT_SCOPE)
endfunction()

# Finds Highway, on which kinome/wide is based, as hwy::hwy.
macro(kinome_find_highway)
  if(NOT TARGET hwy::hwy)
    find_package(hwy QUIET)
    if(TARGET hwy::hwy)
      set_target_properties(hwy::hwy PROPERTIES IMPORTED_GLOBAL ON)
    else()
      find_package(PkgConfig REQUIRED)
      pkg_check_modules(hwy REQUIRED IMPORTED_TARGET GLOBAL libhwy)
      add_library(hwy::hwy ALIAS PkgConfig::hwy)
    endif()
  endif()
endmacro()

# Reuses the precompiled headers of wide plugins for an instruction set (`isa` is empty for the
# baseline). For this tree only.
function(kinome_reuse_wide_headers target isa)
  set(headers kinome_wide_headers)
  if(isa)
    string(APPEND headers "_${isa}")
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
  if((isa OR kinome_baseline MATCHES "v[34]$") AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # False warnings: intrinsics of AVX and AVX-512 intentionally create undefined values, and GCC
    # ignores the pragmas about this that precompiled headers contain.
    target_compile_options(${target} PRIVATE -Wno-uninitialized -Wno-maybe-uninitialized)
  endif()
endfunction()

# kinome_add_wide_parts(NAME SOURCE... [INCLUDE FOLDER] [LINK NAME] [USES TARGET] [UNITE])
#
# Adds a static library that several wide plugins LINK, compiled once for each instruction set. Its
# headers are included relative to FOLDER. LINK: another such library that it needs. USES: any other
# target that it needs. UNITE: calls kinome_unite. For this tree only.
function(kinome_add_wide_parts name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "UNITE" "INCLUDE;LINK;USES" "")
  kinome_find_highway()
  kinome_list_isas(isas)
  foreach(isa IN LISTS isas ITEMS "")  # "" is the baseline
    set(suffix)
    if(isa)
      set(suffix "_${isa}")
    endif()
    set(target ${name}${suffix})
    add_library(${target} STATIC ${arg_UNPARSED_ARGUMENTS})
    if(isa)
      target_compile_options(${target} PRIVATE -march=${isa})
    endif()
    target_link_libraries(${target} PUBLIC kinome::core hwy::hwy ${arg_USES}
      PRIVATE $<BUILD_INTERFACE:kinome_options>)
    if(arg_LINK)
      target_link_libraries(${target} PUBLIC ${arg_LINK}${suffix})
    endif()
    if(arg_INCLUDE)
      get_filename_component(folder "${arg_INCLUDE}" ABSOLUTE)
      target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${folder}>)
    endif()
    kinome_reuse_wide_headers(${target} "${isa}")
    if(arg_UNITE)
      kinome_unite(${target})
    endif()
  endforeach()
endfunction()

# Builds one library. `isa` is empty for the baseline.
function(kinome_add_plugin_library target category name isa sources link aliases)
  add_library(${target} MODULE ${sources})
  foreach(part IN LISTS link)
    if(isa AND TARGET ${part}_${isa})
      string(APPEND part "_${isa}")
    endif()
    target_link_libraries(${target} PRIVATE ${part})
  endforeach()
  target_link_libraries(${target} PRIVATE kinome::core)
  # The rooms of libs/ that a category may use, in this tree. Elsewhere, kinome::core has all headers.
  set(rooms_emitter lights image_files)
  set(rooms_film image_files)
  set(rooms_shape meshes)
  set(rooms_texture image_files meshes spectra)
  foreach(room IN LISTS rooms_${category} ITEMS sampling)
    if(TARGET kinome_${room}_headers)
      target_link_libraries(${target} PRIVATE kinome_${room}_headers)
    endif()
  endforeach()
  set(folder "${category}")
  set(up "../../..")
  if(isa)
    target_compile_options(${target} PRIVATE -march=${isa})
    string(APPEND folder "/${isa}")
    string(APPEND up "/..")
  elseif("hwy::hwy" IN_LIST link)
    kinome_baseline_option(option)
    target_compile_options(${target} PRIVATE ${option})
  endif()
  if(TARGET kinome_options)
    target_link_libraries(${target} PRIVATE kinome_options)
    if("hwy::hwy" IN_LIST link)
      kinome_reuse_wide_headers(${target} "${isa}")
    else()
      target_precompile_headers(${target} REUSE_FROM kinome_headers)
    endif()
  else()
    target_compile_options(${target} PRIVATE -ffp-contract=off)  # see kinome_options
  endif()
  set(place "${CMAKE_BINARY_DIR}/plugins/${folder}")
  set_target_properties(${target} PROPERTIES
    PREFIX "" OUTPUT_NAME ${name} SUFFIX .so
    CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LIBRARY_OUTPUT_DIRECTORY "${place}"
    INSTALL_RPATH "$ORIGIN/${up}")
  install(TARGETS ${target} LIBRARY DESTINATION "lib/kinome/plugins/${folder}")
  foreach(alias IN LISTS aliases)
    add_custom_command(TARGET ${target} POST_BUILD VERBATIM
      COMMAND ${CMAKE_COMMAND} -E create_symlink ${name}.so "${place}/${alias}.so")
    install(FILES "${place}/${alias}.so" DESTINATION "lib/kinome/plugins/${folder}")
  endforeach()
  set_property(GLOBAL APPEND PROPERTY KINOME_PLUGIN_TARGETS ${target})
endfunction()

function(kinome_add_plugin category name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "WIDE" "" "ALIASES;LINK")
  set(target kinome_${category}_${name})
  set(isas)
  if(arg_WIDE)
    kinome_find_highway()
    list(APPEND arg_LINK hwy::hwy)
    kinome_list_isas(isas)
  endif()
  if("kinome::transport" IN_LIST arg_LINK AND DEFINED kinome_sdk_baseline)
    # Out of tree, kinome::transport exists only for the instruction sets of the installed Kinome.
    if(KINOME_ISAS STREQUAL "auto" AND NOT kinome_baseline STREQUAL kinome_sdk_baseline)
      list(APPEND isas ${kinome_baseline})
    endif()
    set(kinome_baseline ${kinome_sdk_baseline})
    foreach(isa IN LISTS isas)
      if(NOT TARGET kinome::transport_${isa})
        list(REMOVE_ITEM isas ${isa})
      endif()
    endforeach()
  endif()
  kinome_add_plugin_library(${target} ${category} ${name} "" "${arg_UNPARSED_ARGUMENTS}"
                            "${arg_LINK}" "${arg_ALIASES}")
  # The program prefers libraries of other instruction sets to the baseline's. So they must never be
  # older than it: libraries that another configuration has built or installed are removed.
  foreach(isa IN ITEMS x86-64-v2 x86-64-v3 x86-64-v4)
    if(isa IN_LIST isas)
      kinome_add_plugin_library(${target}_${isa} ${category} ${name} ${isa}
                                "${arg_UNPARSED_ARGUMENTS}" "${arg_LINK}" "${arg_ALIASES}")
      add_dependencies(${target} ${target}_${isa})
    else()
      foreach(file IN LISTS name arg_ALIASES)
        set(left "plugins/${category}/${isa}/${file}.so")
        file(REMOVE "${CMAKE_BINARY_DIR}/${left}")
        install(CODE "file(REMOVE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/kinome/${left}\")")
      endforeach()
    endif()
  endforeach()
endfunction()

# kinome_list_machine_isas(RESULT): the instruction sets of kinome_list_isas that this machine supports,
# in the same order.
function(kinome_list_machine_isas result)
  kinome_list_isas(isas)
  set(found)
  foreach(isa IN LISTS isas)
    kinome_machine_has(${isa} has_isa)
    if(has_isa)
      list(APPEND found ${isa})
    endif()
  endforeach()
  set(${result} "${found}" PARENT_SCOPE)
endfunction()
