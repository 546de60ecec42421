#include <stdexcept>

#include "fuzz.h"

/// Reads a whole scene, which has no other files to include or read.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace kinome;
  const std::string xml(reinterpret_cast<const char*>(data), size);
  LoadOptions options;
  options.threads = 1;
  try {
    load_scene_from_string(xml, "fuzz.xml", options, fuzz::registry());
  } catch (const Error& error) {
    const std::string what = fuzz::refusal = error.what();
    if (what.find('\n') != std::string::npos) throw std::logic_error("an error of two lines");
    if (error.where().file.empty()) throw std::logic_error("an error without a place: " + what);
  }
  return 0;
}
