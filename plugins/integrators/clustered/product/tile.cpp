#include "clustered/product/tile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clustered/cells/hilbert_points.h"
#include "clustered/product/spread.h"
#include "kinome/owen.h"

namespace kinome {
namespace {

/// Points of one patch have normals within this cosine of the first one's.
constexpr float kPatchCosine = 0.95f;
/// The cone of a pilot's normals, which later primaries are to fit, is widened by this.
constexpr float kConeFactor = 1.3f;
constexpr float kConeMargin = 0.0175f;
/// Distances from the plane, in widths of the tile.
constexpr float kPlaneWidths = 1;
constexpr size_t kMaxPatches = 48;
/// What is dark along the azimuth that is probed may be bright along another: no cell is left
/// without rays.
constexpr float kLeastTransmittance = 0.1f;
/// Random directions that tell a lobe's width.
constexpr size_t kLobeProbes = 31;

/// Half of the slopes of GGX's half vectors along an axis lie within alpha / sqrt 3.
simd::HalfVectorLobe probe_lobe(const Bsdf& bsdf, const SurfaceInteraction& si) {
  if (!any(bsdf.lobes() & Lobe::kGlossy)) return {1, 1};
  const Vec3 viewer = si.frame.to_world(si.wi);
  const Frame frame = bsdf.reflection_frame(si);
  std::array<float, kLobeProbes> along, across;
  size_t count = 0;
  const auto points = HilbertPoints::get().power_of_two(5);
  for (size_t i = 0; i < kLobeProbes; ++i) {
    const Vec2 u = points[i].shifted(0x40000000u, 0x20000000u);
    const auto sample = bsdf.sample(si, Lobe::kGlossy, 0.5f, u);
    if (!sample) continue;
    const Vec3 h = frame.to_local(viewer + si.frame.to_world(sample->wo));
    along[count] = std::abs(h.x) / std::max(h.z, 1e-4f);
    across[count++] = std::abs(h.y) / std::max(h.z, 1e-4f);
  }
  if (count == 0) return {1, 1};
  const auto width = [count](std::array<float, kLobeProbes>& slopes) {
    const auto middle = slopes.begin() + static_cast<ptrdiff_t>(count / 2);
    std::nth_element(slopes.begin(), middle, slopes.begin() + static_cast<ptrdiff_t>(count));
    return std::clamp(std::numbers::sqrt3_v<float> * *middle, 2e-4f, 1.f);
  };
  return {width(along), width(across)};
}

void probe_transmittance(const SurfaceInteraction& si, Patch& patch) {
  constexpr int kSteps = BsdfForm::kTableSize;
  const Frame frame = Frame::from_normal(patch.normal);
  float x[kSteps], y[kSteps], z[kSteps], r[kSteps], g[kSteps], b[kSteps];
  const auto cosine_of = [](int k) { return std::max(static_cast<float>(k), 0.5f) / (kSteps - 1); };
  for (int k = 0; k < kSteps; ++k) {
    const float cosine = cosine_of(k);
    const Vec3 d = si.frame.to_local(frame.n * cosine + frame.s * safe_sqrt(1 - cosine * cosine));
    x[k] = d.x;
    y[k] = d.y;
    z[k] = d.z;
  }
  patch.bsdf->eval_pdf(si, Lobe::kDiffuse, {x, y, z, kSteps}, {r, g, b, nullptr});
  std::array<float, kSteps> probed;
  for (int k = 0; k < kSteps; ++k) {
    const float lambertian = mean_of(patch.diffuse) * kInvPi * cosine_of(k);
    const float factor = mean_of({r[k], g[k], b[k]}) / lambertian;
    probed[k] = std::clamp(factor, kLeastTransmittance, 4.f);
  }
  patch.probed = std::make_shared<const std::array<float, kSteps>>(probed);
}

}  // namespace

FilterSampler::FilterSampler(const ReconstructionFilter& filter) : radius_(filter.radius()) {
  cumulated_.resize(kBins + 1);
  double sum = 0;
  is_box_ = true;
  for (int i = 0; i < kBins; ++i) {
    const float x = radius_ * (2 * (static_cast<float>(i) + 0.5f) / kBins - 1);
    const float value = std::max(0.f, filter.eval(x));
    is_box_ = is_box_ && value == filter.eval(0);
    sum += value;
    cumulated_[i + 1] = static_cast<float>(sum);
  }
  for (float& c : cumulated_) c = static_cast<float>(c / sum);
}

float FilterSampler::cumulated(float offset) const {
  const float at = std::clamp((offset / radius_ + 1) * 0.5f, 0.f, 1.f) * kBins;
  const int bin = std::min(static_cast<int>(at), kBins - 1);
  return cumulated_[bin] + (cumulated_[bin + 1] - cumulated_[bin]) * (at - static_cast<float>(bin));
}

float FilterSampler::place_1d(int pixel, float u, int low, int high) const {
  const float centre = static_cast<float>(pixel) + 0.5f;
  float begin = 0, end = 1;
  if (centre - radius_ < static_cast<float>(low))
    begin = cumulated(static_cast<float>(low) - centre);
  if (centre + radius_ > static_cast<float>(high)) {
    end = cumulated(static_cast<float>(high) - centre);
  }
  const float share = begin + (end - begin) * u;
  float at;
  if (is_box_) {
    at = share * 2 * radius_ - radius_;
  } else {
    const auto above = std::upper_bound(cumulated_.begin() + 1, cumulated_.end() - 1, share);
    const auto bin = static_cast<int>(above - cumulated_.begin()) - 1;
    const float width = cumulated_[bin + 1] - cumulated_[bin];
    const float part = width > 0 ? (share - cumulated_[bin]) / width : 0.5f;
    at = radius_ * (2 * (static_cast<float>(bin) + std::min(part, 1.f)) / kBins - 1);
  }
  // Far from the origin, sums round up to the filter's end, which is the next pixel's of a box.
  const float last = std::min(static_cast<float>(high), centre + radius_);
  return std::clamp(centre + at, static_cast<float>(low), std::nextafter(last, 0.f));
}

Vec2 FilterSampler::place(int x, int y, const Vec2& u, const Rect& region) const {
  return {place_1d(x, u.x, region.x0, region.x1), place_1d(y, u.y, region.y0, region.y1)};
}

TilePrimaries::View TilePrimaries::view_of(const Scene& scene, const Sensor& sensor,
                                           const FilterSampler& filter, bool hide_emitters) {
  const Film& film = sensor.film();
  return {scene, sensor, filter, film.sample_border() ? film.reach() : film.crop(), hide_emitters};
}

void TilePrimaries::make_rays(const View& view, const Rect& pixels,
                              std::span<const uint16_t> counts, uint64_t seed) {
  first_.assign(1, 0);
  for (const uint16_t count : counts) first_.push_back(first_.back() + count);
  const size_t total = first_.back();
  rays_.resize(total);
  pixels_.resize(total);
  const bool has_aperture = view.sensor.needs_aperture_sample();
  size_t i = 0;
  for (uint32_t pixel = 0; pixel < counts.size(); ++pixel) {
    const int x = pixels.x0 + static_cast<int>(pixel) % pixels.width();
    const int y = pixels.y0 + static_cast<int>(pixel) / pixels.width();
    const uint64_t key = hash_words(seed, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    const uint64_t aperture_x = hash_words(key, 1), aperture_y = hash_words(key, 2);
    const uint32_t count = counts[pixel];
    for (uint32_t begin = 0; begin < count; begin += HilbertPoints::kMaxCount) {
      const uint32_t part = std::min(count - begin, HilbertPoints::kMaxCount);
      const auto points = HilbertPoints::get().first(part);
      const uint64_t shift = hash_words(key, 3, begin);
      for (uint32_t k = 0; k < part; ++k, ++i) {
        const Vec2 u =
            points[k].shifted(static_cast<uint32_t>(shift), static_cast<uint32_t>(shift >> 32));
        const Vec2 aperture =
            has_aperture ? owen_sobol_point(begin + k, aperture_x, aperture_y) : Vec2(0.5f);
        rays_[i].ray = view.sensor.sample_ray(view.filter.place(x, y, u, view.region), aperture);
        rays_[i].hit = Hit{};
        pixels_[i] = static_cast<uint16_t>(pixel);
      }
    }
  }
  const Vec2 corner(static_cast<float>(pixels.x0), static_cast<float>(pixels.y0));
  const Ray a = view.sensor.sample_ray(corner, Vec2(0.5f));
  const Ray b = view.sensor.sample_ray(corner + Vec2(1, 0), Vec2(0.5f));
  const auto side = static_cast<float>(pixels.width());
  origin_width_ = side * glm::length(b.o - a.o);
  direction_width_ = side * glm::length(b.d - a.d);
}

void TilePrimaries::trace(const View& view, const Rect& pixels, std::span<const uint16_t> counts,
                          uint64_t seed, RenderCounters& counters) {
  make_rays(view, pixels, counts, seed);
  view.scene.intersect(rays_, Coherence::kCoherent, counters);
  counters[RayKind::kCamera] += size();
  if (interactions_.size() < size()) interactions_.resize(size());
  for (size_t i = 0; i < size(); ++i) {
    if (hit(i)) interactions_[i] = view.scene.interaction(rays_[i]);
  }
  emitted_.assign(size(), Rgb(0.f));
  if (view.hide_emitters) {
    look_behind_emitters(view, counters);
  } else {
    add_emitters(view);
  }
  patch.assign(size(), -1);
  normal.resize(size());
  frames.resize(size());
  microfacets.resize(size());
  turned.resize(size());
  diffuse.resize(size());
}

void TilePrimaries::look_behind_emitters(const View& view, RenderCounters& counters) {
  for (size_t i = 0; i < size(); ++i) {
    const float far = kInfinity;
    while (hit(i) && interactions_[i].shape->emitter()) {
      RayHit next = rays_[i];
      next.ray.o = interactions_[i].ray_origin(next.ray.d);
      next.ray.tmin = 0;
      next.ray.tmax = far;
      next.hit = Hit{};
      view.scene.intersect({&next, 1}, Coherence::kIncoherent, counters);
      ++counters[RayKind::kCamera];
      rays_[i] = next;
      if (hit(i)) interactions_[i] = view.scene.interaction(next);
    }
  }
}

void TilePrimaries::add_emitters(const View& view) {
  missed_.clear();
  directions_.clear();
  for (size_t i = 0; i < size(); ++i) {
    if (hit(i)) {
      const Emitter* const emitter = interactions_[i].shape->emitter();
      if (emitter) emitted_[i] = emitter->eval_surface(interactions_[i]);
    } else if (view.scene.environment()) {
      missed_.push_back(static_cast<uint32_t>(i));
      directions_.push_back(rays_[i].ray.d);
    }
  }
  if (missed_.empty()) return;
  environment_.resize(missed_.size());
  view.scene.environment()->eval_environment_batch(directions_, environment_, {});
  for (size_t k = 0; k < missed_.size(); ++k) emitted_[missed_[k]] = environment_[k];
}

bool belongs(const Patch& patch, const Bsdf* bsdf, const Vec3& normal, const Vec3& position) {
  return patch.bsdf == bsdf && glm::dot(patch.normal, normal) >= patch.cone_cosine &&
         std::abs(glm::dot(position - patch.position, patch.normal)) <= patch.tolerance;
}

namespace {

/// Reads what the point reflects; false where that is nothing.
bool prepare_point(TilePrimaries& primaries, size_t i, std::optional<BsdfForm>& form) {
  if (!primaries.hit(i)) return false;
  const SurfaceInteraction& si = primaries.interaction(i);
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes())) return false;
  const Frame frame = bsdf.reflection_frame(si);
  const Vec3 viewer = si.frame.to_world(si.wi);
  if (!(glm::dot(frame.n, viewer) > 0)) return false;
  primaries.normal[i] = frame.n;
  for (int axis = 0; axis < 3; ++axis) {
    primaries.frames.normal[axis][i] = frame.n[axis];
    primaries.frames.tangent[axis][i] = frame.s[axis];
    primaries.frames.viewer[axis][i] = viewer[axis];
  }
  const bool has_delta = any(bsdf.lobes() & Lobe::kDelta);
  form = bsdf.form(si);
  if (!form) {
    const LobeReflectance reflectance = bsdf.reflectance(si);
    primaries.diffuse[i] = any(bsdf.lobes() & Lobe::kDiffuse) ? reflectance.diffuse : Rgb(0.f);
    return has_delta || !is_black(reflectance.diffuse) || !is_black(reflectance.glossy);
  }
  primaries.diffuse[i] = form->diffuse;
  primaries.microfacets.alpha_u[i] = form->alpha_u;
  primaries.microfacets.alpha_v[i] = form->alpha_v;
  for (int c = 0; c < 3; ++c) primaries.microfacets.specular[c][i] = form->specular[c];
  if (form->is_turned) {
    for (int axis = 0; axis < 3; ++axis) {
      primaries.turned.normal[axis][i] = form->surface_normal[axis];
    }
    primaries.turned.bump_alpha2[i] = form->bump_alpha2;
  }
  return has_delta || !is_black(form->diffuse) || form->glossy != BsdfForm::Glossy::kNone;
}

/// A new patch around point i.
Patch start_patch(const TilePrimaries& primaries, size_t i, const std::optional<BsdfForm>& form) {
  const SurfaceInteraction& si = primaries.interaction(i);
  Patch patch;
  patch.bsdf = &si.shape->bsdf();
  patch.normal = primaries.normal[i];
  patch.position = si.p;
  patch.viewer = si.frame.to_world(si.wi);
  patch.cone_cosine = kPatchCosine;
  patch.tolerance = kPlaneWidths * primaries.width_at(si.t);
  patch.diffuse = primaries.diffuse[i];
  patch.is_described = patch.is_uniform = form.has_value();
  if (form) patch.form = *form;
  if (!form && mean_of(patch.diffuse) > 0) probe_transmittance(si, patch);
  if (any(patch.bsdf->lobes() & Lobe::kGlossy)) {
    patch.glossy_reflectance = mean_of(patch.bsdf->reflectance(si).glossy);
  }
  patch.lobe = glossy_lobe(si, form);
  return patch;
}

/// Of those that the point belongs to, the one with the nearest normal; -1: none.
int32_t find_patch(const std::vector<Patch>& patches, const TilePrimaries& primaries, size_t i) {
  const SurfaceInteraction& si = primaries.interaction(i);
  int32_t best = -1;
  float best_cosine = -2;
  for (size_t k = 0; k < patches.size(); ++k) {
    const float cosine = glm::dot(patches[k].normal, primaries.normal[i]);
    if (cosine <= best_cosine) continue;
    if (!belongs(patches[k], &si.shape->bsdf(), primaries.normal[i], si.p)) continue;
    best = static_cast<int32_t>(k);
    best_cosine = cosine;
  }
  return best;
}

/// Where there are too many patches: any of the material, which then takes all normals.
int32_t widen_some_patch(std::vector<Patch>& patches, const Bsdf* bsdf) {
  for (size_t k = 0; k < patches.size(); ++k) {
    if (patches[k].bsdf != bsdf) continue;
    patches[k].cone_cosine = -1;
    patches[k].tolerance = kInfinity;
    return static_cast<int32_t>(k);
  }
  return -1;
}

void assign(TilePrimaries& primaries, std::vector<Patch>& patches) {
  for (size_t i = 0; i < primaries.size(); ++i) {
    std::optional<BsdfForm> form;
    if (!prepare_point(primaries, i, form)) continue;
    int32_t k = find_patch(patches, primaries, i);
    if (k < 0 && patches.size() >= kMaxPatches) {
      k = widen_some_patch(patches, &primaries.interaction(i).shape->bsdf());
    }
    if (k < 0) {
      k = static_cast<int32_t>(patches.size());
      patches.push_back(start_patch(primaries, i, form));
    }
    Patch& patch = patches[k];
    patch.is_described = patch.is_described && form && form->same_kind(patch.form);
    patch.is_uniform = patch.is_uniform && form && form->specular == patch.form.specular &&
                       form->alpha_u == patch.form.alpha_u && form->alpha_v == patch.form.alpha_v;
    primaries.patch[i] = k;
  }
}

}  // namespace

simd::HalfVectorLobe glossy_lobe(const SurfaceInteraction& si,
                                 const std::optional<BsdfForm>& form) {
  // Wider lobes than this differ in nothing that matters to a proposal, and squares of the widest
  // overflow.
  constexpr float kMostAlpha = 1e3f;
  if (form && is_microfacet(*form)) {
    return {std::min(form->alpha_u, kMostAlpha), std::min(form->alpha_v, kMostAlpha)};
  }
  return probe_lobe(si.shape->bsdf(), si);
}

void make_patches(TilePrimaries& primaries, std::vector<Patch>& patches) {
  patches.clear();
  assign(primaries, patches);
  patches.shrink_to_fit();
  // Means in place of first points.
  for (Patch& patch : patches) {
    patch.normal = patch.position = patch.viewer = Vec3(0.f);
    patch.diffuse = Rgb(0.f);
  }
  for (size_t i = 0; i < primaries.size(); ++i) {
    if (primaries.patch[i] < 0) continue;
    Patch& patch = patches[primaries.patch[i]];
    const SurfaceInteraction& si = primaries.interaction(i);
    ++patch.count;
    patch.normal += primaries.normal[i];
    patch.position += si.p;
    patch.viewer += si.frame.to_world(si.wi);
    patch.diffuse += primaries.diffuse[i];
  }
  std::vector<float> least(patches.size(), 1.f);
  for (Patch& patch : patches) {
    patch.normal = normalized(patch.normal, Vec3(0, 0, 1));
    patch.viewer = normalized(patch.viewer, patch.normal);
    patch.position /= static_cast<float>(patch.count);
    patch.diffuse /= static_cast<float>(patch.count);
  }
  for (size_t i = 0; i < primaries.size(); ++i) {
    if (primaries.patch[i] < 0) continue;
    float& cosine = least[primaries.patch[i]];
    cosine = std::min(cosine, glm::dot(patches[primaries.patch[i]].normal, primaries.normal[i]));
  }
  for (size_t k = 0; k < patches.size(); ++k) {
    if (patches[k].cone_cosine < 0) continue;
    const float angle = std::acos(std::clamp(least[k], -1.f, 1.f)) * kConeFactor + kConeMargin;
    patches[k].cone_cosine = std::cos(std::min(angle, 1.5f));
  }
}

void assign_patches(TilePrimaries& primaries, std::vector<Patch>& patches) {
  assign(primaries, patches);
}

}  // namespace kinome
