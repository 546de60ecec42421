#pragma once

#include "kinome/export.h"

namespace kinome {

/// Returns "category/name" of the plugin whose library contains the code at an address, or nullptr.
/// For a plugin with several names, returns the one first loaded. Has no cost while plugins run,
/// because registries record the addresses of libraries, which are never unloaded. Thread-safe and
/// async-signal-safe: no locks, no allocation.
KINOME_EXPORT const char* plugin_at(const void* address) noexcept;

/// Returns the plugin whose library this program is loading (its initialisers may be running), or
/// nullptr. Names are never freed. Thread-safe and async-signal-safe.
KINOME_EXPORT const char* plugin_being_loaded() noexcept;

/// True if the code at an address belongs to the core. Thread-safe and async-signal-safe.
KINOME_EXPORT bool is_core_at(const void* address) noexcept;

}  // namespace kinome
