#pragma once

#include <cstdint>
#include <span>

#include "kinome/columns.h"
#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Like for_lanes, over the values of the given blocks of kBlockLanes values.
template <class Function>
KINOME_WIDE void for_lanes_of_blocks(std::span<const uint32_t> blocks, const Function& fn) {
  for (const uint32_t block : blocks) {
    const size_t first = size_t{block} * kBlockLanes;
    for (size_t i = first; i < first + kBlockLanes; i += kLanes) fn(i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
