#pragma once

namespace kinome {

/// While one of these lives, each warning is told but once, whoever gives it: the passes of a
/// render come by the same places again and again.
class WarningsOnce {
 public:
  WarningsOnce();
  ~WarningsOnce();
  WarningsOnce(const WarningsOnce&) = delete;
  WarningsOnce& operator=(const WarningsOnce&) = delete;
};

}  // namespace kinome
