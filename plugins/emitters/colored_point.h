#pragma once

#include "emission.h"
#include "kinome/flux_grid.h"

namespace kinome {

/// Light of a point in one direction.
template <class F>
struct Beam {
  F factor;  ///< on the intensity, as Self::intensity() uses it; 0 where it is dark
  wide::formulas::Vec2Of<F> uv;
};

/// Base of points whose light a texture colours. Self must provide
///
///     template <class V>  // a unit vector in the emitter's frame
///     Beam<wide::formulas::NumberOf<V>> beam_toward(const V& d) const;
///     template <class V, class F>
///     V intensity(const V& texel, const F& factor) const;
///     FluxGrid make_flux_grid() const;
template <class Self>
class ColoredPoint : public Emitter {
 public:
  bool is_delta() const final { return true; }

  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& /*u*/) const final {
    const TowardLight light(p, frame_.origin);
    return light_from_point(light, intensity_toward(frame_.to_local(-light.d)));
  }
  void sample_direct_block(const Columns3& p, const Columns2& /*u*/, size_t count,
                           const DirectBlock& out) const final {
    const wide::ScratchColumns scratch(3, count);
    const Columns2 uv = scratch.two(0);
    float* const factor = scratch[2];
    const auto toward_lanes = [&](size_t i) {
      return TowardLight(wide::Vec3::load(p, i), wide::Vec3(frame_.origin));
    };
    wide::for_lanes(count, [&](size_t i) {
      const auto beam = self().beam_toward(frame_.to_local(-toward_lanes(i).d));
      beam.factor.store(factor + i);
      beam.uv.store(uv, i);
    });
    const wide::ColorInput::Columns texels(texture_, uv, count);
    wide::for_lanes(count, [&](size_t i) {
      const wide::Float own = wide::Float::load(factor + i);
      const wide::Rgb intensity = select(own > 0.f, self().intensity(texels[i], own));
      store_light_from_point(out, i, toward_lanes(i), intensity);
    });
  }

 protected:
  ColoredPoint(const LightFrame& frame, std::shared_ptr<const Texture> texture)
      : frame_(frame), texture_(std::move(texture)) {}

  Rgb intensity_toward(const Vec3& d) const {
    const auto beam = self().beam_toward(d);
    return beam.factor > 0 ? self().intensity(texture_.at(beam.uv), beam.factor) : Rgb(0.f);
  }
  /// Direct light doesn't need it.
  const FluxGrid& flux() const {
    return flux_.get([this] { return self().make_flux_grid(); });
  }

  LightFrame frame_;
  wide::ColorInput texture_;

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }

  LazyFluxGrid flux_;
};

}  // namespace kinome
