#pragma once

namespace kinome {

/// Pixels along a side that no real picture exceeds: readers refuse more before they ask for
/// memory.
inline constexpr int kMaxSide = 1 << 17;

}  // namespace kinome
