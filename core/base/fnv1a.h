#pragma once

#include <cstddef>
#include <cstdint>

namespace kinome {

/// 64-bit FNV-1a hash; not cryptographic. Changing a single byte always changes the hash.
class Fnv1a {
 public:
  void add(const void* bytes, size_t count) {
    const auto* const from = static_cast<const unsigned char*>(bytes);
    for (size_t i = 0; i < count; ++i) state_ = (state_ ^ from[i]) * 0x100000001b3u;
  }
  uint64_t value() const { return state_; }

 private:
  uint64_t state_ = 0xcbf29ce484222325u;
};

}  // namespace kinome
