# Compiler options for all targets of this tree. Each target links kinome_options privately; it is
# not installed.
add_library(kinome_options INTERFACE)
target_compile_options(kinome_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  # No code uses floating-point traps or the errno of math functions. These options don't change any
  # value.
  -fno-math-errno -fno-trapping-math
  # Only explicit code contracts products and sums to FMA: polynomials and dot products of wide
  # numbers. If the compiler contracted them, a difference of two products, such as a determinant or
  # cross product, could be exactly 0 with one instruction set and not with another. The option has
  # no effect without FMA.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False warnings for `"literal" + std::string` (GCC bug 105651, fixed in 13).
  target_compile_options(kinome_options INTERFACE -Wno-restrict)
endif()
if(KINOME_WERROR)
  target_compile_options(kinome_options INTERFACE -Werror)
endif()
if(KINOME_SANITIZER MATCHES "^(asan|fuzz)$")
  set(flags -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(KINOME_SANITIZER STREQUAL "fuzz")
    list(APPEND flags -fsanitize=fuzzer-no-link)  # clang only; tests/fuzz links libFuzzer itself
  endif()
  # Each wide file is compiled only once (see kinome_list_isas): for several lanes, if the machine
  # supports them. The option comes before those of the targets, which can select another
  # instruction set.
  kinome_machine_has(x86-64-v3 has_lanes)
  if(has_lanes)
    string(PREPEND CMAKE_CXX_FLAGS "-march=x86-64-v3 ")
  endif()
elseif(KINOME_SANITIZER STREQUAL "tsan")
  set(flags -fsanitize=thread)
elseif(KINOME_SANITIZER)
  message(FATAL_ERROR
    "KINOME_SANITIZER must be asan, tsan, fuzz or empty, not '${KINOME_SANITIZER}'")
endif()
if(flags)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Instrumented code causes false warnings in the standard library's <regex>.
    list(APPEND flags -Wno-maybe-uninitialized)
  endif()
  target_compile_options(kinome_options INTERFACE ${flags} -g1)
  target_link_options(kinome_options INTERFACE ${flags})
endif()

set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

# kinome_unite(TARGET): compiles several files of a library as one (unity build), which takes about
# half of the time. Files with the property UNITY_GROUP form a unit for each group; without groups,
# eight files do.
function(kinome_unite target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  get_target_property(sources ${target} SOURCES)
  list(GET sources 0 first)
  get_source_file_property(group "${first}" UNITY_GROUP)
  if(group)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  endif()
endfunction()
