#include <array>

#include "kinome/plugin.h"
#include "kinome/value_source.h"
#include "kinome/volume.h"
#include "kinome/wide/textures.h"
#include "lobes.h"

/// A linear mix of two phase functions: (1 - weight) times the first plus weight times the second.
///
///     <phase type="blendphase">
///       <float name="weight" value="0.3"/>
///       <phase type="hg"><float name="g" value="0.9"/></phase>
///       <phase type="isotropic"/>
///     </phase>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"weight", ParameterType::kVolume, nullptr, "weight of the second one, clamped to [0,1]", true},
    {"phase", ParameterType::kObject, nullptr, "the first and the second phase function", true,
     Category::kPhase, 2},
};

class Blend final : public Phase {
 public:
  explicit Blend(const Properties& props) : weight_(props.volume("weight")) {
    if (weight_->channels() > 3) throw props.error("weight", "must have 1 or 3 channels, got 6");
    constexpr float kRounding = 1e-5f;  // of Volume::max()
    if (!(weight_->min() >= 0 && weight_->max() <= 1 + kRounding)) {
      props.warn("weight", "has values outside [0,1], which are clamped: from " +
                               describe_min(*weight_) + " to " + describe_max(*weight_));
    }
    const auto nested = props.objects<Phase>();
    if (nested.size() != 2) {
      throw props.error("phase",
                        "must be two nested phase functions, got " + std::to_string(nested.size()));
    }
    nested_ = {nested[0], nested[1]};
    is_oriented_ = nested[0]->is_oriented() || nested[1]->is_oriented();
  }

  float eval(const MediumPoint& point, const Vec3& wo) const override {
    return mix(weight_at(point.p), nested_[0]->eval(point, wo), nested_[1]->eval(point, wo));
  }

  PhaseSample sample(const MediumPoint& point, float u1, const Vec2& u2) const override {
    const float weight = weight_at(point.p);
    const bool is_second = u1 < weight;
    PhaseSample drawn = nested_[is_second]->sample(point, rescaled(u1, weight), u2);
    if (drawn.pdf > 0) {
      drawn.pdf = mix(weight, is_second ? nested_[0]->eval(point, drawn.wo) : drawn.pdf,
                      is_second ? drawn.pdf : nested_[1]->eval(point, drawn.wo));
    }
    return drawn;
  }

  void eval_block(const MediumPointBlock& points, const Columns3& wo, float* value) const override {
    const wide::ScratchColumns columns(4, points.count);
    weights(points.p, points.count, columns);
    nested_[0]->eval_block(points, wo, value);
    nested_[1]->eval_block(points, wo, columns[3]);
    store_mix(points.count, columns[0], value, columns[3], value);
  }

  void sample_block(const MediumPointBlock& points, const float* u1, const Columns2& u2,
                    const Columns3& wo, float* pdf) const override {
    using wide::Float, wide::Vec3;
    const size_t count = points.count;
    const wide::ScratchColumns columns(4, count), other(4, count);
    weights(points.p, count, columns);
    wide::for_lanes(count, [&](size_t i) {
      rescaled(Float::load(u1 + i), Float::load(columns[0] + i)).store(columns[1] + i);
    });
    nested_[0]->sample_block(points, columns[1], u2, wo, pdf);
    nested_[1]->sample_block(points, columns[1], u2, other.three(), other[3]);
    wide::for_lanes(count, [&](size_t i) {
      const wide::Mask is_second = Float::load(u1 + i) < Float::load(columns[0] + i);
      select(is_second, Vec3::load(other.three(), i), Vec3::load(wo, i)).store(wo, i);
      select(is_second, Float::load(other[3] + i), Float::load(pdf + i)).store(columns[3] + i);
    });
    nested_[0]->eval_block(points, wo, pdf);
    nested_[1]->eval_block(points, wo, other[3]);
    wide::for_lanes(count, [&](size_t i) {
      const Float a = Float::load(pdf + i), b = Float::load(other[3] + i);
      const Float value = mix(Float::load(columns[0] + i), a, b);
      select(Float::load(columns[3] + i) > 0.f, value).store(pdf + i);
    });
  }

  float projected_area(const Vec3& p, const Vec3& d) const override {
    return mix(weight_at(p), nested_[0]->projected_area(p, d), nested_[1]->projected_area(p, d));
  }
  void projected_area_block(const Columns3& p, const Columns3& d, size_t count,
                            float* area) const override {
    const wide::ScratchColumns columns(4, count);
    weights(p, count, columns);
    nested_[0]->projected_area_block(p, d, count, area);
    nested_[1]->projected_area_block(p, d, count, columns[3]);
    store_mix(count, columns[0], area, columns[3], area);
  }
  float min_projected_area() const override {
    return std::min(nested_[0]->min_projected_area(), nested_[1]->min_projected_area());
  }
  float max_projected_area() const override {
    return std::max(nested_[0]->max_projected_area(), nested_[1]->max_projected_area());
  }

  /// With a weight between the smallest and the largest one.
  std::array<HgLobe, 2> lobes() const override {
    const float weight =
        (std::clamp(weight_->min(), 0.f, 1.f) + std::clamp(weight_->max(), 0.f, 1.f)) / 2;
    const auto a = nested_[0]->lobes(), b = nested_[1]->lobes();
    if (a[1].weight == 0 && b[1].weight == 0) return {HgLobe{a[0].g, 1 - weight}, {b[0].g, weight}};
    float p1 = 0, p2 = 0;
    for (size_t i = 0; i < 2; ++i) {
      p1 += (1 - weight) * a[i].weight * a[i].g + weight * b[i].weight * b[i].g;
      p2 += (1 - weight) * a[i].weight * sqr(a[i].g) + weight * b[i].weight * sqr(b[i].g);
    }
    return lobes_of_moments(p1, p2);
  }

 private:
  template <class F>
  static F mix(const F& weight, const F& a, const F& b) {
    return a * (1.f - weight) + b * weight;
  }
  static void store_mix(size_t count, const float* weight, const float* a, const float* b,
                        float* out) {
    using wide::Float;
    wide::for_lanes(count, [&](size_t i) {
      mix(Float::load(weight + i), Float::load(a + i), Float::load(b + i)).store(out + i);
    });
  }
  /// Returns u as a new random number after it has chosen the second function if u < weight.
  template <class F>
  static F rescaled(const F& u, const F& weight) {
    using namespace wide::formulas;
    using plain::select;
    const F again = select(u < weight, u / weight, (u - weight) / (1.f - weight));
    return clamp(again, F(0.f), F(kOneMinusEpsilon));
  }
  template <class F>
  static F share(const F& weight) {
    using namespace wide::formulas;
    using plain::select;
    return select(weight > 0.f, min(weight, F(1.f)), F(0.f));
  }
  float weight_at(const Vec3& p) const {
    float values[Volume::kMaxChannels];
    weight_->eval(p, values);
    return share(weight_->channels() == 1 ? values[0]
                                          : luminance(Rgb(values[0], values[1], values[2])));
  }
  /// Writes the weights to the first of three columns.
  void weights(const Columns3& p, size_t count, const wide::ScratchColumns& columns) const {
    using wide::Float;
    if (weight_->channels() == 1) {
      float* const values[] = {columns[0]};
      weight_->eval_block(p, count, values);
    } else {
      weight_->color_block(p, count, columns.three());
    }
    wide::for_lanes(count, [&](size_t i) {
      const Float weight = weight_->channels() == 1
                               ? Float::load(columns[0] + i)
                               : luminance(wide::Rgb::load(columns.three(), i));
      share(weight).store(columns[0] + i);
    });
  }

  std::shared_ptr<const Volume> weight_;
  std::array<std::shared_ptr<const Phase>, 2> nested_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Blend, kinome::Category::kPhase, "blendphase",
              "A mix of two phase functions.", kinome::kParameters);
