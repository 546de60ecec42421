#pragma once

/// Marks what the core library offers to programs and plugins. Everything else is hidden, so every
/// interface class needs it: its vtable and type information must be one and the same everywhere.
#define KINOME_EXPORT __attribute__((visibility("default")))
