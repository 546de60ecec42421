#include "scene_xml/nodes/faults.h"

#include <algorithm>
#include <tuple>

#include "base/file_search.h"
#include "kinome/plugin_registry.h"

namespace kinome::loader {
namespace {

constexpr size_t kMaxErrors = 10'000;

bool comes_before(const Location& a, const Location& b) {
  return std::tie(a.file, a.line, a.column) < std::tie(b.file, b.line, b.column);
}

/// Returns the locations that lead to an error, from the scene file inward.
std::vector<Location> path_to(const Error& error) {
  std::vector<Location> path(error.requesters().rbegin(), error.requesters().rend());
  path.push_back(error.where());
  return path;
}

}  // namespace

void Faults::add(const Error& error) {
  if (const auto* several = dynamic_cast<const Errors*>(&error)) {
    for (const Error& one : several->all()) add(one);
    return;
  }
  if (expects_missing_files_ && dynamic_cast<const MissingFile*>(&error)) return;
  // An unusable plugin is reported once, not for each object.
  const bool is_global = dynamic_cast<const UnusablePlugin*>(&error) != nullptr;
  if (!reported_.insert(is_global ? error.message() : error.what()).second) return;
  all_.push_back(error);
  if (all_.size() >= kMaxErrors) throw Stop();
}

void Faults::stop(const Error& error) {
  add(error);
  throw Stop();
}

Error Faults::with_includes(Error error) const {
  // The loop ends, because includes can't be circular.
  const Location* last = error.requesters().empty() ? &error.where() : &error.requesters().back();
  for (auto include = includes_.find(last->file); include != includes_.end();
       include = includes_.find(include->second.file)) {
    error = error.requested_by(include->second);
  }
  return error;
}

std::vector<Error> Faults::sorted() const {
  std::vector<std::pair<std::vector<Location>, Error>> keyed;
  for (const Error& fault : all_) {
    Error whole = with_includes(fault);
    std::vector<Location> path = path_to(whole);
    keyed.emplace_back(std::move(path), std::move(whole));
  }
  std::stable_sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.first.begin(), a.first.end(), b.first.begin(),
                                        b.first.end(), comes_before);
  });
  std::vector<Error> faults;
  for (auto& [path, fault] : keyed) faults.push_back(std::move(fault));
  if (all_.size() >= kMaxErrors) {
    faults.emplace_back(Location{keyed.back().first.front().file},
                        "too many errors: stopped looking for more");
  }
  return faults;
}

void Faults::check() const {
  if (!empty()) throw Errors(sorted());
}

}  // namespace kinome::loader
