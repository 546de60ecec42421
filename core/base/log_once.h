#pragma once

#include <set>
#include <string>

namespace kinome {

/// Suppresses repeated warnings of the whole process during its lifetime. The passes of a render
/// would otherwise give the same warnings again and again.
class WarningsOnce {
 public:
  WarningsOnce() : WarningsOnce(nullptr) {}
  /// Also suppresses the warnings in `*seen`; the destructor adds the new ones to it. `seen` is
  /// ignored if another WarningsOnce exists already.
  explicit WarningsOnce(std::set<std::string>* seen);
  ~WarningsOnce();
  WarningsOnce(const WarningsOnce&) = delete;
  WarningsOnce& operator=(const WarningsOnce&) = delete;

 private:
  std::set<std::string>* seen_;
};

}  // namespace kinome
