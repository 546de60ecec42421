// Light that paths through media find: emission, and emitter samples.

#include "kinome/wide/functions.h"
#include "kinome/wide/surface_point.h"
#include "transport/media/paths/volume_paths.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Weight of a sample of density a if another technique has density b; 1 if a is infinite.
KINOME_WIDE Float weight_against(Float a, Float b) {
  const Float ratio = b / a;
  return 1.f / (1.f + ratio * ratio);
}

}  // namespace

/// Adds the light of surfaces that emit.
void VolumePaths::add_emission(const Columns3& radiance) {
  const SurfaceBlock& points = met_.points();
  for (const Surfaces::Range& range : met_.ranges()) {
    if (!range.row->emitter) continue;
    const size_t first = range.first;
    const Columns3 to = radiance.from(range.row->group_offset);
    range.row->emitter->eval_surface_block(points.part(first, range.count), at_.from.from(first),
                                           light_.from(first), pdf_ + first);
    for_lanes(range.count, [&](size_t lane) {
      const size_t i = first + lane;
      const wide::Rgb light = wide::Rgb::load(light_, i);
      const Mask on = first_lanes(range.count - lane) & !is_black(light);
      const Float weight =
          weight_against(Float::load(at_.pdf + i), Float::load(pdf_ + i) * emitters_.pick_pdf());
      add_to_owners(wide::Rgb::load(at_.throughput, i) * light * weight, on, at_.owner + i, to);
    });
  }
}

/// Adds the light of the environment where rays leave the scene.
void VolumePaths::add_environment(const Columns3& radiance) {
  const auto missed = met_.missed();
  const Emitter* const environment = scene_.scene().environment();
  if (!environment || missed.empty()) return;
  for_lanes(missed.size(),
            [&](size_t i) { GatheredRays(rays_, missed.data() + i).d().store(missed_d_, i); });
  environment->eval_environment_block(missed_d_, missed.size(), missed_light_, missed_pdf_);
  const Columns3 to = radiance.from(scene_.environment_offset());
  alignas(kColumnAlignment) uint32_t owner[kLanes];
  for_lanes(missed.size(), [&](size_t i) {
    const Int k = Int::load(missed.data() + i);
    const wide::Rgb light =
        gather(along_.throughput, k) * wide::Rgb::load(missed_light_, i) *
        weight_against(gather(along_.pdf, k), Float::load(missed_pdf_ + i) * emitters_.pick_pdf());
    Mask on = first_lanes(missed.size() - i) & !is_black(light);
    if (hides_emitters_) on &= gather(along_.scatterings, k) > 0.f;
    gather(along_.owner, k).store(owner);
    add_to_owners(light, on, owner, to);
  });
}

void VolumePaths::sample_emitters(const PixelSamples& samples, uint32_t dimension, size_t count) {
  if (!choice_) {
    return emitters_.sample(sampler_, samples, dimension, met_.points(), at_.owner, count,
                            numbers_);
  }
  for (const Surfaces::Range& range : met_.ranges()) {
    const size_t first = range.first, padded_count = padded(range.count);
    if (first >= count) return;
    const bool is_found = is_found_elsewhere(range);
    if (is_found && !choice_->has_scattered_light()) continue;
    const uint32_t medium = medium_of(range);
    const LightChoice::Paths paths{at_.from.from(first), at_.pdf + first, at_.scatterings + first,
                                   !is_found};
    choice_->sample(sampler_, samples, dimension, met_.points().part(first, padded_count), medium,
                    at_.owner + first, padded_count, paths, numbers_, sampled_.from(first),
                    weight_pdf_ + first);
    if (medium == MediaTable::kVacuum) continue;
    for_lanes(padded_count, [&](size_t lane) {
      float* const pdf = weight_pdf_ + first + lane;
      (Float::load(pdf) * LightChoice::kMediumShare).store(pdf);
    });
  }
}

/// True if the caller of trace_from() finds the light of emitter samples at the points.
bool VolumePaths::is_found_elsewhere(const Surfaces::Range& range) const {
  const uint32_t medium = medium_of(range);
  return first_share_ > 0 && medium != MediaTable::kVacuum && media_.emitter_weight(medium) == 1;
}

/// Returns the index into columns of radiance that the light of each emitter sample belongs to.
const uint32_t* VolumePaths::emitter_destinations(size_t count) {
  if (scene_.light_groups() == 0) return at_.owner;
  for_lanes(count, [&](size_t i) {
    const Int emitter = Int::load(emitters_.picked() + i);
    const Int offset = as_int(gather(scene_.group_offsets(), emitter));
    (Int::load(at_.owner + i) + offset).store(destination_ + i);
  });
  return destination_;
}

void VolumePaths::add_emitter_samples(const RandomSeeds& seeds, const Columns3& radiance,
                                      RenderCounters& counters) {
  const size_t count = met_.scattering();
  if (count == 0) return;
  const SurfaceBlock& points = met_.points();
  const DirectBlock& sampled = light();
  const Float last = static_cast<float>(length_.max_depth) - 1.f;
  size_t rays = 0;
  for_lanes(count, [&](size_t i) {
    const Float pdf = Float::load(sampled.pdf + i) * (choice_ ? 1 : emitters_.pick_pdf());
    const Float weight_pdf = choice_ ? Float::load(weight_pdf_ + i) : pdf;
    const Mask is_delta = Float::load(sampled.is_delta + i) > 0.f;
    const Float weight =
        select(is_delta, Float(1.f), weight_against(weight_pdf, Float::load(answer_.pdf + i)));
    const Float times = Float::load(emitter_weight_ + i);
    const wide::Rgb light = wide::Rgb::load(at_.throughput, i) * wide::Rgb::load(answer_.f, i) *
                            wide::Rgb::load(sampled.radiance, i) * (abs(times) * weight / pdf);
    const Mask on = (Float::load(met_.live() + i) > 0.f) & !(pdf <= 0.f) & !is_black(light) &
                    (Float::load(at_.scatterings + i) < last) &
                    ((times > 0.f) | (is_delta & (times < 0.f)));
    rays += wide::count(on);
    select(on, light).store(light_, i);
    write_shadow_rays(points, i, wide::Vec3::load(sampled.d, i), Float::load(sampled.distance + i),
                      on, true, shadow_rays_);
  });
  counters.skipped_shadow_rays += met_.live_reflecting() - rays;
  if (rays == 0) return;
  const StageTimer timer(counters.stage_seconds["shadow"]);
  find_media(count, sampled.d, medium_);
  shadows_.trace(shadow_rays_, count, medium_, sampled.distance, at_.owner, seeds, counters);
  const uint32_t* const destination = emitter_destinations(count);
  for_lanes(count, [&](size_t i) {
    const wide::Rgb transmittance = wide::Rgb::load(shadows_.transmittance(), i);
    add_to_owners(wide::Rgb::load(light_, i) * transmittance, !is_black(transmittance),
                  destination + i, radiance);
  });
}

}  // namespace kinome::transport
