// The part of LocalLight that leaves light points where walks hit surfaces.

#include <cmath>
#include <optional>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/patches.h"

namespace kinome {

/// The hit of a walk, with quantities that are computed when they are first needed.
struct LocalLight::Landing {
  const LocalLight& local;
  const LightWalk& walk;
  const SurfaceInteraction& si;
  const Source& source = local.sources_[walk.origin.source];
  float side = si.wi.z >= 0 ? 1.f : -1.f;
  bool is_deep = !walk.is_direct;
  /// False for draws that guides and cells are made from. These need no cells and eye ratios.
  bool has_cells = local.bounce_partition_.size() > 0;

  const SurfaceInteraction* x() const { return walk.x ? &*walk.x : nullptr; }
  LobeWidth width() {
    if (!width_) width_ = lobe_width(si);
    return *width_;
  }
  /// Probability of the walk's source at the hit.
  float probability() {
    if (!probability_) probability_ = local.asked_at(si, side).probability(walk.origin.source);
    return *probability_;
  }

  std::optional<LobeWidth> width_ = std::nullopt;
  std::optional<float> probability_ = std::nullopt;
};

/// Sets the reflection of a surface that isn't Lambertian. Returns the power of its light point,
/// which is 0 if light hits the back of a one-sided surface.
Rgb LocalLight::reflect(Landing& at, Reflection& reflection, Drawn& out) const {
  const LightWalk& walk = at.walk;
  const SurfaceInteraction& si = at.si;
  const Bsdf& bsdf = si.shape->bsdf();
  const Vec3 normal = bsdf.reflection_frame(si).n;
  if (!(glm::dot(normal, -walk.d) > 0)) return Rgb(0.f);
  const bool is_lamp = at.source.kind == Kind::kLamp && !at.is_deep;
  const LobeWidth width = is_lamp && !finds_caustics_ ? LobeWidth::kWide : at.width();
  LobeReflectance part = bsdf.reflectance(reflection.si);
  bool is_left_to_rays = false;
  if (width == LobeWidth::kMirroring) {
    (is_lamp ? out.lamp_meets_mirroring : out.meets_mirroring) = true;
    is_left_to_rays = !is_lamp || has_glossy_caustics_;
  }
  if (is_left_to_rays) {
    reflection.lobes = Lobe::kDiffuse;
    part.glossy = Rgb(0.f);
  } else {
    const simd::HalfVectorLobe lobe = glossy_lobe(si, bsdf.form(si));
    reflection.lobe.alpha2 = lobe.alpha_u * lobe.alpha_v;
    if (width == LobeWidth::kNarrow && !is_lamp && at.has_cells) {
      reflection.light_density =
          at.is_deep ? kDeepDensity
                     : at.probability() * arrival_density(*at.source.emitter, at.x(), si, -walk.d);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    reflection.lobe.normal[axis] = normal[axis];
    reflection.lobe.light[axis] = -walk.d[axis];
  }
  reflection.lobe.diffuse = mean_of(part.diffuse);
  reflection.lobe.glossy = mean_of(part.glossy);
  return (part.diffuse + part.glossy) * kInvPi * std::abs(si.wi.z) * reflection.incident;
}

/// Leaves a light point at the hit of a walk.
void LocalLight::land(const LightWalk& walk, const SurfaceInteraction& si, float distance,
                      Drawn& out) const {
  const Bsdf& bsdf = si.shape->bsdf();
  if (walk.is_hidden || !any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return;
  const float cosine = std::abs(glm::dot(si.n, walk.d));
  if (!(cosine > 0)) return;
  Landing at{*this, walk, si};
  const float count =
      static_cast<float>(bounce_count_) * at.source.bounce_share * walk.origin.guided;
  Reflection reflection;
  reflection.si = si;
  reflection.to_light = si.wi;
  reflection.incident = walk.power / (count * cosine);
  // The reflectance is evaluated for a viewer on the light's side.
  reflection.si.wi = Vec3(0, 0, at.side);
  LightPoint point;
  point.power = bsdf.is_lambertian()
                    ? bsdf.eval_pdf(reflection.si, Lobe::kDiffuse, reflection.to_light).f *
                          reflection.incident
                    : reflect(at, reflection, out);
  if (is_black(point.power)) return;
  point.edges = walk.edges;
  point.is_plain = at.has_cells && is_plain(si, at.width());
  point.is_shown = walk.is_shown;
  point.group = at.source.group;
  // The point is off the surface, because a ray at grazing angle would hit the surface just before
  // its end otherwise.
  point.position = si.ray_origin(-walk.d);
  point.normal = si.frame.n * at.side;
  point.geometric = glm::dot(si.n, walk.d) > 0 ? -si.n : si.n;
  if (std::abs(glm::dot(si.n, si.frame.n)) < 1 - 1e-6f) point.off_surface = si.p_error;
  if (at.has_cells) {
    point.cell = bounce_cell(si, at.side);
    point.eye_ratio =
        at.is_deep ? deep_ratios_[point.cell]
                   : eye_factors_[point.cell] *
                         eye_ratio(at.source, at.probability(), at.x(), si, walk.d, distance);
    if (walk.is_shown && at.width() == LobeWidth::kWide) point.eye_ratio *= kShownEyeShare;
  }
  if (!bsdf.is_lambertian()) {
    point.reflection = static_cast<uint32_t>(out.reflections.size());
    out.reflections.push_back(reflection);
  }
  out.points.push_back(point);
  out.origins.push_back(walk.origin);
  out.is_deep.push_back(at.is_deep ? 1 : 0);
  out.walk_of.push_back(walk.seed);
}

}  // namespace kinome
