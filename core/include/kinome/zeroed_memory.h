#pragma once

#include <cstddef>
#include <memory>

#include "kinome/export.h"

namespace kinome {

/// Memory that holds zeros at first. If it is large, what nobody has written to takes up addresses
/// alone: the system supplies pages of zeros when they are touched. It is asked for huge pages, of
/// 2 MB: small ones take it ten times as long, most of the time of a small render. What would leave
/// most of a huge page unused consists of small ones.
class KINOME_EXPORT ZeroedMemory {
 public:
  static constexpr size_t kHugePage = size_t{1} << 21;

  ZeroedMemory() = default;
  /// Throws std::bad_alloc.
  explicit ZeroedMemory(size_t bytes);

  /// Aligned for any number; from kHugePage on, to that. nullptr: there is none.
  void* data() const { return memory_.get(); }

 private:
  struct Release {
    size_t mapped;  ///< bytes; 0: it is from the heap
    void operator()(void* memory) const;
  };
  std::unique_ptr<void, Release> memory_{nullptr, Release{0}};
};

}  // namespace kinome
