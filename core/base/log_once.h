#pragma once

#include <set>
#include <string>

namespace kinome {

/// While one of these lives, each warning is told but once, whoever gives it: the passes of a
/// render come by the same places again and again.
class WarningsOnce {
 public:
  WarningsOnce() : WarningsOnce(nullptr) {}
  /// Also suppresses the warnings in `*seen`, and adds those that are given meanwhile. Within
  /// another WarningsOnce, `seen` is ignored.
  explicit WarningsOnce(std::set<std::string>* seen);
  ~WarningsOnce();
  WarningsOnce(const WarningsOnce&) = delete;
  WarningsOnce& operator=(const WarningsOnce&) = delete;

 private:
  std::set<std::string>* seen_;
};

}  // namespace kinome
