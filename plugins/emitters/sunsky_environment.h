#pragma once

#include "environment.h"
#include "kinome/flux_grid.h"
#include "sky_settings.h"

namespace kinome::sunsky {

/// The sun and a cloudless sky as an environment. Sampling chooses between them in proportion to
/// their light. The sun's disk is sampled uniformly, the sky by a table of its luminance over equal
/// solid angles.
class SunSky : public Environment {
 public:
  Rgb eval_environment(const Vec3& d) const final { return eval<float>(frame_.to_local(d)); }
  float pdf_environment(const Vec3& d) const final { return pdf<float>(frame_.to_local(d)); }

  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& u) const final {
    if (is_black_) return std::nullopt;
    const Vec3 local =
        sample<float>(u, sun_share_ < 1 ? flux_.sample(sky_random(u)) : std::nullopt);
    DirectSample direct;
    direct.d = frame_.to_world(local);
    direct.pdf = pdf<float>(local);
    direct.radiance = eval<float>(local);
    if (!(direct.pdf > 0)) return std::nullopt;
    return direct;
  }

  void sample_direct_block(const Columns3& /*p*/, const Columns2& u, size_t count,
                           const DirectBlock& out) const final {
    wide::for_lanes(count, [&](size_t i) {
      wide::Vec3 local(0.f, 0.f, 1.f);
      wide::Float density = 0.f;
      if (!is_black_) {
        const wide::Vec2 u_wide = wide::Vec2::load(u, i);
        std::optional<FluxGrid::SampleOf<wide::Float>> place;
        if (sun_share_ < 1) place = flux_.sample(sky_random(u_wide));
        local = sample<wide::Float>(u_wide, place);
        density = pdf<wide::Float>(local);
      }
      frame_.to_world(local).store(out.d, i);
      wide::Float(kInfinity).store(out.distance + i);
      density.store(out.pdf + i);
      eval<wide::Float>(local).store(out.radiance, i);
      wide::Float(0.f).store(out.is_delta + i);
    });
  }

  void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                              float* density) const final {
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec3 local = frame_.to_local(wide::Vec3::load(d, i));
      eval<wide::Float>(local).store(radiance, i);
      if (density) pdf<wide::Float>(local).store(density + i);
    });
  }

  /// The pole of the grid is the sun, or the zenith if there is no sun. The sun's disk is then
  /// (nearly) the first ring of quads, or the first few, so that cells contain either sun or sky.
  std::optional<EnvironmentGrid> cell_grid() const final {
    EnvironmentGrid grid;
    const bool has_sun = sun_share_ > 0;
    const Vec3 pole = frame_.to_world(has_sun ? model_.sun() : Vec3(0, 0, 1));
    const Frame around = Frame::from_normal(pole);
    grid.to_world = glm::mat3(around.s, around.n, around.t);
    grid.columns = 256;
    grid.rows = 128;
    if (!has_sun) {
      grid.smooth_quads = true;  // the horizon is between two rows
      return grid;
    }
    constexpr double kMinRows = 128, kMaxRows = 2048;
    const double half_turns = std::numbers::pi / settings_.half_angle;
    const double rings = std::max(1., std::ceil(kMinRows / half_turns));
    grid.rows = static_cast<int>(std::min(std::floor(rings * half_turns), kMaxRows));
    return grid;
  }

  /// An eighth of the points are on the sun's disk, evenly spread; the others are cells of the sky.
  std::optional<LightPoints> light_points(const Scene& /*scene*/, RenderContext& /*context*/,
                                          uint32_t count) const final {
    const bool has_sun = sun_share_ > 0;
    const uint32_t sun_points = has_sun ? std::max(1u, count / 8) : 0;
    // Half of the sphere's cells are below the horizon.
    const SpherePartition cells(std::max(2u, 2 * (count - std::min(sun_points, count - 1))));
    LightPoints points;
    points.kind = LightPoints::Kind::kDistant;
    const auto add = [&](const Vec3& local, const Rgb& power, float extent) {
      points.position.push_back(frame_.to_world(local));
      points.power.push_back(power);
      points.extent.push_back(extent);
    };
    for (uint32_t i = 0; i < cells.size(); ++i) {
      const Vec3 centre = zenith_up(cells.centre(i));
      const Rgb power = sky_in(cells, i);
      if (!is_black(power)) add(centre, power, cells.cell_solid_angle());
    }
    const Frame frame = Frame::from_normal(model_.sun());
    for (uint32_t i = 0; i < sun_points; ++i) {
      // Vogel's spiral: equal areas of the disk.
      const float turn = 0.5f * (3 - std::sqrt(5.f)) * static_cast<float>(i);
      const Vec2 u((static_cast<float>(i) + 0.5f) / static_cast<float>(sun_points),
                   turn - std::floor(turn));
      const Vec3 local = in_sun<float>(frame, u);
      if (local.z < 0) continue;
      const float extent = solid_angle() / static_cast<float>(sun_points);
      add(local, sun_radiance_ * extent, extent);
    }
    return points;
  }

  /// For `sun` and `rows`, see SkySettings::model.
  SunSky(const SkySettings& settings, const Vec3& sun, double rows = 0)
      : settings_(settings),
        frame_(settings.frame),
        model_(settings.model(sun, rows)),
        sun_radiance_(model_.sun_radiance() * (settings.sun_scale * settings.sun_ratio())),
        flux_({128, 64}, 2, [this](const Vec2& uv) {
          return settings_.sky_scale == 0 || !model_.is_day()
                     ? 0.f
                     : settings_.sky_scale *
                           luminance(glm::abs(model_.sky<float>(sky_direction<float>(uv))));
        }) {
    const float sun_flux = luminance(glm::abs(sun_radiance_)) * solid_angle();
    const float sky_flux = flux_.mean() * 2 * kPi;
    is_black_ = !(sun_flux + sky_flux > 0);
    sun_share_ = is_black_ ? 0 : sun_flux / (sun_flux + sky_flux);
  }

 private:
  double chord2() const { return settings_.chord2(); }
  float solid_angle() const { return settings_.solid_angle(); }

  // Directions are local from here on.

  template <class F>
  wide::formulas::MaskOf<F> is_sun(const wide::formulas::VecOf<F>& d) const {
    using namespace wide::formulas;
    const VecOf<F> chord = d - VecOf<F>(model_.sun());
    return dot(chord, chord) <= static_cast<float>(chord2());
  }

  template <class F>
  wide::formulas::RgbOf<F> eval(const wide::formulas::VecOf<F>& d) const {
    using namespace wide::formulas;
    if (is_black_) return RgbOf<F>(F(0.f));
    const RgbOf<F> sun = select(is_sun<F>(d), RgbOf<F>(sun_radiance_));
    return select(d.z >= 0.f, model_.sky<F>(d) * F(settings_.sky_scale) + sun);
  }

  template <class F>
  F pdf(const wide::formulas::VecOf<F>& d) const {
    using namespace wide::formulas;
    if (is_black_) return F(0.f);
    const F turn = atan2(d.y, d.x) * (0.5f * kInvPi);
    const Vec2Of<F> uv{select(turn < 0.f, turn + 1.f, turn), 1.f - d.z};
    const F sky_pdf = flux_.pdf(uv) * ((1 - sun_share_) * 0.5f * kInvPi);
    const F sun_pdf = select(is_sun<F>(d), F(sun_share_ / solid_angle()));
    return select(d.z >= 0.f, sky_pdf + sun_pdf);
  }

  template <class F>
  static wide::formulas::VecOf<F> sky_direction(const wide::formulas::Vec2Of<F>& uv) {
    using namespace wide::formulas;
    return warp::spherical_direction<VecOf<F>, F>(1.f - uv.y, uv.x * (2 * kPi));
  }
  template <class F>
  wide::formulas::VecOf<F> in_sun(const FrameOf<wide::formulas::VecOf<F>>& frame,
                                  const wide::formulas::Vec2Of<F>& u) const {
    using namespace wide::formulas;
    const F height = u.x * static_cast<float>(chord2() / 2);
    const F r = sqrt(height * (2.f - height)), phi = u.y * (2 * kPi);
    return frame.to_world(VecOf<F>(r * cos(phi), r * sin(phi), 1.f - height));
  }

  /// Rescales random numbers after they have chosen the sky.
  template <class V2>
  V2 sky_random(const V2& u) const {
    using namespace wide::formulas;
    using F = NumberOf<V2>;
    return V2(max(F(0.f), (u.x - sun_share_) / (1 - sun_share_)), u.y);
  }
  /// Samples the sun, or returns the direction of `place` in the sky, as u.x chooses. `place` is
  /// nullopt if all light is the sun's.
  template <class F>
  wide::formulas::VecOf<F> sample(const wide::formulas::Vec2Of<F>& u,
                                  const std::optional<FluxGrid::SampleOf<F>>& place) const {
    using namespace wide::formulas;
    const auto frame = FrameOf<VecOf<F>>::from_normal(VecOf<F>(model_.sun()));
    const float share = std::max(sun_share_, 1e-30f);
    const VecOf<F> sun = in_sun<F>(frame, {min(u.x / share, F(1.f)), u.y});
    if (!place) return sun;
    return select(u.x < sun_share_, sun, sky_direction<F>(place->uv));
  }

  /// Maps from the space of a SpherePartition, whose poles are on y.
  static Vec3 zenith_up(const Vec3& d) { return {d.z, d.x, d.y}; }
  Rgb sky_in(const SpherePartition& cells, uint32_t i) const {
    constexpr int kSide = 4;
    Rgb sum(0.f);
    if (is_black_) return sum;
    for (int k = 0; k < kSide * kSide; ++k) {
      const Vec2 u((static_cast<float>(k % kSide) + 0.5f) / kSide,
                   (static_cast<float>(k / kSide) + 0.5f) / kSide);
      const Vec3 d = zenith_up(cells.sample(i, u));
      if (d.z >= 0) sum += model_.sky<float>(d);
    }
    return sum * (settings_.sky_scale * cells.cell_solid_angle() / (kSide * kSide));
  }

  SkySettings settings_;
  LightFrame frame_;
  Model model_;
  Rgb sun_radiance_;
  FluxGrid flux_;  ///< flux of the sky over (azimuth / 2 pi, 1 - z)
  bool is_black_;
  float sun_share_;  ///< probability of sampling the sun
};

}  // namespace kinome::sunsky
