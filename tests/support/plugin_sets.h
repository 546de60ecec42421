#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kinome/instruction_set.h"
#include "support/render.h"

/// Plugins of each instruction set that they are built for.
namespace kinome::test {

/// Plugins of no more than an instruction set.
inline PluginRegistry& registry_of(InstructionSet set) {
  static std::map<InstructionSet, PluginRegistry> registries;
  auto folders = PluginRegistry::default_folders();
  folders.push_back(KINOME_TEST_PLUGINS);
  return registries.try_emplace(set, std::move(folders), set).first->second;
}

/// Those that both the plugins and the processor have. The least is this program's, too: the
/// baseline, but where all is compiled for more.
inline std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets{least_instruction_set()};
  for (const InstructionSet set : registry().instruction_sets(Category::kBsdf, "diffuse")) {
    if (set > sets.back() && set <= processor_instruction_set()) sets.push_back(set);
  }
  return sets;
}

/// An object of a plugin from XML; see make.
template <class T>
std::shared_ptr<T> make_for(InstructionSet set, const std::string& xml) {
  return std::dynamic_pointer_cast<T>(
      load_object_from_string(xml, "test.xml", {}, registry_of(set)));
}

/// As a part of a test's name.
inline std::string name_of(InstructionSet set) {
  std::string name = to_string(set);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

}  // namespace kinome::test
