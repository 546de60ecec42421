#include "plugin/library_sites.h"

#include <link.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <set>

#include "kinome/plugin_sites.h"

namespace kinome {
namespace {

/// Address range of a library's code.
struct Site {
  uintptr_t begin = 0, end = 0;
  const char* name = nullptr;
  bool has(uintptr_t address) const { return address >= begin && address < end; }
};

/// Maximum number of plugins that plugin_at() knows. Later ones are not recorded.
constexpr size_t kMaxSites = 1024;
std::array<Site, kMaxSites> sites;
std::atomic<size_t> site_count{0};
std::atomic<const char*> being_loaded{nullptr};
Site core;  ///< set when the first plugin is loaded

/// Returns the code of the library that contains an address.
Site site_of(const void* address) {
  struct Search {
    uintptr_t address;
    Site found;
  } search{reinterpret_cast<uintptr_t>(address), {}};
  dl_iterate_phdr(
      [](dl_phdr_info* info, size_t /*size*/, void* data) {
        auto& wanted = *static_cast<Search*>(data);
        Site code{UINTPTR_MAX, 0, nullptr};
        bool contains_address = false;
        for (int i = 0; i < info->dlpi_phnum; ++i) {
          const auto& segment = info->dlpi_phdr[i];
          if (segment.p_type != PT_LOAD) continue;
          const uintptr_t begin = info->dlpi_addr + segment.p_vaddr;
          const uintptr_t end = begin + segment.p_memsz;
          contains_address = contains_address || (wanted.address >= begin && wanted.address < end);
          if ((segment.p_flags & PF_X) == 0) continue;
          code.begin = std::min(code.begin, begin);
          code.end = std::max(code.end, end);
        }
        if (contains_address) wanted.found = code;
        return contains_address ? 1 : 0;
      },
      &search);
  return search.found;
}

/// Never freed, because threads that crash while the program exits may read the names.
std::set<std::string>& names() {
  static auto* const names = new std::set<std::string>;
  return *names;
}

}  // namespace

LibraryLoading::LibraryLoading(const std::string& plugin)
    : name_(names().insert(plugin).first->c_str()) {
  if (core.end == 0) core = site_of(reinterpret_cast<const void*>(&site_of));
  being_loaded.store(name_);
}

LibraryLoading::~LibraryLoading() {
  being_loaded.store(nullptr);
}

void LibraryLoading::finish(const void* symbol) {
  Site site = site_of(symbol);
  site.name = name_;
  const size_t count = site_count.load();
  const bool is_known = plugin_at(reinterpret_cast<const void*>(site.begin)) != nullptr;
  if (site.end == 0 || is_known || count == kMaxSites) return;
  sites[count] = site;
  site_count.store(count + 1, std::memory_order_release);
}

const char* plugin_at(const void* address) noexcept {
  const auto at = reinterpret_cast<uintptr_t>(address);
  const size_t count = site_count.load(std::memory_order_acquire);
  for (size_t i = 0; i < count; ++i) {
    if (sites[i].has(at)) return sites[i].name;
  }
  return nullptr;
}

const char* plugin_being_loaded() noexcept {
  return being_loaded.load();
}

bool is_core_at(const void* address) noexcept {
  return core.has(reinterpret_cast<uintptr_t>(address));
}

}  // namespace kinome
