#pragma once

/// Exports a symbol from the core library to programs and plugins; all other symbols are hidden.
/// Every interface class needs it, so that its vtable and type information are unique in the
/// process.
#define KINOME_EXPORT __attribute__((visibility("default")))
