#pragma once

#include "kinome/export.h"

namespace kinome {

/// A stack on which this thread's signal handlers (SA_ONSTACK) run as long as the object lives, so
/// that they can report a stack overflow. The render context's threads have one each. There is none
/// if there is no memory for it, or if the thread has another.
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
