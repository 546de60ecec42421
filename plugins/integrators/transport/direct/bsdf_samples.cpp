// Light that the BSDF samples of DirectLight find.

#include "kinome/wide/surface_point.h"
#include "transport/direct/direct_light.h"
#include "transport/direct/weights.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

void DirectLight::find_directions(const Vertices& vertices) {
  const SurfaceBlock& points = vertices.surfaces->points();
  for_lanes(vertices.surfaces->reflecting(), [&](size_t i) {
    frame_at(points, i).to_world(wide::Vec3::load(answer_.wo, i)).store(d_, i);
  });
}

/// Adds the environment's light where BSDF rays leave the scene. Testing occlusion is enough if no
/// surface emits.
void DirectLight::add_environment(const Vertices& vertices, const Columns3& radiance,
                                  RenderCounters& counters) {
  const Surfaces& surfaces = *vertices.surfaces;
  const size_t count = surfaces.reflecting();
  size_t rays = 0;
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    find_directions(vertices);
    scene_.scene().environment()->eval_environment_block(d_, count, hit_radiance_,
                                                         count_.emitter > 0 ? hit_pdf_ : nullptr);
    for (size_t i = 0; vertices.shown_share && i < count; ++i) {
      if (is_shown(vertices, i))
        hit_radiance_.set(i, hit_radiance_.at(i) * shown_share(vertices, i));
    }
    for (size_t i = 0; vertices.straight && i < count; ++i) {
      if (vertices.straight[vertices.owner[i]] > 0) hit_radiance_.set(i, kinome::Rgb(0.f));
    }
    const float n_emitter = static_cast<float>(count_.emitter) * emitters_.pick_pdf();
    const float n_bsdf = static_cast<float>(count_.bsdf);
    const bool has_origins = vertices.origins.pdf;
    const float* const pdfs = has_origins ? passing_->next.pdf : answer_.sample_pdf;
    for_lanes(count, [&](size_t i) {
      Float weight = 1.f;
      if (count_.emitter > 0) {
        const Float pdf = Float::load(pdfs + i);
        const Mask is_alone =
            has_origins ? pdf >= kPdfBeyondPasses : Float::load(answer_.is_delta + i) > 0.f;
        weight = select(is_alone, weight,
                        power_heuristic(pdf * n_bsdf, Float::load(hit_pdf_ + i) * n_emitter));
      }
      const wide::Rgb carried = wide::Rgb::load(carried_, i);
      const wide::Rgb light = carried * wide::Rgb::load(hit_radiance_, i) * weight;
      const Mask on = is_live(surfaces, i) & !is_black(carried) & !is_black(light);
      rays += wide::count(on);
      select(on, light).store(light_, i);
      write_shadow_rays(surfaces.points(), i, wide::Vec3::load(d_, i), Float(kInfinity), on, false,
                        rays_);
    });
  }
  counters[RayKind::kBsdf] += rays;
  counters.skipped_shadow_rays += surfaces.live_reflecting() - rays;
  add_arriving(vertices.owner, count, false, radiance.from(scene_.environment_offset()), counters);
}

void DirectLight::make_bsdf_rays(const Vertices& vertices, RenderCounters& counters) {
  const Surfaces& surfaces = *vertices.surfaces;
  const size_t count = surfaces.reflecting();
  find_directions(vertices);
  size_t valid = 0;
  for_lanes(count, [&](size_t i) {
    const Mask live = is_live(surfaces, i);
    valid += wide::count(live & !(Float::load(answer_.sample_pdf + i) <= 0.f) &
                         !is_black(wide::Rgb::load(answer_.weight, i)));
    write_shadow_rays(surfaces.points(), i, wide::Vec3::load(d_, i), Float(kInfinity),
                      live & !is_black(wide::Rgb::load(carried_, i)), false, rays_);
  });
  // If only some lobes are sampled, points without these lobes need no ray.
  if (count_.lobes == Lobe::kAll) counters.skipped_shadow_rays += surfaces.live_reflecting() - valid;
}

void DirectLight::trace(const Vertices& vertices, Surfaces::Which which, const Columns3& radiance,
                        RenderCounters& counters) {
  size_t on = 0;
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    if (!traced_) traced_ = std::make_unique<Traced>(scene_, max_points_, max_rays_);
    make_bsdf_rays(vertices, counters);
    on = traced_->sort.sort(rays_, vertices.surfaces->reflecting());
    traced_->sort.copy(&traced_->rays[0].ray, sizeof(RayHit16));
    clear_hits(traced_->rays, on);
  }
  counters[RayKind::kBsdf] += on;
  const StageTimer timer(counters.stage_seconds["bounce"]);
  scene_.scene().intersect(traced_->rays, padded(on) / kBlockLanes, Coherence::kIncoherent,
                           counters);
  current_ = 1 - current_;
  traced_->met[current_].find(traced_->rays, on, which);
  add_hit_emitters(vertices, radiance);
  if (scene_.scene().environment()) add_missed_environment(vertices, radiance);
  if (vertices.shown_share) update_shown_shares(vertices);
}

void DirectLight::update_shown_shares(const Vertices& vertices) const {
  const float* const live = vertices.surfaces->live();
  for (size_t i = 0; i < vertices.surfaces->reflecting(); ++i) {
    // Padding has a point's owner, but no valid sample.
    if (!(live[i] > 0) || answer_.is_delta[i] > 0) continue;
    const uint32_t owner = vertices.owner[i];
    vertices.shown_share[owner] = vertices.shown_share_later[owner];
  }
}

/// True if a delta lobe shows the light that the BSDF sample of a point finds.
bool DirectLight::is_shown(const Vertices& vertices, size_t point) const {
  if (vertices.origins.pdf) return passing_->next.pdf[point] == kInfinity;
  return answer_.is_delta[point] > 0;
}

float DirectLight::shown_share(const Vertices& vertices, size_t point) const {
  return vertices.shown_share ? vertices.shown_share[vertices.owner[point]] : 1.f;
}

float DirectLight::bsdf_weight(const Vertices& vertices, uint32_t point, float emitter_pdf) const {
  const bool has_origins = vertices.origins.pdf;
  const float share = is_shown(vertices, point) ? shown_share(vertices, point) : 1;
  const float pdf = has_origins ? passing_->next.pdf[point] : answer_.sample_pdf[point];
  const bool is_alone = has_origins ? pdf >= kPdfBeyondPasses : answer_.is_delta[point] > 0;
  if (is_alone || count_.emitter == 0) return share;
  return share *
         power_heuristic(pdf * static_cast<float>(count_.bsdf),
                         emitter_pdf * emitters_.pick_pdf() * static_cast<float>(count_.emitter));
}

void DirectLight::add_hit_emitters(const Vertices& vertices, const Columns3& radiance) {
  const SurfaceBlock& met = this->met().points();
  const uint32_t* const from = traced_->sort.order();
  const Columns3& from_p = vertices.origins.pdf ? passing_->next.p : vertices.surfaces->points().p;
  for (const Surfaces::Range& range : this->met().ranges()) {
    if (!range.row->emitter) continue;
    const size_t first = range.first;
    const Columns3 to = radiance.from(range.row->group_offset);
    for (size_t i = first; i < first + padded(range.count); ++i) {
      from_p_.set(i, from_p.at(from[met.ray[i]]));
    }
    range.row->emitter->eval_surface_block(met.part(first, range.count), from_p_.from(first),
                                           hit_radiance_.from(first), hit_pdf_ + first);
    for (size_t i = first; i < first + range.count; ++i) {
      const uint32_t k = from[met.ray[i]];
      const kinome::Rgb light = hit_radiance_.at(i);
      if (is_black(light)) continue;
      const uint32_t owner = vertices.owner[k];
      to.set(owner, to.at(owner) + carried_.at(k) * light * bsdf_weight(vertices, k, hit_pdf_[i]));
    }
  }
}

void DirectLight::add_missed_environment(const Vertices& vertices, const Columns3& radiance) {
  const auto missed = met().missed();
  const uint32_t* const from = traced_->sort.order();
  const Columns3 to = radiance.from(scene_.environment_offset());
  for (size_t i = 0; i < missed.size(); ++i) from_p_.set(i, d_.at(from[missed[i]]));
  scene_.scene().environment()->eval_environment_block(from_p_, missed.size(), hit_radiance_,
                                                       count_.emitter > 0 ? hit_pdf_ : nullptr);
  for (size_t i = 0; i < missed.size(); ++i) {
    const uint32_t k = from[missed[i]];
    const uint32_t owner = vertices.owner[k];
    if (vertices.straight && vertices.straight[owner] > 0) continue;
    const float weight = bsdf_weight(vertices, k, count_.emitter > 0 ? hit_pdf_[i] : 0);
    to.set(owner, to.at(owner) + carried_.at(k) * hit_radiance_.at(i) * weight);
  }
}

}  // namespace kinome::transport
