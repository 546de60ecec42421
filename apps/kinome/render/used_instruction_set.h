#pragma once

#include "kinome/plugin_registry.h"
#include "options/options.h"

namespace kinome::app {

/// Returns the best instruction set that a loaded plugin is built for, at most the registry's. The
/// bits of an image depend on it.
InstructionSet used_instruction_set(const PluginRegistry& registry);

/// Warns if --isa or KINOME_ISA requests an instruction set that no loaded plugin is built for.
void warn_of_unused_instruction_set(const Options& options, const PluginRegistry& registry);

}  // namespace kinome::app
