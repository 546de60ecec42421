#include "kinome/plugin.h"

/// A library with the right key, but with an undefined symbol.
extern "C" {
void kinome_test_that_nobody_defines();
__attribute__((section("kinome_abi"), used,
               visibility("default"))) extern const char kinome_plugin_abi_key[] = KINOME_ABI_KEY;
__attribute__((visibility("default"))) void kinome_test_call() {
  kinome_test_that_nobody_defines();
}
}
