#include "clustered/product/pilot/tile_knowledge.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cmath>

namespace kinome {
namespace {

/// Standard deviation in pixels of the Gaussian that weights tiles.
constexpr float kReachDeviation = 4;
/// A patch learns from patches with at least this cosine between the normals, and with planes
/// within this factor of its tolerance.
constexpr float kLearnCosine = 0.9f;
constexpr float kLearnPlanes = 1.6f;
/// A sharp lobe's patch uses its visibility only if it predicts the pilot's own rays well:
/// sum (V - v)² < kMaxPredictionError x sum V².
constexpr float kMaxPredictionError = 0.1f;

/// One in this number of tiles takes part in the check of sigma.
constexpr uint64_t kTilesPerCheck = 2;

/// Tile that others learn from, with the weight of each of its records in sixteenths.
struct Nearby {
  int dx, dy;
  uint32_t weight;
};
/// Returns the tiles whose weight isn't 0.
const std::vector<Nearby>& tiles_nearby() {
  static const std::vector<Nearby> all = [] {
    constexpr int kReach = TileKnowledge::kReach;
    std::vector<Nearby> found;
    for (int dy = -kReach; dy <= kReach; ++dy) {
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const auto squared = static_cast<float>((dx * dx + dy * dy) * kTileSide * kTileSide);
        const float weight = std::exp(-0.5f * squared / sqr(kReachDeviation));
        const auto units = static_cast<uint32_t>(std::lround(16 * weight));
        if (units > 0) found.push_back({dx, dy, units});
      }
    }
    return found;
  }();
  return all;
}

uint8_t byte_of(float share) {
  return static_cast<uint8_t>(static_cast<int32_t>(share * 255 + 0.5f));
}
/// Learned visibility of a cell in 8 bits. Stored and recomputed values are the same in passes.
struct Learned {
  uint8_t v, root_of_sigma;

  static Learned of(const Visibility& visibility, size_t cell) {
    return {byte_of(visibility.v[cell]), byte_of(std::min(1.f, std::sqrt(visibility.sigma[cell])))};
  }
  void restore(Visibility& out, size_t cell) const {
    out.v[cell] = static_cast<float>(v) * (1 / 255.f);
    out.sigma[cell] = std::max(sqr(static_cast<float>(root_of_sigma) * (1 / 255.f)), 1e-4f);
    out.sigma_mixed[cell] = std::sqrt(0.9f * out.v[cell] + 0.06f);
  }
};

}  // namespace

TileKnowledge::TileKnowledge(const TileGrid& grid, const DistantCells& cells,
                             const LocalLight* local, const ProductSettings& settings)
    : grid_(grid),
      cells_(cells),
      settings_(settings),
      padded_cells_(cells.padded_size() + (local ? local->padded_size() : 0)),
      first_lamp_(cells.padded_size()),
      end_lamps_(first_lamp_ + (local ? local->lamp_cells() : 0)),
      has_local_(local != nullptr),
      tiles_(static_cast<size_t>(grid.tiles())),
      learned_(remembers() ? tiles_.size() : 0) {}

/// Returns the memory of large images to the system, so that their development can use it.
TileKnowledge::~TileKnowledge() {
  if (remembers()) return;
  tiles_.clear();
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

TileKnowledge::Tile::Tile(std::span<const Patch> patches,
                          std::span<const VisibilityRecord> records, SharedOfPatches& shared)
    : count_(static_cast<uint32_t>(patches.size())) {
  if (patches.empty()) return;
  bytes_.reset(new std::byte[patches.size() * sizeof(StoredPatch) + records.size_bytes()]);
  std::byte* to = bytes_.get();
  for (const Patch& patch : patches) {
    new (to) StoredPatch(patch, shared);
    to += sizeof(StoredPatch);
  }
  std::uninitialized_copy(records.begin(), records.end(), reinterpret_cast<VisibilityRecord*>(to));
}

void TileKnowledge::forget() {
  sigma_check_.forget();
  tiles_.clear();
  tiles_.resize(static_cast<size_t>(grid_.tiles()));
  shared_.clear();
  learned_.assign(learned_.size(), {});
}

void TileKnowledge::patches(int tile, std::vector<Patch>& out) const {
  out.clear();
  for (const StoredPatch& patch : tiles_[tile].patches()) out.push_back(patch.restored(shared_));
}

const Bsdf* TileKnowledge::main_bsdf(int tile) const {
  const auto patches = tiles_[tile].patches();
  const auto largest = std::max_element(
      patches.begin(), patches.end(),
      [](const StoredPatch& a, const StoredPatch& b) { return a.count < b.count; });
  return largest == patches.end() ? nullptr : largest->bsdf;
}

void TileKnowledge::keep(int index, std::span<Patch> patches,
                         std::span<const std::vector<VisibilityRecord>> found) {
  std::vector<VisibilityRecord> records;
  for (size_t p = 0; p < patches.size(); ++p) {
    records.insert(records.end(), found[p].begin(), found[p].end());
    patches[p].records_end = static_cast<uint32_t>(records.size());
  }
  tiles_[index] = Tile(patches, records, shared_);
}

void TileKnowledge::transfer_kept(int index, SharedBytes& bytes, BsdfAddresses& addresses) {
  std::vector<Patch> own;
  std::vector<VisibilityRecord> records;
  if (!bytes.reads()) {
    patches(index, own);
    const auto kept = tiles_[index].records();
    records.assign(kept.begin(), kept.end());
  }
  bytes.resize(own);
  for (Patch& patch : own) transfer(patch, bytes, addresses);
  bytes.vector(records);
  if (bytes.reads()) tiles_[index] = Tile(own, records, shared_);
}

void TileKnowledge::transfer_learned(int index, SharedBytes& bytes) {
  std::vector<Patch> own;
  patches(index, own);
  for (size_t p = 0; p < own.size(); ++p) {
    kinome::transfer_learned(own[p], bytes);
    if (bytes.reads()) tiles_[index].patches()[p].set_learned(own[p]);
  }
  if (bytes.reads() && remembers()) learned_[index].clear();
}

/// Learns from the pilot's records of the tiles around, on surfaces that continue the patch.
void TileKnowledge::learn_from_around(int index, const Patch& patch, VisibilityLearner& learner,
                                      Visibility& out, Own own) const {
  learner.begin();
  const int tx = index % grid_.tiles_x(), ty = index / grid_.tiles_x();
  for (const Nearby& nearby : tiles_nearby()) {
    const int x = tx + nearby.dx, y = ty + nearby.dy;
    if (x < 0 || y < 0 || x >= grid_.tiles_x() || y >= grid_.tiles_y()) continue;
    if (own == Own::kLeftOut && nearby.dx == 0 && nearby.dy == 0) continue;
    const Tile& tile = tiles_[static_cast<size_t>(y) * grid_.tiles_x() + x];
    const auto sources = tile.patches();
    for (size_t p = 0; p < sources.size(); ++p) {
      const StoredPatch& source = sources[p];
      if (source.bsdf != patch.bsdf || glm::dot(source.normal, patch.normal) < kLearnCosine ||
          std::abs(glm::dot(source.position - patch.position, patch.normal)) >
              kLearnPlanes * patch.tolerance) {
        continue;
      }
      learner.add(tile.records_of(p), nearby.weight);
    }
  }
  learner.finish(cells_.blocks(), patch.normal, cone_sine(patch.cone_cosine), out);
}

/// In some tiles, compares their own rays with predictions from the tiles around.
void TileKnowledge::check_sigma(int index, VisibilityLearner& learner, Visibility& scratch) {
  if (!checks_sigma()) return;
  if (hash_words(static_cast<uint64_t>(index)) % kTilesPerCheck != 0) return;
  const Tile& tile = tiles_[index];
  const auto patches = tile.patches();
  for (size_t p = 0; p < patches.size(); ++p) {
    const auto own = tile.records_of(p);
    if (own.empty()) continue;
    learn_from_around(index, patches[p].restored(shared_), learner, scratch, Own::kLeftOut);
    for (const VisibilityRecord record : own) {
      const uint32_t cell = record.cell();
      sigma_check_.add_record(scratch.v[cell], scratch.sigma[cell], record.value());
    }
  }
}

void TileKnowledge::learn_patch(int index, size_t p, Patch& patch, VisibilityLearner& learner,
                                Visibility& out) {
  Tile& tile = tiles_[index];
  learn_from_around(index, patch, learner, out);
  if (remembers()) {
    uint8_t* const kept = &learned_[index][p * 2 * padded_cells_];
    for (size_t c = 0; c < padded_cells_; ++c) {
      const Learned learned = Learned::of(out, c);
      kept[c] = learned.v;
      kept[padded_cells_ + c] = learned.root_of_sigma;
    }
  }
  if (has_local_ || any(patch.bsdf->lobes() & Lobe::kGlossy)) {
    find_trust(tile.records_of(p), patch, out);
    tile.patches()[p].set_learned(patch);
  }
}

/// Prevents the worst errors: a lamp's reflection that a ridge hides while v says visible.
void TileKnowledge::find_trust(std::span<const VisibilityRecord> own, Patch& patch,
                               const Visibility& visibility) const {
  struct {
    float count = 0, visible = 0, v = 0;
  } lamps, others;
  float error = 0, sigma = 0;
  for (const VisibilityRecord record : own) {
    const uint32_t cell = record.cell();
    const float v = visibility.v[cell], seen = record.value();
    auto& of = cell >= first_lamp_ && cell < end_lamps_ ? lamps : others;
    of.count += 1;
    of.visible += seen;
    of.v += v;
    error += sqr(seen - v);
    sigma += visibility.sigma[cell];
  }
  const float count = lamps.count + others.count;
  if (count == 0) return;
  const float mean = (lamps.v + others.v) / count;
  patch.lamp_visibility = lamps.count > 0 ? lamps.v / lamps.count : mean;
  patch.mean_visibility = others.count > 0 ? others.v / others.count : mean;
  patch.mean_sigma = sigma / count;
  if (!is_sharp(patch)) return;
  patch.trust = error < kMaxPredictionError * (lamps.visible + others.visible);
  patch.mean_visibility = (others.visible + 2 * patch.mean_visibility) / (others.count + 2);
}

void TileKnowledge::recall(int index, size_t p, Patch& patch, VisibilityLearner& learner,
                           Visibility& out) const {
  const Tile& tile = tiles_[index];
  if (p >= tile.patches().size()) {
    learn_from_around(index, patch, learner, out);
    patch.trust = !is_sharp(patch);
  } else if (learned_.empty() || learned_[index].empty()) {
    // Learn from the pilot's patch, because later points may have widened the cone of `patch`.
    learn_from_around(index, tile.patches()[p].restored(shared_), learner, out);
    for (size_t c = 0; c < padded_cells_; ++c) Learned::of(out, c).restore(out, c);
  } else {
    const uint8_t* const kept = &learned_[index][p * 2 * padded_cells_];
    for (size_t c = 0; c < padded_cells_; ++c) {
      Learned{kept[c], kept[padded_cells_ + c]}.restore(out, c);
    }
  }
  sigma_check_.correct(out);
}

void TileKnowledge::restrict(const Patch& patch, Visibility& visibility) const {
  if (!patch.trust) {
    std::fill(visibility.v.begin(), visibility.v.end(), 0.f);
    visibility.sigma = visibility.sigma_mixed;
  }
  if (settings_.control_variate && settings_.learned_sigma) return;
  for (size_t c = 0; c < visibility.v.size(); ++c) {
    if (!settings_.control_variate) {
      visibility.sigma[c] = std::sqrt(0.05f + 0.9f * visibility.v[c] + 0.01f);
      visibility.v[c] = 0;
    }
    if (!settings_.learned_sigma) visibility.sigma[c] = visibility.sigma_mixed[c] = 1;
  }
}

}  // namespace kinome
