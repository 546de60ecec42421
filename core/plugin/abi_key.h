#pragma once

#include <string>

namespace kinome {

/// Reads the ABI key from the ELF section "kinome_abi" of a shared library, without running any of
/// its code. Throws Error, without location and file name, if that fails.
std::string read_abi_key(const std::string& path);

}  // namespace kinome
