#include "kinome/plugin.h"

/// A library with the right key, but without the other symbols of KINOME_PLUGIN.
extern "C" {
__attribute__((section("kinome_abi"), used,
               visibility("default"))) extern const char kinome_plugin_abi_key[] = KINOME_ABI_KEY;
}
