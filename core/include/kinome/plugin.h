#pragma once

#include <concepts>
#include <memory>
#include <span>

#include "kinome/export.h"
#include "kinome/instruction_set.h"
#include "kinome/object.h"
#include "kinome/parameter.h"
#include "kinome/properties.h"

/// Version of the public headers. Incremented when a change makes existing plugin binaries
/// incompatible.
#define KINOME_INTERFACE_VERSION 28

#define KINOME_STRINGIFY_(x) #x
#define KINOME_STRINGIFY(x) KINOME_STRINGIFY_(x)
#if defined(__SANITIZE_ADDRESS__)
#define KINOME_ABI_SANITIZER "asan"
#elif defined(__SANITIZE_THREAD__)
#define KINOME_ABI_SANITIZER "tsan"
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define KINOME_ABI_SANITIZER "asan"
#elif __has_feature(thread_sanitizer)
#define KINOME_ABI_SANITIZER "tsan"
#else
#define KINOME_ABI_SANITIZER "none"
#endif
#else
#define KINOME_ABI_SANITIZER "none"
#endif
#if defined(_GLIBCXX_USE_CXX11_ABI)
#define KINOME_ABI_STDLIB "libstdc++-cxx11=" KINOME_STRINGIFY(_GLIBCXX_USE_CXX11_ABI)
#elif defined(_LIBCPP_VERSION)
#define KINOME_ABI_STDLIB "libc++"
#else
#define KINOME_ABI_STDLIB "unknown"
#endif

#if defined(_GLIBCXX_DEBUG)
#define KINOME_ABI_CONTAINERS "debug"
#else
#define KINOME_ABI_CONTAINERS "plain"
#endif
#if defined(GLM_FORCE_DEFAULT_ALIGNED_GENTYPES)
#define KINOME_ABI_GLM "aligned"
#else
#define KINOME_ABI_GLM "packed"
#endif
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#define KINOME_ABI_MATH "fast"
#else
#define KINOME_ABI_MATH "strict"
#endif

/// Properties of the build that a plugin and the core must share, as one string. GLM's options
/// matter because Vec3 is part of every interface, and the library's debug mode because std::vector
/// is. Fast math matters because inline functions of the SDK would not detect NaN, and because
/// loading a library linked with it makes the whole program flush denormals. The instruction set
/// may differ, but the processor must support it.
#define KINOME_ABI_KEY \
  "kinome-abi;interface=" KINOME_STRINGIFY(KINOME_INTERFACE_VERSION) ";cxxabi="          \
      KINOME_STRINGIFY(__GXX_ABI_VERSION) ";stdlib=" KINOME_ABI_STDLIB ";sanitizer="     \
      KINOME_ABI_SANITIZER ";glm=" KINOME_STRINGIFY(GLM_VERSION_MAJOR) "."               \
      KINOME_STRINGIFY(GLM_VERSION_MINOR) "." KINOME_STRINGIFY(GLM_VERSION_PATCH) "-"    \
      KINOME_ABI_GLM ";containers=" KINOME_ABI_CONTAINERS ";math=" KINOME_ABI_MATH       \
      ";isa=" KINOME_ABI_ISA ";"

namespace kinome {

/// Description of a plugin; a plugin library exports one under the name `kinome_plugin`.
struct PluginDescriptor {
  Category category;
  const char* name;
  const char* doc;  ///< documentation in one or two sentences
  std::span<const Parameter> parameters;
  std::shared_ptr<Object> (*create)(const Properties&);
};

}  // namespace kinome

/// Defines `Class` as plugin `plugin_name`. Use it once per library, at namespace scope of its only
/// source file. `Class`, in an anonymous namespace, has a constructor from const Properties&;
/// `parameter_table` is an array of Parameter.
///
/// The ABI key is in an ELF section of its own. The registry reads it from the file before any code
/// of the library runs, static constructors included.
#define KINOME_PLUGIN(Class, plugin_category, plugin_name, documentation, parameter_table) \
  extern "C" {                                                                             \
  __attribute__((section("kinome_abi"), used,                                              \
                 visibility("default"))) extern const char kinome_plugin_abi_key[] =       \
      KINOME_ABI_KEY;                                                                      \
  KINOME_EXPORT extern const ::kinome::PluginDescriptor kinome_plugin;                     \
  const ::kinome::PluginDescriptor kinome_plugin{                                          \
      plugin_category, plugin_name, documentation, parameter_table,                        \
      [](const ::kinome::Properties& props) -> std::shared_ptr<::kinome::Object> {         \
        return std::make_shared<Class>(props);                                             \
      }};                                                                                  \
  }                                                                                        \
  static_assert(true)
