#pragma once

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>

#include "kinome/plugin.h"

/// Plugins with a fault that the parameter `fault` selects.
namespace kinome::test {

#define KINOME_FAULT_PARAMETER \
  { "fault", ParameterType::kString, "none", "What it does wrong." }

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Never returns if n > 0, and can't be compiled to a loop.
inline int recurse(int n) {
  volatile char frame[256];
  frame[n & 255] = static_cast<char>(n);
  return n > 0 ? recurse(n + 1 > 0 ? n + 1 : 1) + frame[n & 255] : 0;
}

class Fault {
 public:
  explicit Fault(const Properties& props) : fault_(props.string("fault")) {
    throw_if("construction", "construct, as I was told");
    if (is("no exception in construction")) throw 42;
    crash_if("in construction");
  }
  bool is(const char* fault) const { return fault_ == fault; }
  void throw_if(const char* fault, const char* what) const {
    if (is(fault)) throw std::runtime_error(std::string("can't ") + what);
  }

  /// Crashes if the fault is "crash WHERE by SIGNAL" with this `where`.
  void crash_if(const char* where) const {
    const std::string crash = std::string("crash ") + where + " by ";
    if (!fault_.starts_with(crash)) return;
    const std::string how = fault_.substr(crash.size());
    volatile int zero = 0;
    if (how == "SIGSEGV") *reinterpret_cast<volatile int*>(zero + 8) = 1;
    if (how == "SIGFPE") zero = 42 / zero;
    if (how == "SIGILL") __builtin_trap();
    if (how == "SIGABRT") std::abort();
    if (how == "SIGBUS") raise(SIGBUS);
    if (how == "stack overflow") zero = recurse(1);
    if (how == "call of nowhere") reinterpret_cast<void (*)()>(static_cast<intptr_t>(zero))();
  }

 private:
  std::string fault_;
};

}  // namespace kinome::test
