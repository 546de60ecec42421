#pragma once

#include <string>

#include "kinome/plugin.h"

/// Plugins that `kinome check` must find wrong, each in the way that its parameter `fault` says;
/// "none" is right.
namespace kinome::test {

#define KINOME_WRONG_PARAMETER {"fault", ParameterType::kString, "none", "What is wrong with it."}

class Wrong {
 public:
  explicit Wrong(const Properties& props) : fault_(props.string("fault")) {}
  bool is(const char* fault) const { return fault_ == fault; }
  /// `wrong` where that is the fault, else `right`.
  template <class T>
  T or_wrong(const char* fault, const T& right, const T& wrong) const {
    return is(fault) ? wrong : right;
  }

 private:
  std::string fault_;
};

}  // namespace kinome::test
