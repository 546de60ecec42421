#include "coefficients.h"
#include "kinome/plugin.h"

/// The same extinction everywhere inside of a shape: fog, milk, wax. The albedo may be a volume.
///
///     <medium type="homogeneous" name="interior">
///       <rgb name="albedo" value="0.99 0.9 0.96"/>
///       <float name="sigma_t" value="5"/>
///       <phase type="hg"><float name="g" value="0.7"/></phase>
///     </medium>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {KINOME_MEDIUM_PARAMETERS};

class Homogeneous final : public Medium {
 public:
  explicit Homogeneous(const Properties& props) : albedo_(albedo_volume(props)) {
    const auto extinction = nonnegative_volume(props, "sigma_t");
    if (!extinction->is_uniform()) {
      throw props.error("sigma_t",
                        "must be uniform, got a volume that varies (use a "
                        "'heterogeneous' medium)");
    }
    extinction_ = extinction->color(Vec3(0.f)) * extinction_scale(props);
    if (!is_finite(extinction_)) throw props.error("scale", "makes the extinction infinite");
    phase_ = phase_of(props);
    samples_emitters_ = props.boolean("sample_emitters");
    is_coloured_ = extinction_.x != extinction_.y || extinction_.y != extinction_.z;
    min_extinction_ = -max_component(-extinction_) * phase_->min_projected_area();
    max_extinction_ = max_component(extinction_) * phase_->max_projected_area();
  }

  MediumCoefficients coefficients(const Vec3& p, const Vec3& d) const override {
    const float area = phase_->is_oriented() ? phase_->projected_area(p, d) : 1.f;
    const Rgb extinction = extinction_ * area;
    return {extinction, extinction * glm::min(albedo_->color(p), Rgb(1.f))};
  }
  void coefficients_block(const Columns3& p, const Columns3& d, size_t count,
                          const MediumBlock& out) const override {
    if (phase_->is_oriented()) return Medium::coefficients_block(p, d, count, out);
    if (out.scattering.x) {
      albedo_->color_block(p, count, out.scattering);
      for (size_t i = 0; i < count; ++i) {
        out.scattering.set(i, extinction_ * glm::min(out.scattering.at(i), Rgb(1.f)));
      }
    }
    std::fill_n(out.extinction.x, count, extinction_.x);
    std::fill_n(out.extinction.y, count, extinction_.y);
    std::fill_n(out.extinction.z, count, extinction_.z);
  }
  bool is_uniform() const override { return albedo_->is_uniform() && !phase_->is_oriented(); }

  bool has_optical_depth() const override { return !phase_->is_oriented(); }
  void optical_depth_block(const Columns3& /*o*/, const Columns3& /*d*/, const float* length,
                           size_t count, const Columns3& out) const override {
    const Rgb extinction = extinction_;
    for (size_t i = 0; i < count; ++i) out.set(i, extinction * length[i]);
  }

 private:
  std::shared_ptr<const Volume> albedo_;
  Rgb extinction_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Homogeneous, kinome::Category::kMedium, "homogeneous",
              "The same medium everywhere.", kinome::kParameters);
