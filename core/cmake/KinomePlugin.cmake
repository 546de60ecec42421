# kinome_add_plugin(CATEGORY NAME SOURCE... [WIDE] [ALIASES NAME...] [LINK TARGET...])
#
# Builds one plugin as plugins/CATEGORY/NAME.so of the build folder. In-tree and out-of-tree plugins
# are made by this same function: out of tree, that `plugins` is a folder for KINOME_PLUGIN_PATH and
# --plugin-path, and an installed plugin comes to lie beside Kinome's own. CATEGORY is a tag of the
# scene language: bsdf, emitter, film, integrator, rfilter, sampler, sensor, shape or texture. An
# alias is a symbolic link: another name for the same plugin.
#
# WIDE is for plugins that compute with the numbers of kinome/wide. Their sources are built once for
# KINOME_BASELINE, and once more for each instruction set of KINOME_ISAS that the compiler knows, as
# plugins/CATEGORY/ISA/NAME.so. The program loads the best one that the processor has.
#
# A WIDE integrator may LINK kinome::transport: the stages over blocks of samples that Kinome's own
# integrators use.
include("${CMAKE_CURRENT_LIST_DIR}/KinomeMachine.cmake")
set(KINOME_ISAS "auto" CACHE STRING
  "auto: build everything once, for this machine's processor. Or a list of the instruction sets that wide plugins are built for in addition to KINOME_BASELINE, for programs that run on other machines: x86-64-v2, -v3, -v4")
# x86-64-v2 has vectors of four numbers. With fewer, Highway has one lane, and plugins take four to eight
# times as long as with AVX-512.
set(KINOME_BASELINE "auto" CACHE STRING
  "Minimum instruction set: x86-64, or x86-64-v2 to -v4. auto: the best of this machine if KINOME_ISAS is auto, else x86-64-v2. Ignored if CMAKE_CXX_FLAGS has -march")
include(CheckCXXCompilerFlag)
# kinome_compiler_knows(ISA RESULT): compilers for other processors know none of them.
function(kinome_compiler_knows isa result)
  string(MAKE_C_IDENTIFIER "KINOME_COMPILER_KNOWS_${isa}" knows)
  check_cxx_compiler_flag("-march=${isa}" ${knows})
  set(${result} ${${knows}} PARENT_SCOPE)
endfunction()

# The minimum instruction set as kinome_baseline, and the additional ones as kinome_isas.
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
  kinome_compiler_knows(${isa} known)
endforeach()
set(kinome_baseline ${KINOME_BASELINE})
if(KINOME_BASELINE STREQUAL "auto")
  set(kinome_baseline x86-64-v2)
  if(KINOME_ISAS STREQUAL "auto" AND NOT KINOME_SANITIZER)
    foreach(isa IN ITEMS x86-64-v3 x86-64-v4)
      kinome_machine_has(${isa} has)
      kinome_compiler_knows(${isa} known)
      if(has AND known)
        set(kinome_baseline ${isa})
      endif()
    endforeach()
  endif()
endif()

# kinome_baseline_option(RESULT): the compiler's option for kinome_baseline. Empty if it knows none, or if
# CMAKE_CXX_FLAGS has one.
function(kinome_baseline_option result)
  set(${result} "" PARENT_SCOPE)
  kinome_compiler_knows(${kinome_baseline} known)
  if(known AND NOT CMAKE_CXX_FLAGS MATCHES "-march=")
    set(${result} "-march=${kinome_baseline}" PARENT_SCOPE)
  endif()
endfunction()

# The additional instruction sets that the compiler knows.
function(kinome_list_known_isas result)
  set(isas)
  foreach(isa IN LISTS kinome_isas)
    string(MAKE_C_IDENTIFIER "KINOME_COMPILER_KNOWS_${isa}" knows)
    if(${knows})
      list(APPEND isas ${isa})
    endif()
  endforeach()
  set(${result} "${isas}" PARENT_SCOPE)
endfunction()
# The instruction sets, beside the baseline, that wide plugins are built for. Under sanitizers none:
# what these find doesn't depend on them.
function(kinome_list_isas result)
  set(isas)
  if(NOT KINOME_SANITIZER)
    kinome_list_known_isas(isas)
  endif()
  set(${result} "${isas}" PARENT_SCOPE)
endfunction()

# Highway, which kinome/wide is made of, as hwy::hwy.
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

# What wide plugins' files include, compiled once for each instruction set (`isa` is empty for the
# baseline). In this tree only.
function(kinome_reuse_wide_headers target isa)
  set(headers kinome_wide_headers)
  if(isa)
    string(APPEND headers "_${isa}")
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
  if((isa OR kinome_baseline MATCHES "v[34]$") AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # False alarms: intrinsics of AVX and AVX-512 make undefined values on purpose, and GCC forgets
    # the pragmas about this that precompiled headers contain.
    target_compile_options(${target} PRIVATE -Wno-uninitialized -Wno-maybe-uninitialized)
  endif()
endfunction()

# kinome_add_wide_parts(NAME SOURCE... [INCLUDE FOLDER] [LINK NAME] [USES TARGET] [UNITE])
#
# A library that several wide plugins LINK, compiled once for each instruction set. Its headers are
# included relative to FOLDER. LINK: another such library that it needs. USES: any other target.
# UNITE: see kinome_unite. In this tree only.
function(kinome_add_wide_parts name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "UNITE" "INCLUDE;LINK;USES" "")
  kinome_find_highway()
  kinome_list_isas(isas)
  foreach(isa IN LISTS isas ITEMS baseline)
    set(suffix "_${isa}")
    if(isa STREQUAL baseline)
      set(isa)
      set(suffix)
    endif()
    set(target ${name}${suffix})
    add_library(${target} STATIC ${arg_UNPARSED_ARGUMENTS})
    if(isa)
      target_compile_options(${target} PRIVATE -march=${isa})
    endif()
    target_link_libraries(${target} PUBLIC kinome::core hwy::hwy
      PRIVATE $<BUILD_INTERFACE:kinome_options>)
    if(arg_LINK)
      target_link_libraries(${target} PUBLIC ${arg_LINK}${suffix})
    endif()
    if(arg_USES)
      target_link_libraries(${target} PUBLIC ${arg_USES})
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
  if(category STREQUAL "emitter" AND TARGET kinome_lights_headers)
    target_link_libraries(${target} PRIVATE kinome_lights_headers)  # in this tree; else in kinome::core
  endif()
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
    # Out of tree: that library exists only for some instruction sets.
    set(kinome_baseline ${kinome_sdk_baseline})
    foreach(isa IN LISTS isas)
      if(NOT TARGET kinome::transport_${isa})
        list(REMOVE_ITEM isas ${isa})
      endif()
    endforeach()
  endif()
  kinome_add_plugin_library(${target} ${category} ${name} "" "${arg_UNPARSED_ARGUMENTS}"
                            "${arg_LINK}" "${arg_ALIASES}")
  # Libraries of other instruction sets are found before the baseline's. So they are never older, and
  # what another configuration left is gone, also from where it was installed.
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

# The instruction sets of kinome_list_isas that this machine has, in their order.
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
