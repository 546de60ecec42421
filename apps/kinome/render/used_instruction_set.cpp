#include "render/used_instruction_set.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "kinome/log.h"

namespace kinome::app {

InstructionSet used_instruction_set(const PluginRegistry& registry) {
  InstructionSet best = least_instruction_set();
  for (const Category category : kCategories) {
    const std::string prefix = std::string(to_string(category)) + "/";
    for (const std::string& name : registry.loaded()) {
      if (!name.starts_with(prefix)) continue;
      for (const auto set : registry.instruction_sets(category, name.substr(prefix.size()))) {
        if (set <= registry.instruction_set()) best = std::max(best, set);
      }
    }
  }
  return best;
}

void warn_of_unused_instruction_set(const Options& options, const PluginRegistry& registry) {
  const char* const variable = std::getenv("KINOME_ISA");
  if (options.isa.empty() && (!variable || !*variable)) return;
  const InstructionSet used = used_instruction_set(registry);
  if (used == registry.instruction_set()) return;
  log_warn(fmt::format("{} {}: no plugin of this scene is built for it; using those for {}",
                       options.isa.empty() ? "KINOME_ISA" : "--isa",
                       to_string(registry.instruction_set()), to_string(used)));
}

}  // namespace kinome::app
