#pragma once

#include <string>

namespace kinome {

/// The ABI key in the ELF section "kinome_abi" of a shared library, read from the file: no code of
/// it runs. Throws Error with what is wrong with the file (no place, no file name).
std::string read_abi_key(const std::string& path);

}  // namespace kinome
