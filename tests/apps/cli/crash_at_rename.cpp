// Preloaded library that crashes the program when it renames a finished file.
#include <cstdio>
#include <cstdlib>

extern "C" int rename(const char* /*from*/, const char* /*to*/) noexcept {
  std::abort();
}
