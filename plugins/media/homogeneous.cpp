#include "coefficients.h"
#include "kinome/plugin.h"

/// The same medium everywhere inside of a shape: fog, milk, wax.
///
///     <medium type="homogeneous" name="interior">
///       <rgb name="albedo" value="0.99 0.9 0.96"/>
///       <float name="sigma_t" value="5"/>
///       <phase type="hg"><float name="g" value="0.7"/></phase>
///     </medium>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {KINOME_MEDIUM_PARAMETERS};

Rgb uniform_color(const Properties& props, const char* name,
                  const std::shared_ptr<const Volume>& volume) {
  if (!volume->is_uniform()) {
    throw props.error(name,
                      "must be uniform, got a volume that varies (use a 'heterogeneous' "
                      "medium)");
  }
  return volume->color(Vec3(0.f));
}

class Homogeneous final : public Medium {
 public:
  explicit Homogeneous(const Properties& props)
      : extinction_(uniform_color(props, "sigma_t", nonnegative_volume(props, "sigma_t")) *
                    extinction_scale(props)),
        scattering_(extinction_ * uniform_color(props, "albedo", albedo_volume(props))) {
    if (!is_finite(extinction_)) throw props.error("scale", "makes the extinction infinite");
    phase_ = phase_of(props);
    samples_emitters_ = props.boolean("sample_emitters");
    is_coloured_ = extinction_.x != extinction_.y || extinction_.y != extinction_.z;
    min_extinction_ = -max_component(-extinction_) * phase_->min_projected_area();
    max_extinction_ = max_component(extinction_) * phase_->max_projected_area();
  }

  MediumCoefficients coefficients(const Vec3& p, const Vec3& d) const override {
    const float area = phase_->is_oriented() ? phase_->projected_area(p, d) : 1.f;
    return {extinction_ * area, scattering_ * area};
  }
  void coefficients_block(const Columns3& p, const Columns3& d, size_t count,
                          const MediumBlock& out) const override {
    if (phase_->is_oriented()) return Medium::coefficients_block(p, d, count, out);
    fill(extinction_, count, out.extinction);
    if (out.scattering.x) fill(scattering_, count, out.scattering);
  }
  bool is_uniform() const override { return !phase_->is_oriented(); }

  bool has_optical_depth() const override { return is_uniform(); }
  void optical_depth_block(const Columns3& /*o*/, const Columns3& /*d*/, const float* length,
                           size_t count, const Columns3& out) const override {
    const Rgb extinction = extinction_;
    for (size_t i = 0; i < count; ++i) out.set(i, extinction * length[i]);
  }

 private:
  static void fill(const Rgb& value, size_t count, const Columns3& out) {
    std::fill_n(out.x, count, value.x);
    std::fill_n(out.y, count, value.y);
    std::fill_n(out.z, count, value.z);
  }

  Rgb extinction_;
  Rgb scattering_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Homogeneous, kinome::Category::kMedium, "homogeneous",
              "The same medium everywhere.", kinome::kParameters);
