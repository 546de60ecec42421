#include <cstdio>
#include <cstdlib>

/// A library with another ABI key. As soon as any of its code runs, it creates the file that
/// KINOME_TEST_TRACE names.
namespace {

const bool kTrace = [] {
  const char* path = std::getenv("KINOME_TEST_TRACE");
  std::FILE* file = path ? std::fopen(path, "w") : nullptr;
  if (file) std::fclose(file);
  return file != nullptr;
}();

}  // namespace

extern "C" {
__attribute__((section("kinome_abi"), used,
               visibility("default"))) extern const char kinome_plugin_abi_key[] =
    "kinome-abi;interface=0;another;";
extern const bool* kinome_plugin;
__attribute__((visibility("default"))) const bool* kinome_plugin = &kTrace;
}
