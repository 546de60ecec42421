#include "clustered/product/choice/point_nodes.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Maximum distance of a pixel from a node's mean, relative to the lobe's roughness.
constexpr double kReach = 0.7;

bool is_divided(const Patch& patch) {
  return patch.is_described && is_microfacet(patch.form) &&
         any(patch.bsdf->lobes() & Lobe::kGlossy);
}

}  // namespace

PointNodes::Sums PointNodes::Sums::of(const glm::dvec3& n, const glm::dvec3& w) {
  const glm::dvec3 h = n - 0.5 * w;
  return {1, n, w, h, glm::dot(h, h)};
}

void PointNodes::Sums::add(const Sums& other) {
  points += other.points;
  normal += other.normal;
  viewer += other.viewer;
  half += other.half;
  half2 += other.half2;
}

/// Groups the unit's points by patch. Each part wants its share of the unit's candidates.
void PointNodes::find_parts(const TilePrimaries& primaries, std::span<const Patch> patches,
                            const Unit& unit) {
  part_of_patch_.assign(patches.size(), -1);
  const size_t first = parts_.size();
  uint32_t all = 0;
  for (uint32_t i = unit.first; i < unit.end; ++i) {
    const int32_t patch = primaries.patch(i);
    if (patch < 0) continue;
    ++all;
    if (!is_divided(patches[patch])) continue;
    int32_t& part = part_of_patch_[patch];
    if (part < 0) {
      part = static_cast<int32_t>(parts_.size());
      parts_.push_back({patch, 0, -1, {}});
    }
    node_of_[i] = part;
    parts_[part].sums.add(Sums::of(primaries.normal(i), primaries.viewer(i)));
  }
  for (size_t k = first; k < parts_.size(); ++k) {
    parts_[k].wanted =
        unit.candidates * static_cast<float>(parts_[k].sums.points) / static_cast<float>(all);
  }
}

/// Returns the nearest node of the patch, or a new one.
int32_t PointNodes::node_for(const Part& part, float alpha2) {
  const glm::dvec3 half = part.sums.mean_half();
  double nearest = kReach * kReach * alpha2;
  int32_t found = -1;
  for (size_t k = 0; k < nodes_.size(); ++k) {
    if (nodes_[k].patch != part.patch) continue;
    const glm::dvec3 between = sums_[k].mean_half() - half;
    const double distance = glm::dot(between, between);
    if (distance >= nearest) continue;
    nearest = distance;
    found = static_cast<int32_t>(k);
  }
  if (found >= 0) return found;
  nodes_.push_back({});
  nodes_.back().patch = part.patch;
  sums_.push_back({});
  return static_cast<int32_t>(nodes_.size()) - 1;
}

void PointNodes::finish(const TilePrimaries& primaries, std::span<const Patch> patches) {
  for (size_t k = 0; k < nodes_.size(); ++k) {
    PointNode& node = nodes_[k];
    const Sums& sums = sums_[k];
    const Patch& patch = patches[node.patch];
    node.points = sums.points;
    node.normal = normalized(Vec3(sums.normal), patch.normal);
    node.viewer = normalized(Vec3(sums.viewer), patch.viewer);
    const glm::dvec3 mean = sums.mean_half();
    const double spread2 = sums.half2 / sums.points - glm::dot(mean, mean);
    node.spread2 = static_cast<float>(std::max(0., spread2));
  }
  for (uint32_t i = 0; i < node_of_.size(); ++i) {
    if (node_of_[i] < 0) continue;
    node_of_[i] = parts_[node_of_[i]].node;
    PointNode& node = nodes_[node_of_[i]];
    node.cosine = std::min(node.cosine, glm::dot(node.normal, primaries.normal(i)));
    if (node.tangent == Vec3(0.f)) {
      const Vec3 t = primaries.tangent(i);
      node.tangent = normalized(t - node.normal * glm::dot(t, node.normal),
                                Frame::from_normal(node.normal).s);
    }
  }
}

void PointNodes::divide(const TilePrimaries& primaries, std::span<const Patch> patches,
                        std::span<const Unit> units) {
  nodes_.clear();
  sums_.clear();
  parts_.clear();
  node_of_.clear();
  if (std::none_of(patches.begin(), patches.end(), is_divided)) return;
  node_of_.assign(primaries.size(), -1);
  for (const Unit& unit : units) find_parts(primaries, patches, unit);
  for (Part& part : parts_) {
    part.node = node_for(part, patches[part.patch].alpha2());
    sums_[part.node].add(part.sums);
    ++nodes_[part.node].pixels;
    nodes_[part.node].wanted += part.wanted;
  }
  finish(primaries, patches);
}

}  // namespace kinome
