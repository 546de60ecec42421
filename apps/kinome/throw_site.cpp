#include "throw_site.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>

#include "kinome/plugin_sites.h"

namespace kinome::app {
namespace {

/// Call stack of a throw, which is unwound by the time the exception is reported.
struct Throw {
  const void* exception = nullptr;
  std::array<void*, 48> frames{};
  int count = 0;
  const char* being_loaded = nullptr;  ///< plugin whose code isn't registered yet
};
std::atomic<bool> watching{false};
std::mutex mutex;
std::array<Throw, 64> throws;
size_t next_throw = 0;

void note(const void* exception) {
  Throw noted;
  noted.exception = exception;
  noted.count = backtrace(noted.frames.data(), static_cast<int>(noted.frames.size()));
  noted.being_loaded = plugin_being_loaded();
  const std::lock_guard lock(mutex);
  throws[next_throw++ % throws.size()] = noted;
}

}  // namespace

void watch_throws() {
  watching = true;
}

std::string plugin_that_threw(const void* exception) {
  const std::lock_guard lock(mutex);
  for (size_t back = 1; back <= std::min(next_throw, throws.size()); ++back) {
    const Throw& found = throws[(next_throw - back) % throws.size()];
    if (exception && found.exception != exception) continue;
    for (int i = 0; i < found.count; ++i) {
      const char* const plugin = plugin_at(found.frames[static_cast<size_t>(i)]);
      if (plugin) return plugin;
    }
    return found.being_loaded ? found.being_loaded : "";
  }
  return {};
}

}  // namespace kinome::app

/// Replaces the C++ library's function, which every throw calls, and forwards to it.
extern "C" void __cxxabiv1::__cxa_throw(void* exception, std::type_info* type,
                                        void (*destroy)(void*)) {
  using Throws = void (*)(void*, std::type_info*, void (*)(void*));
  static const auto next = reinterpret_cast<Throws>(dlsym(RTLD_NEXT, "__cxa_throw"));
  if (kinome::app::watching) kinome::app::note(exception);
  next(exception, type, destroy);
  __builtin_unreachable();
}
