#include "clustered/product/tiles/patches.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clustered/cells/hilbert_points.h"
#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Minimum cosine between the normals of a patch and that of its first point.
constexpr float kPatchCosine = 0.95f;
/// The cone of a pilot's normals is widened by these values, so that later primaries fit.
constexpr float kConeFactor = 1.3f;
constexpr float kConeMargin = 0.0175f;
/// Maximum distance from the plane, in widths of the tile.
constexpr float kPlaneWidths = 1;
constexpr size_t kMaxPatches = 48;
/// Minimum of the probed values. It leaves no cell without rays, because a lobe that is dark along
/// the probed azimuth may be bright along another.
constexpr float kMinTransmittance = 0.1f;
/// Number of random directions that measure a lobe's width.
constexpr size_t kLobeProbes = 31;

/// Estimates the lobe's roughness from random samples. For GGX, half of the half vectors' slopes
/// along an axis are within alpha / sqrt 3.
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
  std::array<float, kSteps> probed;
  for (int k = 0; k < kSteps; ++k) {
    const float cosine = std::max(static_cast<float>(k), 0.5f) / (kSteps - 1);
    const Vec3 d = frame.n * cosine + frame.s * safe_sqrt(1 - cosine * cosine);
    const Rgb f = patch.bsdf->eval_pdf(si, Lobe::kDiffuse, si.frame.to_local(d)).f;
    const float lambertian = mean_of(patch.diffuse) * kInvPi * cosine;
    probed[k] = std::clamp(mean_of(f) / lambertian, kMinTransmittance, 4.f);
  }
  patch.probed = std::make_shared<const std::array<float, kSteps>>(probed);
}

/// True if the ray hit a point that reflects light toward the viewer.
bool reflects(const TilePrimaries& primaries, size_t i) {
  if (!primaries.hit(i) || primaries.goes_on(i)) return false;  // Estimator::follow_paths
  const Lobe lobes = primaries.shape(i).bsdf().lobes();
  if (!any(lobes) || !(glm::dot(primaries.normal(i), primaries.viewer(i)) > 0)) return false;
  if (any(lobes & Lobe::kDelta) || !is_black(primaries.diffuse(i))) return true;
  const BsdfForm* const kind = primaries.form_kind(i);
  return kind ? kind->glossy != BsdfForm::Glossy::kNone : !is_black(primaries.specular(i));
}

/// Returns a new patch around point i.
Patch start_patch(const TilePrimaries& primaries, size_t i) {
  const SurfaceInteraction si = primaries.interaction(i);
  Patch patch;
  patch.bsdf = &si.shape->bsdf();
  patch.normal = primaries.normal(i);
  patch.position = si.p;
  patch.viewer = primaries.viewer(i);
  patch.cone_cosine = kPatchCosine;
  patch.tolerance = kPlaneWidths * primaries.width_at(primaries.distance(i));
  patch.diffuse = primaries.diffuse(i);
  std::optional<BsdfForm> form;
  if (primaries.form_kind(i)) form = primaries.form(i);
  patch.is_described = patch.is_uniform = form.has_value();
  if (form) patch.form = *form;
  if (!form && mean_of(patch.diffuse) > 0) probe_transmittance(si, patch);
  if (any(patch.bsdf->lobes() & Lobe::kGlossy)) {
    patch.glossy_reflectance = mean_of(patch.bsdf->reflectance(si).glossy);
  }
  patch.lobe = glossy_lobe(si, form);
  return patch;
}

/// True if the point may belong to the patch.
bool belongs(const Patch& patch, const Bsdf* bsdf, const Vec3& normal, const Vec3& position) {
  return patch.bsdf == bsdf && glm::dot(patch.normal, normal) >= patch.cone_cosine &&
         std::abs(glm::dot(position - patch.position, patch.normal)) <= patch.tolerance;
}

/// Returns the patch with the nearest normal among those that the point belongs to, or -1.
int32_t find_patch(const std::vector<Patch>& patches, const TilePrimaries& primaries, size_t i) {
  const Bsdf* const bsdf = &primaries.shape(i).bsdf();
  const Vec3 normal = primaries.normal(i), position = primaries.position(i);
  int32_t best = -1;
  float best_cosine = -2;
  for (size_t k = 0; k < patches.size(); ++k) {
    const float cosine = glm::dot(patches[k].normal, normal);
    if (cosine <= best_cosine || !belongs(patches[k], bsdf, normal, position)) continue;
    best = static_cast<int32_t>(k);
    best_cosine = cosine;
  }
  return best;
}

/// Widens a patch of the material to all normals and positions. Used if there are too many patches.
/// Returns -1 if there is no patch of the material.
int32_t widen_some_patch(std::vector<Patch>& patches, const Bsdf* bsdf) {
  for (size_t k = 0; k < patches.size(); ++k) {
    if (patches[k].bsdf != bsdf) continue;
    patches[k].cone_cosine = -1;
    patches[k].tolerance = kInfinity;
    return static_cast<int32_t>(k);
  }
  return -1;
}

/// Updates Patch::is_described and is_uniform for a new point.
void note_form(const TilePrimaries& primaries, size_t i, Patch& patch) {
  if (!patch.is_described) return;
  const BsdfForm* const kind = primaries.form_kind(i);
  patch.is_described = kind && kind->same_kind(patch.form);
  if (!patch.is_described) {
    patch.is_uniform = false;
    return;
  }
  if (!patch.is_uniform || !is_microfacet(*kind)) return;
  const auto at = static_cast<size_t>(primaries.point(i));
  const simd::MicrofacetPoints& lobes = primaries.microfacets();
  patch.is_uniform = primaries.specular(i) == patch.form.specular &&
                     lobes.alpha_u[at] == patch.form.alpha_u &&
                     lobes.alpha_v[at] == patch.form.alpha_v;
}

}  // namespace

simd::HalfVectorLobe microfacet_lobe(const BsdfForm& form) {
  // Wider lobes make no difference to a proposal, and the squares of the widest would overflow.
  constexpr float kMaxAlpha = 1e3f;
  return {std::min(form.alpha_u, kMaxAlpha), std::min(form.alpha_v, kMaxAlpha)};
}

simd::HalfVectorLobe glossy_lobe(const SurfaceInteraction& si,
                                 const std::optional<BsdfForm>& form) {
  if (form && is_microfacet(*form)) return microfacet_lobe(*form);
  return probe_lobe(si.shape->bsdf(), si);
}

void assign_patches(TilePrimaries& primaries, std::vector<Patch>& patches) {
  for (size_t i = 0; i < primaries.size(); ++i) {
    if (!reflects(primaries, i)) continue;
    int32_t k = find_patch(patches, primaries, i);
    if (k < 0 && patches.size() >= kMaxPatches) {
      k = widen_some_patch(patches, &primaries.shape(i).bsdf());
    }
    if (k < 0) {
      k = static_cast<int32_t>(patches.size());
      patches.push_back(start_patch(primaries, i));
    }
    note_form(primaries, i, patches[k]);
    primaries.set_patch(i, k);
  }
}

void make_patches(TilePrimaries& primaries, std::vector<Patch>& patches) {
  patches.clear();
  assign_patches(primaries, patches);
  // Replace the values of the first points by means.
  for (Patch& patch : patches) {
    patch.normal = patch.position = patch.viewer = Vec3(0.f);
    patch.diffuse = Rgb(0.f);
  }
  for (size_t i = 0; i < primaries.size(); ++i) {
    if (primaries.patch(i) < 0) continue;
    Patch& patch = patches[primaries.patch(i)];
    ++patch.count;
    patch.normal += primaries.normal(i);
    patch.position += primaries.position(i);
    patch.viewer += primaries.viewer(i);
    patch.diffuse += primaries.diffuse(i);
  }
  std::vector<float> min_cosines(patches.size(), 1.f);
  for (Patch& patch : patches) {
    patch.normal = normalized(patch.normal, Vec3(0, 0, 1));
    patch.viewer = normalized(patch.viewer, patch.normal);
    patch.position /= static_cast<float>(patch.count);
    patch.diffuse /= static_cast<float>(patch.count);
  }
  for (size_t i = 0; i < primaries.size(); ++i) {
    if (primaries.patch(i) < 0) continue;
    float& cosine = min_cosines[primaries.patch(i)];
    cosine = std::min(cosine, glm::dot(patches[primaries.patch(i)].normal, primaries.normal(i)));
  }
  for (size_t k = 0; k < patches.size(); ++k) {
    if (patches[k].cone_cosine < 0) continue;
    const float angle =
        std::acos(std::clamp(min_cosines[k], -1.f, 1.f)) * kConeFactor + kConeMargin;
    patches[k].cone_cosine = std::cos(std::min(angle, 1.5f));
  }
}

}  // namespace kinome
