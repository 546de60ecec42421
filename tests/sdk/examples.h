#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinome/image_files.h"
#include "kinome/instruction_set.h"
#include "sdk.h"
#include "support/png.h"

/// Helpers of the tests of the SDK's examples.
namespace kinome::test::examples {

/// Returns the text with one part replaced.
inline std::string replaced(std::string text, const std::string& part, const std::string& by) {
  const size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return at == std::string::npos ? text : text.replace(at, part.size(), by);
}

/// Returns the instruction sets of the libraries in `folder`, each of which must contain `names`.
inline std::vector<std::string> sets_built(const fs::path& folder,
                                           const std::vector<std::string>& names) {
  std::vector<std::string> sets = {
      instruction_set_named("x86-64-v2") ? "x86-64-v2" : to_string(min_instruction_set())};
  for (int i = 2; i < kInstructionSetCount; ++i) {
    const char* set = to_string(static_cast<InstructionSet>(i));
    if (!fs::exists(folder / set)) continue;
    for (const std::string& name : names) EXPECT_TRUE(fs::exists(folder / set / name)) << set;
    sets.emplace_back(set);
  }
  return sets;
}

/// True if the program may use plugins for this set on this machine.
inline bool is_usable(const std::string& set) {
  const auto known = instruction_set_named(set);
  return known && *known >= min_instruction_set() && *known <= processor_instruction_set();
}

}  // namespace kinome::test::examples
