#pragma once

#include <limits>
#include <stdexcept>
#include <string>

#include "kinome/plugin.h"

/// Plugins that do what plugins must not, each in the way that its parameter `fault` says.
namespace kinome::test {

#define KINOME_FAULT_PARAMETER \
  { "fault", ParameterType::kString, "none", "What it does wrong." }

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class Fault {
 public:
  explicit Fault(const Properties& props) : fault_(props.string("fault")) {
    throw_if("construction", "construct, as I was told");
    if (is("no exception in construction")) throw 42;
  }
  bool is(const char* fault) const { return fault_ == fault; }
  void throw_if(const char* fault, const char* what) const {
    if (is(fault)) throw std::runtime_error(std::string("can't ") + what);
  }

 private:
  std::string fault_;
};

}  // namespace kinome::test
