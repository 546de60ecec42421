#include "clustered/product/rays/shadow_rays.h"

#include <algorithm>

#include "clustered/product/tiles/spread.h"

namespace kinome {

ShadowRays::ShadowRays(StageTimes& times, const transport::SceneTable* passing, uint32_t max_passes)
    : times_(times),
      max_passes_(max_passes),
      rays_(kRaysPerCall),
      pending_(kRaysPerCall),
      lit_(kRaysPerCall) {
  if (passing) straight_.emplace(*passing, kRaysPerCall);
}

void ShadowRays::trace() {
  if (waiting_ == 0) return;
  const StageScope timer = times_.scope(StageTimes::kShadow);
  if (straight_) {
    trace_straight();
  } else {
    scene_->occluded({rays_.data(), waiting_}, Coherence::kIncoherent, *counters_);
    (*counters_)[RayKind::kShadow] += waiting_;
    for (size_t i = 0; i < waiting_; ++i) answer(i, !rays_[i].is_occluded(), Rgb(1.f));
  }
  waiting_ = 0;
}

void ShadowRays::trace_straight() {
  for (size_t i = 0; i < waiting_; ++i) {
    straight_->set(i, rays_[i], std::min(pending_[i].max_passes, max_passes_));
  }
  straight_->trace(waiting_, *counters_);
  for (size_t i = 0; i < waiting_; ++i) {
    const Rgb transmittance = straight_->transmittance(i);
    answer(i, !is_black(transmittance), transmittance);
  }
}

void ShadowRays::answer(size_t i, bool visible, const Rgb& transmittance) {
  const Pending& p = pending_[i];
  if (p.records) {
    const float share = visible ? std::clamp(mean_of(transmittance), 0.f, 1.f) : 0.f;
    p.records->push_back(VisibilityRecord(p.cell, share));
    if (visible && lit_[i].sum) *lit_[i].sum += lit_[i].radiance * share;
  } else if (visible) {
    *p.sum += p.weight * transmittance;
  }
}

}  // namespace kinome
