/// A surface that emits the same radiance in all directions of its outside, that is, where the
/// cosine with the shading normal is positive. Nested in the shape that emits.
///
///     <shape type="rectangle">
///       <emitter type="area"><rgb name="radiance" value="5 4 3"/></emitter>
///     </shape>

#include "emission.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/surface_point.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"radiance", ParameterType::kEmissionTexture, "1",
     "Emitted radiance, textured over the shape's (u, v)."},
};

class AreaLight final : public Emitter {
 public:
  explicit AreaLight(const Properties& props)
      : radiance_(read_emission_texture(props, "radiance")),
        is_black_(radiance_->max() == 0 && radiance_->min() == 0),
        uses_attribute_(!radiance_->attribute().empty()) {}

  bool is_surface() const override { return true; }

  Rgb eval_surface(const SurfaceInteraction& si) const override {
    return si.wi.z > 0 ? radiance_.at(si) : Rgb(0.f);
  }

  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    if (is_black_) return std::nullopt;
    const auto surface = shape()->sample_solid_angle(p, u);
    if (!surface) return std::nullopt;
    const TowardLight light(p, surface->si.p);
    if (!shines_toward(light, surface->si.frame.n)) return std::nullopt;
    const Rgb radiance = radiance_.at(surface->si);
    return DirectSample{light.d, light.distance, surface->pdf, radiance, false};
  }

  float pdf_surface(const Vec3& p, const SurfaceInteraction& si) const override {
    return si.wi.z > 0 && !is_black_ ? shape()->pdf_solid_angle(p, si) : 0;
  }

  void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    if (uses_attribute_) return Emitter::sample_direct_block(p, u, count, out);
    const wide::ScratchColumns scratch(9, count);
    const SurfaceSampleBlock points{scratch.three(0), scratch.three(3),
                                    radiance_.is_uniform() ? Columns2{} : scratch.two(6),
                                    scratch[8]};
    shape()->sample_solid_angle_block(p, u, count, points);
    const wide::ColorInput::Columns radiance(radiance_, points.uv, count);
    wide::for_lanes(count, [&](size_t i) {
      const TowardLight light(wide::Vec3::load(p, i), wide::Vec3::load(points.p, i));
      const wide::Float pdf = wide::Float::load(points.pdf + i);
      const wide::Mask shines = shines_toward(light, wide::Vec3::load(points.sn, i));
      store_direct(out, i, light, shines & (pdf > 0.f) & !is_black_, pdf, radiance[i], false);
    });
  }

  void eval_surface_block(const SurfaceBlock& points, const Columns3& from,
                          const Columns3& radiance, float* pdf) const override {
    if (pdf) shape()->pdf_solid_angle_block(from, points, pdf);
    const wide::ColorInput::Columns values(radiance_, points);
    wide::for_lanes(points.count, [&](size_t i) {
      const wide::Mask is_front = wide::Float::load(points.wi.z + i) > 0.f;
      select(is_front, values[i]).store(radiance, i);
      if (pdf) select(is_front & !is_black_, wide::Float::load(pdf + i)).store(pdf + i);
    });
  }

  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const override {
    const float area = shape()->area();
    if (is_black_ || !(area > 0)) return std::nullopt;
    const SurfaceInteraction si = shape()->sample_surface(position);
    const Rgb radiance = radiance_.at(si);
    if (is_black(radiance)) return std::nullopt;
    EmissionSample sample;
    sample.o = si.p;
    sample.o_error = si.p_error;
    sample.n = si.n;
    const auto light = light_leaving(si.n, si.frame, direction);
    if (!light.is_above) return std::nullopt;
    sample.d = light.d;
    sample.pdf_direction = light.pdf;
    sample.power = radiance * (light.cosine * area / light.pdf);
    return sample;
  }
  void sample_emission_block(const Columns2& position, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    if (uses_attribute_) return Emitter::sample_emission_block(position, direction, count, out);
    if (count == 0) return;
    const wide::ScratchColumns scratch(15, count);
    struct alignas(kColumnAlignment) Indices {
      uint32_t values[kBlockLanes];
    };
    std::vector<Indices> indices(padded(count) / kBlockLanes);
    SurfaceBlock points;
    points.count = count;
    points.p = out.o, points.n = scratch.three(0);
    points.s = scratch.three(3), points.t = scratch.three(6), points.sn = scratch.three(9);
    points.wi = out.d, points.uv = scratch.two(12), points.p_error = scratch[14];
    points.primitive = indices.data()->values;
    shape()->sample_surface_block(position, points);
    const wide::ColorInput::Columns radiance(radiance_, points.uv, count);
    const float area = shape()->area();
    const bool shines = !is_black_ && area > 0;
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec3 n = wide::Vec3::load(points.n, i);
      const auto light =
          light_leaving(n, wide::frame_at(points, i), wide::Vec2::load(direction, i));
      const wide::Float error = wide::Float::load(points.p_error + i);
      origin_off_surface(wide::Vec3::load(out.o, i), n, error, light.d).store(out.o, i);
      light.d.store(out.d, i);
      const wide::Rgb power = radiance[i] * (light.cosine * area / light.pdf);
      select(light.is_above & shines, power).store(out.power, i);
    });
  }

 private:
  template <class V>
  struct Leaving {
    using F = wide::formulas::NumberOf<V>;
    V d;
    F pdf;     ///< per solid angle
    F cosine;  ///< factor of the flux
    wide::formulas::MaskOf<F> is_above;
  };
  /// Samples a direction of emission. Flux is proportional to the cosine with the geometric normal
  /// n, but emission ends at the horizon of the shading normal. If the normals differ, the density
  /// is uniform, because a density by either cosine would be about 0 for some emitted light.
  template <class V, class V2>
  static Leaving<V> light_leaving(const V& n, const FrameOf<V>& frame, const V2& u) {
    using namespace wide::formulas;
    using F = NumberOf<V>;
    const auto is_interpolated = dot(n, frame.n) < 1.f - 1e-5f;
    const V local = select(is_interpolated, warp::square_to_uniform_hemisphere<V>(u),
                           warp::square_to_cosine_hemisphere<V>(u));
    const V d = frame.to_world(local);
    return {d,
            select(is_interpolated, F(kUniformHemispherePdf),
                   warp::cosine_hemisphere_pdf(local.z)),
            select(is_interpolated, abs(dot(n, d)), local.z), local.z > 0.f};
  }

  /// n is the emitter's shading normal.
  template <class V>
  static wide::formulas::MaskOf<typename TowardLight<V>::F> shines_toward(
      const TowardLight<V>& light, const V& n) {
    return light.valid() && dot(n, light.d) < 0.f;
  }

  wide::ColorInput radiance_;
  bool is_black_;
  bool uses_attribute_;  ///< evaluation needs the triangle, and not only (u, v)
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::AreaLight, kinome::Category::kEmitter, "area",
              "A surface that emits light on its outside.", kinome::kTable);
