#include "throw_site.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <mutex>

#include "kinome/object.h"

namespace kinome::app {
namespace {

/// The call stacks of the last throws. By the time that an exception is reported, its own is gone.
struct Throw {
  const void* exception = nullptr;
  std::array<void*, 48> frames{};
  int count = 0;
};
std::atomic<bool> watching{false};
std::mutex mutex;
std::array<Throw, 64> throws;
size_t next_throw = 0;

void note(const void* exception) {
  Throw noted;
  noted.exception = exception;
  noted.count = backtrace(noted.frames.data(), static_cast<int>(noted.frames.size()));
  const std::lock_guard lock(mutex);
  throws[next_throw++ % throws.size()] = noted;
}

/// "category/name" where a library lies where plugins do, else "".
std::string plugin_of(const std::string& library) {
  const std::filesystem::path path(library);
  if (path.extension() != ".so") return {};
  const std::string folder = path.parent_path().filename().string();
  for (int i = 0; i < kCategoryCount; ++i) {
    if (folder == to_string(static_cast<Category>(i))) return folder + "/" + path.stem().string();
  }
  return {};
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
      Dl_info info{};
      if (dladdr(found.frames[static_cast<size_t>(i)], &info) == 0 || !info.dli_fname) continue;
      std::string plugin = plugin_of(info.dli_fname);
      if (!plugin.empty()) return plugin;
    }
    return {};
  }
  return {};
}

}  // namespace kinome::app

/// In place of the C++ library's, which it goes on to: the one point that every throw passes.
extern "C" void __cxxabiv1::__cxa_throw(void* exception, std::type_info* type,
                                        void (*destroy)(void*)) {
  using Throws = void (*)(void*, std::type_info*, void (*)(void*));
  static const auto next = reinterpret_cast<Throws>(dlsym(RTLD_NEXT, "__cxa_throw"));
  if (kinome::app::watching) kinome::app::note(exception);
  next(exception, type, destroy);
  __builtin_unreachable();
}
