#pragma once

#include "kinome/export.h"

namespace kinome {

/// A stack for signal handlers (SA_ONSTACK) of this thread, as long as it lives: they can then tell
/// of a stack overflow. The render context's threads have one each. Where there is no memory for
/// it, or the thread has one, there is none.
class KINOME_EXPORT AlternateStack {
 public:
  AlternateStack();
  ~AlternateStack();
  AlternateStack(const AlternateStack&) = delete;
  AlternateStack& operator=(const AlternateStack&) = delete;

 private:
  void* memory_ = nullptr;
};

}  // namespace kinome
