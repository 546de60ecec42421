#pragma once

namespace kinome {

/// Maximum width and height of images in pixels. Readers reject larger ones before they allocate
/// memory.
inline constexpr int kMaxSide = 1 << 17;

}  // namespace kinome
