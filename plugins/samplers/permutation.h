#pragma once

#include <bit>
#include <cstdint>

namespace kinome {

/// Where `i` < count goes in a random permutation that `key` names, without a table: a bijection of
/// the next power of two, walked until it lands below count again, then a random rotation, which
/// makes every place exactly as likely as any other.
inline uint32_t permute(uint32_t i, uint32_t count, uint64_t key) {
  if (count < 2) return 0;
  const int bits = std::bit_width(count - 1);
  const uint32_t mask = bits == 32 ? ~0u : (1u << bits) - 1;
  const int half = (bits + 1) / 2;
  uint64_t k = key;
  do {
    k = key;
    for (int round = 0; round < 4; ++round) {
      // Each step is a bijection modulo 2^bits: add, multiply by an odd number, fold down the top.
      i = (i + static_cast<uint32_t>(k)) & mask;
      i = (i * (static_cast<uint32_t>(k >> 32) | 1)) & mask;
      i ^= i >> half;
      k = k * 0xd1342543de82ef95u + 0x9e3779b97f4a7c15u;
    }
  } while (i >= count);
  const auto rotation = static_cast<uint32_t>((k >> 32) * count >> 32);
  return i >= count - rotation ? i - (count - rotation) : i + rotation;
}

}  // namespace kinome
