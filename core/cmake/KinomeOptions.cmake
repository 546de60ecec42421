# Compiler options of everything built in this tree: kinome_options is linked privately by each
# target and is not installed.
add_library(kinome_options INTERFACE)
target_compile_options(kinome_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  # Floats are never trapped on and errno of math functions is never read; neither changes a value.
  -fno-math-errno -fno-trapping-math
  # Products and sums are contracted (FMA) where the code says so, and nowhere else: polynomials and
  # dot products do, in wide numbers. Left to the compiler, whether a determinant, cross product or
  # other difference of two products is exactly 0 depends on the instruction set and on what the
  # compiler makes of it. In files of one instruction set without FMA, it changes nothing.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False alarms on `"literal" + std::string` (GCC bug 105651, mended in 13).
  target_compile_options(kinome_options INTERFACE -Wno-restrict)
endif()
if(KINOME_WERROR)
  target_compile_options(kinome_options INTERFACE -Werror)
endif()
if(KINOME_SANITIZER MATCHES "^(asan|fuzz)$")
  set(flags -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(KINOME_SANITIZER STREQUAL "fuzz")
    list(APPEND flags -fsanitize=fuzzer-no-link)  # clang's alone; tests/fuzz links libFuzzer itself
  endif()
  # Each wide file is compiled but once (see kinome_list_isas): for several lanes, if that can be. Before
  # any target's own options, which may ask for another instruction set.
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
    # Instrumented code confuses it: it then warns of the standard library's <regex>.
    list(APPEND flags -Wno-maybe-uninitialized)
  endif()
  target_compile_options(kinome_options INTERFACE ${flags} -g1)
  target_link_options(kinome_options INTERFACE ${flags})
endif()

set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

# kinome_unite(TARGET): under sanitizers, which are built as a whole and seldom changed in one place,
# several files of a library are compiled as one, in little more than half the time: most of what is
# instrumented are the same templates of the standard library in each.
function(kinome_unite target)
  if(KINOME_SANITIZER)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()
