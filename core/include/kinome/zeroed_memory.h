#pragma once

#include <cstddef>
#include <memory>

#include "kinome/export.h"

namespace kinome {

/// Memory initialised with zeros. Pages of a large block take no physical memory until they are
/// accessed. Uses huge pages of 2 MB where most of the page is needed: with small pages,
/// initialisation takes ten times as long, most of the time of a small render.
class KINOME_EXPORT ZeroedMemory {
 public:
  static constexpr size_t kHugePage = size_t{1} << 21;
  static constexpr size_t kMinAlignment = 64;

  ZeroedMemory() = default;
  /// Throws std::bad_alloc.
  explicit ZeroedMemory(size_t bytes);

  /// Pointer to the memory; nullptr if empty. Aligned to kMinAlignment, or to kHugePage if the
  /// memory is at least that large.
  void* data() const { return memory_.get(); }

  /// Returns the memory of an object that this call makes empty. The caller must pass it to
  /// release() with the number of bytes of the constructor.
  void* detach() { return memory_.release(); }
  static void release(void* memory, size_t bytes);

 private:
  struct Release {
    size_t bytes;
    void operator()(void* memory) const { release(memory, bytes); }
  };
  std::unique_ptr<void, Release> memory_{nullptr, Release{0}};
};

}  // namespace kinome
