#pragma once

#include "kinome/export.h"

namespace kinome {

/// Alternate signal stack of the current thread, active during the object's lifetime. Signal
/// handlers with SA_ONSTACK run on it and can thus report a stack overflow. Each thread of the
/// scheduler has one. Does nothing if too little memory is available, or if the thread already has
/// an alternate stack.
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
