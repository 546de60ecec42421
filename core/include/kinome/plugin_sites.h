#pragma once

#include "kinome/export.h"

namespace kinome {

/// "category/name" of the plugin whose library holds the code at an address, or nullptr. Of a
/// plugin that is known by several names, the first that was asked for. Costs nothing while plugins
/// run: registries note where they load libraries, which are never unloaded. Thread-safe, and safe
/// in signal handlers: no locks, no allocation.
KINOME_EXPORT const char* plugin_at(const void* address) noexcept;

/// The plugin whose library is being loaded by this program now (its initialisers may be at work),
/// or nullptr. Names are never freed. As safe as plugin_at().
KINOME_EXPORT const char* plugin_being_loaded() noexcept;

/// Whether the code at an address is the core's own. As safe as plugin_at().
KINOME_EXPORT bool is_core_at(const void* address) noexcept;

}  // namespace kinome
