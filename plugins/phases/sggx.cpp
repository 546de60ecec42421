#include "kinome/plugin.h"
#include "kinome/volume.h"
#include "kinome/warp.h"
#include "kinome/wide/phase.h"
#include "kinome/wide/textures.h"

/// Specular microflakes (Heitz et al. 2015, "The SGGX Microflake Distribution"): fabric, fur, ice
/// crystals. Their distribution is the symmetric matrix S in world space, so that the projected
/// area in direction d is sqrt(d S d). The extinction of the medium is multiplied by it.
///
///     <phase type="sggx">
///       <volume type="gridvolume" name="S"><string name="filename" value="flakes.vol"/></volume>
///     </phase>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"S", ParameterType::kVolume, nullptr, "volume of six channels: xx, yy, zz, xy, xz, yz", true},
};

/// Cholesky factor L of a matrix S = L L'. All formulas use L, so that they agree with each other
/// even if S isn't positive: its pivots are raised to a small positive number.
template <class F>
struct Factor {
  using V = wide::VecOf<F>;
  F xx, yx, yy, zx, zy, zz;

  Factor(const F& sxx, const F& syy, const F& szz, const F& sxy, const F& sxz, const F& syz) {
    using std::max, std::sqrt;
    const F least = max((sxx + syy + szz) * 1e-6f, F(1e-24f));
    xx = sqrt(max(sxx, least));
    yx = sxy / xx, zx = sxz / xx;
    yy = sqrt(max(syy - yx * yx, least));
    zy = (syz - zx * yx) / yy;
    zz = sqrt(max(szz - zx * zx - zy * zy, least));
  }
  F determinant() const { return xx * yy * zz; }
  V times(const V& v) const {
    return {xx * v.x, yx * v.x + yy * v.y, zx * v.x + zy * v.y + zz * v.z};
  }
  V transposed_times(const V& v) const {
    return {xx * v.x + yx * v.y + zx * v.z, yy * v.y + zy * v.z, zz * v.z};
  }
  V solve(const V& v) const {
    const F x = v.x / xx, y = (v.y - yx * x) / yy;
    return {x, y, (v.z - zx * x - zy * y) / zz};
  }
  F projected_area(const V& d) const {
    using namespace wide::formulas;
    return length(transposed_times(d));
  }
};

/// Value for the half vector h in world space (of any length) and the viewer's direction wi.
template <class F>
F flake_value(const Factor<F>& factor, const wide::VecOf<F>& h, const wide::VecOf<F>& wi) {
  using namespace wide::formulas;
  const wide::VecOf<F> v = factor.solve(h);
  const F ratio = dot(h, h) / dot(v, v);
  return F(0.25f * kInvPi) * ratio * ratio / (factor.determinant() * factor.projected_area(wi));
}

/// Half vector of wi = (0, 0, 1) and wo, or any vector that is perpendicular to wi if wo = -wi.
template <class F>
wide::VecOf<F> half_vector(const wide::VecOf<F>& wo) {
  using plain::select, std::max;
  const wide::VecOf<F> h{wo.x, wo.y, wide::Deflection<F>::of(wo).minus};
  return select(max(h.x * h.x, h.y * h.y) > 0.f || h.z > 0.f, h, wide::VecOf<F>(1.f, 0.f, 0.f));
}

class Sggx final : public Phase {
 public:
  explicit Sggx(const Properties& props) : matrix_(props.volume("S")) {
    if (matrix_->channels() != 6) {
      throw props.error(
          "S", "must be a volume of 6 channels, got " + std::to_string(matrix_->channels()));
    }
    is_oriented_ = true;
  }

  float eval(const MediumPoint& point, const Vec3& wo) const override {
    return flake_value(factor_at(point.p), point.frame.to_world(half_vector<float>(wo)),
                       point.frame.n);
  }
  PhaseSample sample(const MediumPoint& point, float /*u1*/, const Vec2& u2) const override {
    return drawn<float>(factor_at(point.p), point.frame, u2);
  }

  void eval_block(const MediumPointBlock& points, const Columns3& wo, float* value) const override {
    for_factors(points.p, points.count, [&](size_t i, const Factor<wide::Float>& factor) {
      const auto frame = frame_of(points, i);
      const wide::Vec3 h = half_vector<wide::Float>(wide::Vec3::load(wo, i));
      flake_value(factor, frame.to_world(h), frame.n).store(value + i);
    });
  }
  void sample_block(const MediumPointBlock& points, const float* /*u1*/, const Columns2& u2,
                    const Columns3& wo, float* pdf) const override {
    for_factors(points.p, points.count, [&](size_t i, const Factor<wide::Float>& factor) {
      const auto sample = drawn<wide::Float>(factor, frame_of(points, i), wide::Vec2::load(u2, i));
      sample.wo.store(wo, i);
      sample.pdf.store(pdf + i);
    });
  }

  float projected_area(const Vec3& p, const Vec3& d) const override {
    return factor_at(p).projected_area(d);
  }
  void projected_area_block(const Columns3& p, const Columns3& d, size_t count,
                            float* area) const override {
    for_factors(p, count, [&](size_t i, const Factor<wide::Float>& factor) {
      factor.projected_area(wide::Vec3::load(d, i)).store(area + i);
    });
  }
  float min_projected_area() const override { return 0; }
  /// No element of a positive matrix exceeds the largest of its diagonal, and no eigenvalue their
  /// sum.
  float max_projected_area() const override {
    return std::sqrt(3 * std::max(matrix_->max(), 1e-24f)) * (1 + 1e-5f);
  }

  std::array<HgLobe, 2> lobes() const override { return {HgLobe{0, 1}, HgLobe{0, 0}}; }

 private:
  template <class F>
  struct Drawn {
    wide::VecOf<F> wo;
    F pdf;
    operator PhaseSample() const { return {wo, pdf}; }
  };

  /// Samples a normal that is visible from the viewer, and reflects there. L maps the unit sphere
  /// to the normals, and cosines on it to visible areas.
  template <class F>
  static Drawn<F> drawn(const Factor<F>& factor, const FrameOf<wide::VecOf<F>>& frame,
                        const wide::Vec2Of<F>& u) {
    using namespace wide::formulas;
    using V = wide::VecOf<F>;
    const V around = normalize(factor.transposed_times(frame.n));
    const V on_sphere =
        FrameOf<V>::from_normal(around).to_world(warp::square_to_cosine_hemisphere<V>(u));
    const V normal = normalize(factor.times(on_sphere));
    const V m = frame.to_local(normal);  // wi is (0, 0, 1)
    // Normalized, because the reflection doubles the error of the length at each collision.
    const V wo = normalize(V{2.f * m.z * m.x, 2.f * m.z * m.y, 2.f * m.z * m.z - 1.f});
    return {wo, flake_value(factor, normal, frame.n)};
  }

  static FrameOf<wide::Vec3> frame_of(const MediumPointBlock& points, size_t i) {
    return {wide::Vec3::load(points.s, i), wide::Vec3::load(points.t, i),
            wide::Vec3::load(points.n, i)};
  }
  Factor<float> factor_at(const Vec3& p) const {
    float s[6];
    matrix_->eval(p, s);
    return {s[0], s[1], s[2], s[3], s[4], s[5]};
  }
  template <class Fn>
  void for_factors(const Columns3& p, size_t count, const Fn& fn) const {
    using wide::Float;
    const wide::ScratchColumns s(6, count);
    float* const columns[] = {s[0], s[1], s[2], s[3], s[4], s[5]};
    matrix_->eval_block(p, count, columns);
    wide::for_lanes(count, [&](size_t i) {
      const auto at = [&](size_t k) { return Float::load(s[k] + i); };
      fn(i, Factor<Float>(at(0), at(1), at(2), at(3), at(4), at(5)));
    });
  }

  std::shared_ptr<const Volume> matrix_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Sggx, kinome::Category::kPhase, "sggx",
              "Specular microflakes with an SGGX distribution.", kinome::kParameters);
