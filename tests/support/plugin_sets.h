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

/// Returns the registry whose plugins use at most this instruction set.
inline PluginRegistry& registry_of(InstructionSet set) {
  static std::map<InstructionSet, PluginRegistry> registries;
  auto folders = PluginRegistry::default_folders();
  folders.push_back(KINOME_TEST_PLUGINS);
  return registries.try_emplace(set, std::move(folders), set).first->second;
}

/// Returns the instruction sets that both the plugins and the processor support. The first is that
/// of this program: the baseline, unless everything is compiled for a larger set.
inline std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets{min_instruction_set()};
  for (const InstructionSet set : registry().instruction_sets(Category::kBsdf, "diffuse")) {
    if (set > sets.back() && set <= processor_instruction_set()) sets.push_back(set);
  }
  return sets;
}

/// Loads an object of a plugin from XML, like make().
template <class T>
std::shared_ptr<T> make_for(InstructionSet set, const std::string& xml) {
  return std::dynamic_pointer_cast<T>(
      load_object_from_string(xml, "test.xml", {}, registry_of(set)));
}

/// Returns the name of an instruction set as part of a test's name.
inline std::string name_of(InstructionSet set) {
  std::string name = to_string(set);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

}  // namespace kinome::test
