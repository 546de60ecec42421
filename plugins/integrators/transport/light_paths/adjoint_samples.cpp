#include "transport/light_paths/adjoint_samples.h"

#include "kinome/block_points.h"
#include "kinome/wide/surface_point.h"
#include "transport/light_paths/adjoint.h"

namespace kinome::transport {

using namespace wide;

AdjointSamples::AdjointSamples(size_t points)
    : arena_(points), sampled_(make_answer(arena_)), seen_(make_answer(arena_)) {}

/// Samples BSDFs that turn to the viewer, point by point.
void AdjointSamples::turn_to_viewers(const Surfaces& met, const Surfaces::Range& range,
                                     const float* u1, const Columns2& u2) {
  for (size_t i = range.first; i < range.first + range.count; ++i) {
    const SurfaceInteraction si = interaction_of(met.points(), i);
    const auto sample = sample_adjoint(si, Lobe::kAll, u1[i], u2.at(i));
    sampled_.sample_pdf[i] = sample ? 1.f : 0.f;
    if (!sample) continue;
    sampled_.is_delta[i] = sample->is_straight ? kNullSample : sample->is_delta ? 1.f : 0.f;
    sampled_.wo.set(i, si.frame.to_local(sample->to));
    sampled_.weight.set(i, sample->weight);
  }
}

/// Converts weights of refracted samples from radiance to power. Samples that go straight through
/// (Lobe::kNull) are not refracted.
void AdjointSamples::bend(const Surfaces& met, const Surfaces::Range& range) {
  const float eta = range.row->bsdf->relative_index();
  for (size_t i = range.first; i < range.first + range.count; i += kLanes) {
    const Float factor = power_over_radiance(Float::load(met.points().wi.z + i),
                                             Float::load(sampled_.wo.z + i), eta);
    const Mask is_bent = Float::load(sampled_.is_delta + i) == 1.f;
    (wide::Rgb::load(sampled_.weight, i) * select(is_bent, factor, Float(1.f)))
        .store(sampled_.weight, i);
  }
}

const BsdfAnswer& AdjointSamples::sample(const Surfaces& met, float* u1, const Columns2& u2) {
  const SurfaceBlock& points = met.points();
  shade(met, points.wi, {.u1 = u1, .u2 = u2}, sampled_);
  // The BSDF as evaluated by paths from the camera.
  shade(met, sampled_.wo, {.wo = points.wi}, seen_);
  for_lanes(met.reflecting(), [&](size_t i) {
    const FrameOf<wide::Vec3> frame = frame_at(points, i);
    const wide::Vec3 n = wide::Vec3::load(points.n, i);
    const wide::Vec3 from = frame.to_world(wide::Vec3::load(points.wi, i));
    const wide::Vec3 to = frame.to_world(wide::Vec3::load(sampled_.wo, i));
    const wide::Rgb seen = wide::Rgb::load(seen_.f, i) / Float::load(sampled_.sample_pdf + i);
    const Mask is_delta = Float::load(sampled_.is_delta + i) > 0.f;
    const wide::Rgb weight = select(is_delta, wide::Rgb::load(sampled_.weight, i), seen);
    (weight * adjoint_factor(dot(n, from), dot(n, to))).store(sampled_.weight, i);
  });
  for (const Surfaces::Range& range : met.ranges()) {
    if (range.first >= met.reflecting()) break;
    if (range.row->bsdf->turns_to_viewer()) {
      turn_to_viewers(met, range, u1, u2);
    } else if (range.row->bsdf->relative_index() != 1) {
      bend(met, range);
    }
  }
  return sampled_;
}

}  // namespace kinome::transport
