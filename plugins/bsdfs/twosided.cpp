#include <algorithm>

#include "batch.h"
#include "kinome/plugin.h"

/// Makes one-sided BSDFs visible from both sides. A single nested BSDF is used for both sides; of
/// two, the first is the front and the second the back. The back is mirrored at the surface.
///
///     <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"bsdf", ParameterType::kObject, nullptr, "one BSDF for both sides, or front and back", true,
     Category::kBsdf, 2},
    {"allow_transmission", ParameterType::kBoolean, "false",
     "allow nested BSDFs that transmit light without refraction"},
};

class TwoSided final : public Bsdf {
 public:
  explicit TwoSided(const Properties& props) : sides_(props.objects<Bsdf>()) {
    if (sides_.empty() || sides_.size() > 2) {
      throw props.error("bsdf",
                        "must be one or two nested BSDFs, got " + std::to_string(sides_.size()));
    }
    const bool allow_transmission = props.boolean("allow_transmission");
    for (const auto& side : sides_) {
      if (side->transmits() && !allow_transmission) {
        throw props.error("bsdf", "must not transmit light: such a BSDF is two-sided itself");
      }
      if (side->relative_index() != 1) {
        throw props.error("bsdf", "must not refract light: both sides would refract it inwards");
      }
      transmits_ = transmits_ || side->transmits();
      has_rough_transmission_ = has_rough_transmission_ || side->has_rough_transmission();
      has_null_lobe_ = has_null_lobe_ || side->has_null_lobe();
    }
    lobes_ = sides_.front()->lobes() | sides_.back()->lobes();
    is_lambertian_ = sides_.front()->is_lambertian() && sides_.back()->is_lambertian();
    turns_to_viewer_ = sides_.front()->turns_to_viewer() || sides_.back()->turns_to_viewer();
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    if (!(si.wi.z < 0)) return sides_.front()->eval_pdf(si, mask, wo);
    return sides_.back()->eval_pdf(mirrored(si), mask, {wo.x, wo.y, -wo.z});
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    if (!(si.wi.z < 0)) {
      return sides_.front()->sample(si, mask, u1, u2);
    }
    auto result = sides_.back()->sample(mirrored(si), mask, u1, u2);
    if (result) {
      result->wo.z = -result->wo.z;
    }
    return result;
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    const size_t num_backs = seen_from_behind(points);
    if (num_backs == 0) return sides_.front()->shade_block(points, query, answer);
    if (sides_.size() == 1 || num_backs == points.count) {
      return shade_facing(*sides_.back(), points, query, answer);
    }
    // Each point takes the result of its side.
    const wide::ScratchColumns columns(12, points.count);
    const BsdfAnswer back{columns.three(0), columns[3],  columns.three(4),
                          columns.three(7), columns[10], columns[11]};
    sides_.front()->shade_block(points, query, answer);
    shade_facing(*sides_.back(), points, query, back);
    const BackTaker take(points);
    if (query.wo.x) take(answer.f, back.f), take(answer.pdf, back.pdf);
    if (!query.u1) return;
    take(answer.wo, back.wo), take(answer.weight, back.weight);
    take(answer.sample_pdf, back.sample_pdf), take(answer.is_delta, back.is_delta);
  }

  NullTransmission null_transmission(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->null_transmission(mirrored(si))
                       : sides_.front()->null_transmission(si);
  }

  void null_transmission_block(const SurfaceBlock& points,
                               const NullTransmissionBlock& out) const override {
    const size_t num_backs = seen_from_behind(points);
    if (num_backs == 0) return sides_.front()->null_transmission_block(points, out);
    const wide::ScratchColumns columns(8, points.count);
    const SurfaceBlock facing = turned_to_viewer(points, columns);
    if (sides_.size() == 1 || num_backs == points.count) {
      return sides_.back()->null_transmission_block(facing, out);
    }
    const NullTransmissionBlock back{columns.three(4), columns[7]};
    sides_.front()->null_transmission_block(points, out);
    sides_.back()->null_transmission_block(facing, back);
    const BackTaker take(points);
    take(out.transmittance, back.transmittance), take(out.probability, back.probability);
  }

  void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const override {
    const size_t num_backs = seen_from_behind(points);
    if (num_backs == 0) return sides_.front()->describe_block(points, out);
    const wide::ScratchColumns columns(22, points.count);
    const SurfaceBlock facing = turned_to_viewer(points, columns);
    if (sides_.size() == 1 || num_backs == points.count) {
      return sides_.back()->describe_block(facing, out);
    }
    // Each point takes the description of its side.
    std::vector<uint32_t> kind(padded(points.count));
    const BsdfFormBlock back{columns.three(4),  columns.three(7),  columns.three(10),
                             columns.three(13), columns[16],       columns[17],
                             columns.three(18), columns[21],       kind.data(),
                             out.kinds};
    sides_.front()->describe_block(points, out);
    sides_.back()->describe_block(facing, back);
    const BackTaker take(points);
    take(out.normal, back.normal), take(out.tangent, back.tangent);
    take(out.diffuse, back.diffuse), take(out.specular, back.specular);
    take(out.alpha_u, back.alpha_u), take(out.alpha_v, back.alpha_v);
    take(out.surface_normal, back.surface_normal), take(out.bump_alpha2, back.bump_alpha2);
    for (size_t i = 0; i < points.count; ++i) {
      if (points.wi.z[i] < 0) out.kind[i] = kind[i];
    }
  }

  Rgb albedo(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->albedo(mirrored(si)) : sides_.front()->albedo(si);
  }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->reflectance(mirrored(si)) : sides_.front()->reflectance(si);
  }

  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->reflection_frame(mirrored(si))
                       : sides_.front()->reflection_frame(si);
  }

 private:
  static size_t seen_from_behind(const SurfaceBlock& points) {
    return static_cast<size_t>(std::count_if(points.wi.z, points.wi.z + points.count,
                                             [](float z) { return z < 0; }));
  }
  static wide::Mask is_back_at(const SurfaceBlock& points, size_t i) {
    return wide::Float::load(points.wi.z + i) < 0.f;
  }

  /// Copies `from` to `to`, negated at points that are seen from behind. Both may be the same.
  static void turn(const SurfaceBlock& points, const float* from, float* to) {
    using wide::Float;
    wide::for_lanes(points.count, [&](size_t i) {
      const Float x = Float::load(from + i);
      select(is_back_at(points, i), -x, x).store(to + i);
    });
  }
  /// Returns the points with those that are seen from behind mirrored, see mirrored(). Columns 0 to
  /// 3 of `columns` hold the changed values.
  static SurfaceBlock turned_to_viewer(const SurfaceBlock& points,
                                       const wide::ScratchColumns& columns) {
    SurfaceBlock facing = points;
    facing.sn = columns.three(0);
    facing.wi.z = columns[3];
    turn(points, points.sn.x, facing.sn.x), turn(points, points.sn.y, facing.sn.y);
    turn(points, points.sn.z, facing.sn.z), turn(points, points.wi.z, facing.wi.z);
    return facing;
  }

  /// Copies the back's results at points that are seen from behind.
  struct BackTaker {
    explicit BackTaker(const SurfaceBlock& seen) : points(seen) {}
    void operator()(float* to, const float* from) const {
      using wide::Float;
      wide::for_lanes(points.count, [&](size_t i) {
        select(is_back_at(points, i), Float::load(from + i), Float::load(to + i)).store(to + i);
      });
    }
    void operator()(const Columns3& to, const Columns3& from) const {
      (*this)(to.x, from.x), (*this)(to.y, from.y), (*this)(to.z, from.z);
    }
    const SurfaceBlock& points;
  };

  static void shade_facing(const Bsdf& bsdf, const SurfaceBlock& points, const BsdfQuery& query,
                           const BsdfAnswer& answer) {
    const wide::ScratchColumns columns(5, points.count);
    const SurfaceBlock facing = turned_to_viewer(points, columns);
    BsdfQuery facing_query = query;
    if (query.wo.x) {
      facing_query.wo.z = columns[4];
      turn(points, query.wo.z, facing_query.wo.z);
    }
    bsdf.shade_block(facing, facing_query, answer);
    if (query.u1) turn(points, answer.wo.z, answer.wo.z);
  }

  /// Returns the point mirrored for the back's BSDF, in a left-handed frame.
  static SurfaceInteraction mirrored(const SurfaceInteraction& si) {
    SurfaceInteraction back = si;
    back.frame.n = -si.frame.n;
    back.wi.z = -si.wi.z;
    return back;
  }

  std::vector<std::shared_ptr<Bsdf>> sides_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::TwoSided, kinome::Category::kBsdf, "twosided",
              "Makes one or two one-sided BSDFs visible from both sides.", kinome::kParameters);
