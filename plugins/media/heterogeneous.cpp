#include "coefficients.h"
#include "kinome/plugin.h"
#include "kinome/wide/textures.h"

/// A medium that varies: smoke, clouds. As in Mitsuba, it exists only in the box of `sigma_t`: the
/// world-space box of the unit cube that the volume's `to_world` transforms, also for a constant
/// `sigma_t`.
///
///     <medium type="heterogeneous" name="interior">
///       <volume type="gridvolume" name="sigma_t">
///         <string name="filename" value="smoke.vol"/>
///       </volume>
///       <float name="scale" value="20"/>
///     </medium>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {KINOME_MEDIUM_PARAMETERS};
/// Maximum extinction times the diagonal of the box. Paths take steps of 1 / maximum extinction, so
/// that a single voxel of a much higher value would stop a render.
constexpr float kMaxDepth = 1e7f;

class Heterogeneous final : public Medium {
 public:
  explicit Heterogeneous(const Properties& props)
      : extinction_(nonnegative_volume(props, "sigma_t")),
        albedo_(albedo_volume(props)),
        scale_(extinction_scale(props)) {
    phase_ = phase_of(props);
    samples_emitters_ = props.boolean("sample_emitters");
    is_coloured_ = extinction_->channels() > 1;
    min_extinction_ = extinction_->min() * scale_ * phase_->min_projected_area();
    max_extinction_ = extinction_->max() * scale_ * phase_->max_projected_area();
    if (!std::isfinite(max_extinction_)) {
      throw props.error("scale", "makes the extinction infinite");
    }
    const float depth = max_extinction_ * glm::length(extinction_->box().extent());
    if (depth > kMaxDepth) {
      throw props.error("sigma_t", "times the diagonal of its box must be at most " +
                                       format_number(kMaxDepth) + ", got " + format_number(depth));
    }
  }

  MediumCoefficients coefficients(const Vec3& p, const Vec3& d) const override {
    const Aabb box = extinction_->box();
    const bool is_inside =
        glm::all(glm::greaterThanEqual(p, box.lo)) && glm::all(glm::lessThanEqual(p, box.hi));
    if (!is_inside) return {};
    const float scale = phase_->is_oriented() ? scale_ * phase_->projected_area(p, d) : scale_;
    const Rgb extinction = extinction_->color(p) * scale;
    return {extinction, extinction * clamped(albedo_->color(p))};
  }

  void coefficients_block(const Columns3& p, const Columns3& d, size_t count,
                          const MediumBlock& out) const override {
    const wide::ScratchColumns scales(1, count);
    std::fill_n(scales[0], count, 1.f);
    if (phase_->is_oriented()) phase_->projected_area_block(p, d, count, scales[0]);
    // Columns that are the same are scaled once.
    const Columns3& sigma = out.extinction;
    extinction_->color_block(p, count, sigma);
    for (float* const column : {sigma.x, sigma.y == sigma.x ? nullptr : sigma.y,
                                sigma.z == sigma.x ? nullptr : sigma.z}) {
      if (column) scale(scales[0], count, column);
    }
    if (!out.scattering.x) return;
    const bool is_uniform = albedo_->is_uniform();
    const Rgb constant = is_uniform ? albedo_->color(Vec3(0.f)) : Rgb(0.f);
    if (!is_uniform) albedo_->color_block(p, count, out.scattering);
    using wide::Rgb;
    wide::for_lanes(count, [&](size_t i) {
      const Rgb albedo = is_uniform ? Rgb(constant) : Rgb::load(out.scattering, i);
      (clamped(albedo) * Rgb::load(sigma, i)).store(out.scattering, i);
    });
  }

  Aabb box() const override { return extinction_->box(); }
  glm::uvec3 resolution() const override { return extinction_->resolution(); }
  void extremes(const BlockGrid& blocks, float* lo, float* hi) const override {
    extinction_->extremes(blocks, lo, hi);
    for (size_t i = 0; i < blocks.count(); ++i) {
      lo[i] *= scale_ * phase_->min_projected_area();
      hi[i] *= scale_ * phase_->max_projected_area();
    }
  }

  bool has_optical_depth() const override {
    return extinction_->has_integral() && !phase_->is_oriented();
  }
  void optical_depth_block(const Columns3& o, const Columns3& d, const float* length, size_t count,
                           const Columns3& out) const override {
    float* const columns[Volume::kMaxChannels] = {out.x, out.y, out.z};
    extinction_->integral_block(o, d, length, count, columns);
    const uint32_t channels = extinction_->channels();
    for (uint32_t c = 0; c < channels; ++c) {
      for (size_t i = 0; i < count; ++i) columns[c][i] *= scale_;
    }
    for (uint32_t c = channels; c < 3; ++c) {
      if (columns[c] != out.x) std::copy_n(out.x, count, columns[c]);
    }
  }

 private:
  /// Interpolation may exceed 1 by rounding.
  template <class C>
  static C clamped(const C& albedo) {
    using std::min;
    using F = std::remove_cvref_t<decltype(albedo.x)>;
    return {min(albedo.x, F(1.f)), min(albedo.y, F(1.f)), min(albedo.z, F(1.f))};
  }
  void scale(const float* factors, size_t count, float* column) const {
    wide::for_lanes(count, [&](size_t i) {
      (wide::Float::load(column + i) * wide::Float::load(factors + i) * scale_).store(column + i);
    });
  }

  std::shared_ptr<const Volume> extinction_;
  std::shared_ptr<const Volume> albedo_;
  float scale_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Heterogeneous, kinome::Category::kMedium, "heterogeneous",
              "A medium that varies in space.", kinome::kParameters);
