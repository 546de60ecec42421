#include "clustered/product/strata/estimator.h"

#include <optional>

#include "clustered/product/paths/mirrored_direction.h"

namespace kinome {
namespace {

/// Random numbers derived from a unit's seed.
enum UnitSeed : uint32_t {
  kCombOffset = 1,
  kTurns,
  kMirrors,
  kCandidates,
  kEyeRays,
  kFirstBlock,
  kLampNumbers,
  kPaths
};
/// Random numbers derived from a tile's seed.
constexpr uint64_t kShared = 1, kEyeBlock = 2;

/// Adds the control term of the candidates that `stage` has just added for the group.
template <class Stage>
void add_control(const Stage& stage, const GroupView& group, const Rgb& control,
                 const UnitSums& sums) {
  if (sums.is_split) {
    stage.split(group, control, sums);
  } else if (sums) {
    *sums.first += control;
  }
}

/// Samples a direction by the delta lobes. The weight of the result is the light of the sky that
/// the point sends to the viewer.
std::optional<MirroredDirection> mirrored_sky(const CellLight& light, const SurfaceInteraction& si,
                                              uint32_t primary, uint64_t seed) {
  auto mirrored = mirrored_direction(si, primary, seed);
  if (!mirrored) return std::nullopt;
  mirrored->weight *=
      light.environment ? light.environment->eval_environment(mirrored->d) : Rgb(0.f);
  return mirrored;
}

}  // namespace

Estimator::Estimator(const CellLight& light)
    : light_(light),
      diffuse_(light),
      glossy_(light),
      local_(light, choice_),
      eye_rays_(light),
      shadow_rays_(times_, light.passing(),
                   passes_left(light.local ? light.local->max_depth() : 2, 2)) {}

void Estimator::begin_tile(const Scene& scene, const TilePrimaries& primaries,
                           std::span<Patch> patches, std::span<const Visibility> visibility,
                           uint64_t seed, RenderCounters& counters, std::span<const Unit> units) {
  scene_ = &scene;
  counters_ = &counters;
  primaries_ = &primaries;
  patches_ = patches;
  visibility_ = visibility;
  if (units.empty()) {
    times_.stop_counting();  // a pilot, which is a stage of its own
  } else {
    times_.count_to(counters);
  }
  shadow_rays_.begin(scene, counters);
  diffuse_.begin_tile(patches.size(), seed);
  {
    const StageScope timer = times_.scope(StageTimes::kCandidates);
    glossy_.begin_tile(primaries, patches, visibility, units, hash_words(seed, kShared));
  }
  if (!has_local() || patches.empty()) return;
  choice_.choose(*light_.local, light_.local_points, patches, visibility.first(patches.size()),
                 light_.first_local(), primaries.size(), seed);
  eye_rays_.begin_tile(scene, choice_, hash_words(seed, kEyeBlock), counters);
}

void Estimator::add_diffuse(const GroupView& group, const UnitSums& sums) {
  if (!diffuse_.applies(group)) return;
  const StageScope timer = times_.scope(StageTimes::kStrata);
  const Rgb control = diffuse_.add(group, strata_);
  if (sums.is_split) {
    diffuse_.split(group, sums);
  } else if (sums) {
    *sums.first += control;
  }
}

/// Adds the group's share of the unit's candidates, in proportion to its number of points. A pilot
/// has its own numbers of candidates.
void Estimator::add_glossy(const GroupView& group, const Unit& unit, const UnitSums& sums,
                           std::span<PointPlan> points) {
  if (!glossy_.applies(group)) return;
  const StageScope timer = times_.scope(StageTimes::kCandidates);
  const uint64_t seed = hash_words(unit.seed, kCandidates, group.index);
  if (!points.empty()) {
    glossy_.add(group, GlossyStrata::pilot_counts(group.patch), seed, strata_);
    glossy_.plan(group, patches_[group.group.patch], points);
    return;
  }
  const float wanted = unit.candidates * static_cast<float>(group.group.count) /
                       static_cast<float>(groups_.order().size());
  const Rgb control = glossy_.add(group, wanted, seed, strata_);
  add_control(glossy_, group, control, sums);
}

/// The pilot assumes one eye ray for each primary, but sends none.
void Estimator::add_local(const GroupView& group, const Unit& unit, const UnitSums& sums,
                          std::span<PointPlan> points) {
  if (!has_local() || !LocalStrata::applies(group)) return;
  const StageScope timer = times_.scope(StageTimes::kCandidates);
  const LocalStrata::Numbers numbers{random_bits(unit.seed, kFirstBlock) - unit.first,
                                     hash_words(unit.seed, kLampNumbers)};
  const float eye_rays = points.empty() ? expected_eye_rays(group.patch, *light_.local) : 1;
  const Rgb control = local_.add(group, eye_rays, numbers, strata_);
  if (!points.empty()) local_.plan(group, patches_[group.group.patch], points);
  if (sums && light_.groups) {
    local_.split(group, control, sums);
  } else {
    add_control(local_, group, control, sums);
  }
}

/// Adds the strata of all groups of a unit. Adds their control terms to `sums` and the plan's input
/// to `points`, unless these are empty.
void Estimator::add_strata(const Unit& unit, const UnitSums& sums, std::span<PointPlan> points) {
  groups_.divide(*primaries_, patches_, unit.first, unit.end);
  strata_.clear();
  diffuse_.begin_unit();
  glossy_.begin_unit();
  local_.begin_unit();
  const UnitSums of_sky = sums.of_group(light_.sky_group);
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    const GroupView group = view(g);
    add_diffuse(group, of_sky);
    add_glossy(group, unit, of_sky, points);
    add_local(group, unit, sums, points);
  }
}

/// Makes the unit's shadow rays.
void Estimator::shoot(const Unit& unit, const Answers& answers) {
  if (unit.rays == 0) return;
  const StageScope timer = times_.scope(StageTimes::kComb);
  const uint32_t turn = random_bits(unit.seed, kTurns);
  Answers of_sky = answers;
  of_sky.sums = answers.sums.of_group(light_.sky_group);
  const auto shoot_segment = [&](const SegmentHits& hits) {
    const GroupView group = view(hits.segment.group);
    switch (hits.segment.kind) {
      case Strata::Kind::kDiffuse:
        diffuse_.shoot(group, hits, turn, of_sky, shadow_rays_);
        break;
      case Strata::Kind::kGlossy:
        glossy_.shoot(group, hits, of_sky, shadow_rays_);
        break;
      case Strata::Kind::kLocal:
        local_.shoot(group, hits, answers, shadow_rays_);
        break;
    }
  };
  comb_.walk(strata_, unit.rays, random_float(unit.seed, kCombOffset), shoot_segment);
}

/// Calls fn(primary) for each primary whose BSDF has a delta lobe.
template <class Function>
void Estimator::for_each_mirroring(const Function& fn) const {
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    const GroupView group = view(g);
    if (!group.has(Lobe::kDelta)) continue;
    for (uint32_t k = 0; k < group.group.count; ++k) fn(group.primary(k));
  }
}

void Estimator::send_eye_rays(const Unit& unit, const UnitSums& sums) {
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    const GroupView group = view(g);
    if (!eye_rays_.applies(group)) continue;
    const StageScope timer = times_.scope(StageTimes::kCandidates);
    eye_rays_.send(group, expected_eye_rays(group.patch, *light_.local),
                   hash_words(unit.seed, kEyeRays), sums);
  }
  const uint64_t seed = hash_words(unit.seed, kMirrors);
  for_each_mirroring([&](uint32_t i) {
    eye_rays_.send_mirrored(primaries_->interaction(i), i, seed, sums.of(i));
  });
}

/// Makes shadow rays by delta lobes, for scenes without local light.
void Estimator::shoot_mirrored(uint64_t seed, const UnitSums& sums) {
  for_each_mirroring([&](uint32_t i) {
    const SurfaceInteraction si = primaries_->interaction(i);
    const auto mirrored = mirrored_sky(light_, si, i, seed);
    if (!mirrored) return;
    shadow_rays_.push(si, mirrored->d, {mirrored->weight, 0, primaries_->patch(i), i}, {sums});
  });
}

/// Continues primaries as paths of `path`, for which TilePrimaries::goes_on() is true. Cells and
/// light points describe only the light that reaches one side of a surface.
template <class SumOf>
void Estimator::follow_paths(const Unit& unit, const SumOf& sum_of) {
  for (uint32_t i = unit.first; i < unit.end; ++i) {
    if (!primaries_->goes_on(i)) continue;
    if (!paths_) paths_.emplace(*scene_, light_.paths, 0, nullptr, light_.groups);
    EyePaths::Begin path;
    path.ray = primaries_->last_part(i);
    path.throughput = Rgb(1.f);
    path.seed = hash_words(unit.seed, kPaths, i);
    path.sum = sum_of(i);
    paths_->push(path);
  }
}

void Estimator::estimate(const Unit& unit, const UnitSums& sums) {
  follow_paths(unit, [&](uint32_t i) { return &sums.of(i); });
  add_strata(unit, sums, {});
  if (groups_.empty()) return;
  shoot(unit, {sums});
  if (has_local()) {
    send_eye_rays(unit, sums);
  } else {
    shoot_mirrored(hash_words(unit.seed, kMirrors), sums.of_group(light_.sky_group));
  }
}

void Estimator::probe(const Unit& unit, std::span<PointPlan> points,
                      std::span<std::vector<VisibilityRecord>> records) {
  times_.stop_counting();
  const Answers answers{{}, records.data(), points.data()};
  follow_paths(unit, [&](uint32_t i) { return points[i].followed; });
  add_strata(unit, {}, points);
  if (groups_.empty()) return;
  shoot(unit, answers);
  const uint64_t seed = hash_words(unit.seed, kMirrors);
  for_each_mirroring([&](uint32_t i) {
    const auto mirrored = mirrored_sky(light_, primaries_->interaction(i), i, seed);
    if (mirrored) points[i].mirrored = mean_of(mirrored->weight);
  });
}

void Estimator::flush() {
  if (paths_) {
    const StageScope timer = times_.scope(StageTimes::kEyeRays);
    paths_->trace(*counters_);
  }
  if (!eye_rays_.empty()) {
    const StageScope timer = times_.scope(StageTimes::kEyeRays);
    eye_rays_.trace(shadow_rays_);
  }
  shadow_rays_.trace();
}

}  // namespace kinome
