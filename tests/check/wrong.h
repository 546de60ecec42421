#pragma once

#include <string>

#include "kinome/plugin.h"

/// Plugins with a fault that `kinome check` must find. The parameter `fault` selects it; "none" is
/// correct.
namespace kinome::test {

#define KINOME_WRONG_PARAMETER {"fault", ParameterType::kString, "none", "The plugin's fault."}

class Wrong {
 public:
  explicit Wrong(const Properties& props) : fault_(props.string("fault")) {}
  bool is(const char* fault) const { return fault_ == fault; }
  /// Returns `wrong` if this fault is selected, else `right`.
  template <class T>
  T or_wrong(const char* fault, const T& right, const T& wrong) const {
    return is(fault) ? wrong : right;
  }

 private:
  std::string fault_;
};

}  // namespace kinome::test
