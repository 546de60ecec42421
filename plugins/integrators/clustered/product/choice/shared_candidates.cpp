#include "clustered/product/choice/shared_candidates.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "clustered/cells/hilbert_points.h"

namespace kinome {
namespace {

/// Minimum number of pixels of a node. Sharing among fewer costs more than it saves.
constexpr uint32_t kMinPixels = 3;
/// Maximum spread of the points, relative to the lobe's roughness.
constexpr float kMaxSpread = 0.5f;
/// Minimum height of the mean point's viewer above the horizon of any normal of the node. The mean
/// lobe then covers all directions that any point reflects.
constexpr float kHorizonMargin = 0.02f;
/// Fraction of the spread that widens the lobe from which candidates are drawn.
constexpr float kWidening = 0.5f;
/// Fraction of the wanted candidates that a pixel takes if all points are alike. It is larger the
/// wider they spread.
constexpr float kMinShare = 0.8f;
/// Blocks are doubled as long as all their candidates are less than this share of the number that
/// all pixels want.
constexpr double kMaxDrawnShare = 1 / 3.;
constexpr uint32_t kMaxBlocks = 8;
/// Minimum number of a block's candidates of each kind.
constexpr uint32_t kMinFromLobe = 16, kMinFromCells = 2;
/// Squared distance from the mean point at which a group has little of the control variate,
/// relative to the lobe's squared roughness.
constexpr float kVariateReach2 = 2;
/// Maximum ratio of a specular colour to that of the patch's first point, and the minimum of the
/// latter.
constexpr float kMaxRatio = 4, kMinSpecular = 1e-3f;

float min_alpha2(const Patch& patch) {
  return sqr(std::min(patch.lobe.alpha_u, patch.lobe.alpha_v));
}

}  // namespace

SharedCandidates::SharedCandidates(const CellLight& light) : light_(light), importance_(light) {
  mean_point_.resize(kBlockLanes);
}

void SharedCandidates::begin_tile(const TilePrimaries& primaries, std::span<const Patch> patches,
                                  std::span<const Visibility> visibility,
                                  std::span<const Unit> units, uint64_t seed) {
  patches_ = patches;
  visibility_ = visibility;
  seed_ = seed;
  candidates_.resize(0);
  sets_.clear();
  nodes_.clear();
  if (units.size() < kMinPixels || !light_.has_distant()) return;
  nodes_.divide(primaries, patches, units);
  for (const PointNode& node : nodes_.nodes()) {
    Set& set = sets_.emplace_back();
    set.is_shared = may_share(node);
    if (set.is_shared) choose_counts(node, set);
  }
}

bool SharedCandidates::may_share(const PointNode& node) const {
  if (node.pixels < kMinPixels) return false;
  if (node.spread2 > sqr(kMaxSpread) * min_alpha2(patches_[node.patch])) return false;
  return glm::dot(node.normal, node.viewer) > cone_sine(node.cosine) + kHorizonMargin;
}

void SharedCandidates::choose_counts(const PointNode& node, Set& set) const {
  const Patch& patch = patches_[node.patch];
  const float spread = std::sqrt(node.spread2 / min_alpha2(patch));
  set.share = std::min(1.f, kMinShare + spread);
  const double of_pixel = std::max(8., set.share * node.wanted / node.pixels);
  uint32_t blocks = 1;
  while (blocks < kMaxBlocks && blocks * 2 * of_pixel < kMaxDrawnShare * node.wanted) blocks *= 2;
  const uint32_t from_lobe =
      1u << HilbertPoints::nearest_log2(of_pixel * (1 - patch.cell_share) * blocks);
  while (blocks > 1 && from_lobe / blocks < kMinFromLobe) blocks /= 2;
  set.blocks = blocks;
  set.from_lobe = from_lobe / blocks;
  set.from_cells =
      std::max(kMinFromCells, static_cast<uint32_t>(of_pixel * patch.cell_share + 0.5));
}

uint32_t SharedCandidates::blocks_for(const Set& set, float wanted) {
  const float of_block = static_cast<float>(set.from_lobe + set.from_cells);
  const auto blocks = static_cast<uint32_t>(set.share * wanted / of_block + 0.5f);
  return std::clamp(blocks, 1u, set.blocks);
}

const SharedCandidates::Set* SharedCandidates::find(const GroupView& group) {
  const int32_t index = nodes_.of(group.primary(0));
  if (index < 0 || !sets_[index].is_shared) return nullptr;
  Set& set = sets_[index];
  if (!set.is_drawn) {
    set.is_drawn = true;
    draw(nodes_.nodes()[index], set, hash_words(seed_, static_cast<uint64_t>(index)));
  }
  return &set;
}

Rgb SharedCandidates::variate(const GroupView& group) const {
  const PointNode& node = nodes_.nodes()[nodes_.of(group.primary(0))];
  const Vec3 offset = node.offset(group.group.normal, group.group.viewer);
  const float likeness =
      std::exp(-glm::dot(offset, offset) / (kVariateReach2 * group.patch.alpha2()));
  const auto points = static_cast<float>(group.group.count);
  if (group.patch.is_uniform) return Rgb(likeness * points);
  Rgb specular(0.f);
  for (uint32_t k = 0; k < group.group.count; ++k) {
    specular += group.primaries.specular(group.primary(k));
  }
  Rgb part(0.f);
  for (int c = 0; c < 3; ++c) {
    const float first = group.patch.form.specular[c];
    if (first > kMinSpecular) part[c] = std::min(kMaxRatio * points, specular[c] / first);
  }
  return likeness * part;
}

simd::SharedValues SharedCandidates::values(const Set& set, uint32_t block) const {
  const size_t i = set.first + block * set.size;
  return {{&ratio_[0][i], &ratio_[1][i], &ratio_[2][i]},
          {&known_[0][i], &known_[1][i], &known_[2][i]},
          &v_[i],
          &sigma_[i]};
}

/// Returns the patch's lobe, widened for points around the mean point.
simd::HalfVectorLobe SharedCandidates::lobe_of(const PointNode& node) const {
  const simd::HalfVectorLobe& lobe = patches_[node.patch].lobe;
  const float more = kWidening * node.spread2;
  return {std::sqrt(sqr(lobe.alpha_u) + more), std::sqrt(sqr(lobe.alpha_v) + more)};
}

void SharedCandidates::draw(const PointNode& node, Set& set, uint64_t seed) {
  const Patch& patch = patches_[node.patch];
  importance_.find({node.normal, node.viewer, patch.cone_cosine, patch.alpha2()});
  if (!(importance_.total() > 0)) set.from_cells = 0;
  set.size = padded(set.from_lobe + set.from_cells);
  set.first = candidates_.size();
  candidates_.resize(set.first + set.blocks * set.size);
  const size_t room = candidates_.member.size();
  for (auto* const column : {&ratio_[0], &ratio_[1], &ratio_[2], &known_[0], &known_[1],
                             &known_[2], &v_, &sigma_}) {
    if (column->size() < room) column->resize(room);
  }
  if (mean_member_.size() < room) mean_member_.resize(room, 0);
  for (int axis = 0; axis < 3; ++axis) {
    mean_point_.normal[axis][0] = node.normal[axis];
    mean_point_.tangent[axis][0] = node.tangent[axis];
    mean_point_.viewer[axis][0] = node.viewer[axis];
  }
  draw_from_lobe(node, set, hash_words(seed, 1));
  draw_from_cells(node, set, random_float(seed, 2));
  evaluate(node, set);
}

/// Draws one stratified set for all blocks. Each block gets every set.blocks-th point.
void SharedCandidates::draw_from_lobe(const PointNode& node, const Set& set, uint64_t seed) {
  const uint32_t count = set.from_lobe, blocks = set.blocks;
  const auto points = HilbertPoints::get().power_of_two(
      static_cast<uint32_t>(std::countr_zero(count * blocks)));
  for (auto& column : numbers_) column.resize(padded(count));
  for (uint32_t block = 0; block < blocks; ++block) {
    for (uint32_t i = 0; i < count; ++i) {
      numbers_[0][i] = points.x[i * blocks + block];
      numbers_[1][i] = points.y[i * blocks + block];
    }
    const size_t first = set.first + block * set.size;
    DistantCandidates& c = candidates_;
    float *const dx = &c.dx[first], *const dy = &c.dy[first], *const dz = &c.dz[first];
    simd::sample_lobe(lobe_of(node), {mean_point_, mean_id_.data(), 1}, mean_member_.data(),
                      {numbers_[0].data(),
                       numbers_[1].data(),
                       {static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32)}},
                      count, dx, dy, dz);
    light_.cells.look_up({dx, dy, dz, &c.cell[first], &c.cell_density[first], &c.radiance[first]},
                         count);
  }
}

/// Draws one comb, and deals its hits to the blocks.
void SharedCandidates::draw_from_cells(const PointNode& node, const Set& set, float offset) {
  const uint32_t blocks = set.blocks;
  std::span<const Comb::Hit> hits;
  if (set.from_cells > 0) hits = importance_.draw(set.from_cells * blocks, offset);
  for (uint32_t block = 0; block < blocks; ++block) {
    const size_t first = set.first + block * set.size + set.from_lobe;
    for (size_t i = 0; i < set.size - set.from_lobe; ++i) {
      const size_t hit = i * blocks + block;
      if (i < set.from_cells && hit < hits.size()) {
        candidates_.put_point(first + i,
                              light_.points.pick(hits[hit].stratum, hits[hit].remainder));
      } else {
        candidates_.put_nothing(first + i, node.normal);
      }
    }
  }
}

void SharedCandidates::evaluate(const PointNode& node, Set& set) {
  const Patch& patch = patches_[node.patch];
  const size_t first = set.first, size = set.blocks * set.size;
  const Directions to = candidates_.directions(first);
  const LobeColumns out = candidates_.lobe_columns(first);
  simd::evaluate_microfacets(kind_of(patch.form), microfacet_of(patch.form), nullptr, lobe_of(node),
                             {mean_point_, mean_id_.data(), 1}, mean_member_.data(), to.dx, to.dy,
                             to.dz, size, out);
  const Visibility& visibility = visibility_[node.patch];
  const simd::CandidateQuery query{importance_.values(),
                                   importance_.inverse_total(),
                                   static_cast<float>(set.from_cells),
                                   static_cast<float>(set.from_lobe),
                                   1,
                                   {visibility.v.data(), visibility.sigma.data()}};
  float sums[3];
  simd::share_candidates({{out.f[0], out.f[1], out.f[2]},
                          &candidates_.radiance[first].x,
                          &candidates_.cell[first],
                          &candidates_.cell_density[first],
                          out.density},
                         query, size,
                         {{&ratio_[0][first], &ratio_[1][first], &ratio_[2][first]},
                          {&known_[0][first], &known_[1][first], &known_[2][first]},
                          &v_[first],
                          &sigma_[first]},
                         sums);
  set.mean = Rgb(sums[0], sums[1], sums[2]) / static_cast<float>(set.blocks);
}

}  // namespace kinome
