// Stratified sampling: sample_count = n² strata in a pixel, a sample each, jittered. The order of
// the strata is a random permutation for each dimension and pixel, so that dimensions stay
// independent. After n² samples another stratification follows. Without `jitter`, each lies in the
// middle of its stratum.
//
//   <sampler type="stratified"><integer name="sample_count" value="64"/></sampler>

#include <memory>

#include "kinome/plugin.h"
#include "strata.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS, kJitter};

uint32_t side_for(uint32_t count) {
  uint32_t side = 1;
  while (side * side < count) ++side;
  return side;
}

class Stratified : public Sampler {
 public:
  explicit Stratified(const Properties& props)
      : Stratified(read_sample_count(props), static_cast<uint64_t>(props.integer("seed")),
                   props.boolean("jitter")) {
    warn_if_rounded(props, read_sample_count(props), sample_count_);
  }
  Stratified(uint32_t count, uint64_t seed, bool jitters)
      : side_(side_for(count)), jitters_(jitters) {
    sample_count_ = side_ * side_;
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    const StratumPlace place = stratum_of(key, sample_count_, dimension ^ kOneDimension, jitters_);
    return in_stratum(place.stratum, place.jitter.x, sample_count_);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    const StratumPlace place = stratum_of(key, sample_count_, dimension ^ kTwoDimensions, jitters_);
    return {in_stratum(place.stratum % side_, place.jitter.x, side_),
            in_stratum(place.stratum / side_, place.jitter.y, side_)};
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Stratified>(count, seed_, jitters_);
  }

 private:
  uint32_t side_;
  bool jitters_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Stratified, kinome::Category::kSampler, "stratified",
              "Jittered samples in a square number of strata.", kinome::kTable);
