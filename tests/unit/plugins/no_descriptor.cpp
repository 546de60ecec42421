#include "kinome/plugin.h"

/// The right key, but nothing that KINOME_PLUGIN would export beside it.
extern "C" {
__attribute__((section("kinome_abi"), used,
               visibility("default"))) extern const char kinome_plugin_abi_key[] = KINOME_ABI_KEY;
}
