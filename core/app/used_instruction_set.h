#pragma once

#include "kinome/plugin_registry.h"
#include "options.h"

namespace kinome::app {

/// The best instruction set that the loaded plugins were taken for: no better than the registry's,
/// and lesser where none is built for that. The bits of a picture depend on it.
InstructionSet used_instruction_set(const PluginRegistry& registry);

/// A warning where --isa or KINOME_ISA asks for a set that no loaded plugin is built for.
void warn_of_unused_instruction_set(const Options& options, const PluginRegistry& registry);

}  // namespace kinome::app
