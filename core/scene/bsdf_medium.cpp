#include "kinome/bsdf_medium.h"

#include <unordered_set>
#include <utility>
#include <vector>

#include "kinome/error.h"

namespace kinome {
namespace {

/// Adds the interior media of `bsdf` and all nested BSDFs. Parts that were searched before are
/// skipped, because a BSDF may be nested in many others.
void add_interiors(const Bsdf& bsdf, std::vector<std::shared_ptr<const Medium>>& found,
                   std::unordered_set<const Object*>& searched) {
  if (!searched.insert(&bsdf).second) return;
  if (const auto* const source = dynamic_cast<const InteriorMedium*>(&bsdf)) {
    if (auto medium = source->interior()) found.push_back(std::move(medium));
    return;
  }
  for (const auto& part : bsdf.nested()) {
    const auto* const nested = dynamic_cast<const Bsdf*>(part.get());
    if (nested) add_interiors(*nested, found, searched);
  }
}

}  // namespace

InteriorMedium::~InteriorMedium() = default;

std::shared_ptr<const Medium> interior_of(const Bsdf& bsdf) {
  std::vector<std::shared_ptr<const Medium>> found;
  std::unordered_set<const Object*> searched;
  add_interiors(bsdf, found, searched);
  for (const auto& medium : found) {
    if (medium != found.front()) {
      throw Error("the BSDFs nested in '" + bsdf.plugin() + "' have different interior media");
    }
  }
  return found.empty() ? nullptr : found.front();
}

}  // namespace kinome
