#include "clustered/product/shadow_rays.h"

namespace kinome {
namespace {

/// Rays of one call to Embree: what fits the caches.
constexpr size_t kBatch = 2048;

}  // namespace

ShadowRays::ShadowRays(StageTimes& times)
    : times_(times), rays_(kBatch), pending_(kBatch), lit_(kBatch) {}

void ShadowRays::trace() {
  if (waiting_ == 0) return;
  const StageScope timer = times_.scope(StageTimes::kShadow);
  scene_->occluded({rays_.data(), waiting_}, Coherence::kIncoherent, *counters_);
  (*counters_)[RayKind::kShadow] += waiting_;
  for (size_t i = 0; i < waiting_; ++i) {
    const bool visible = !rays_[i].is_occluded();
    const Pending& p = pending_[i];
    if (p.records) {
      p.records->push_back(VisibilityRecord(p.cell, visible));
      if (visible && lit_[i].sum) *lit_[i].sum += lit_[i].radiance;
    } else if (visible) {
      *p.sum += p.weight;
    }
  }
  waiting_ = 0;
}

}  // namespace kinome
