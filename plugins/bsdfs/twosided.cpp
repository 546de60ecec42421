#include <algorithm>
#include <array>

#include "batch.h"
#include "kinome/plugin.h"

/// Makes one-sided BSDFs visible from both sides: one nested BSDF serves both, of two the first is
/// the front's and the second the back's. The back sees everything mirrored at the surface.
///
///     <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"bsdf", ParameterType::kObject, nullptr, "one BSDF for both sides, or front and back", true,
     Category::kBsdf, 2},
};

class TwoSided final : public Bsdf {
 public:
  explicit TwoSided(const Properties& props) : sides_(props.objects<Bsdf>()) {
    if (sides_.empty() || sides_.size() > 2) {
      throw props.error("bsdf", "must be one or two nested BSDFs");
    }
    lobes_ = sides_.front()->lobes() | sides_.back()->lobes();
    is_lambertian_ = sides_.front()->is_lambertian() && sides_.back()->is_lambertian();
    turns_to_viewer_ = sides_.front()->turns_to_viewer() || sides_.back()->turns_to_viewer();
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    if (!(si.wi.z < 0)) {
      sides_.front()->eval_pdf(si, mask, wo, out);
      return;
    }
    const SurfaceInteraction back = mirrored(si);
    constexpr size_t kChunk = 256;
    std::array<float, kChunk> z;
    for (size_t begin = 0; begin < wo.count; begin += kChunk) {
      const size_t count = std::min(kChunk, wo.count - begin);
      for (size_t i = 0; i < count; ++i) {
        z[i] = -wo.z[begin + i];
      }
      sides_.back()->eval_pdf(back, mask,
                              DirectionBatch{wo.x + begin, wo.y + begin, z.data(), count},
                              BsdfValueBatch{out.r + begin, out.g + begin, out.b + begin,
                                             out.pdf ? out.pdf + begin : nullptr});
    }
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
    size_t backs = 0;
    for (size_t i = 0; i < points.count; ++i) backs += points.wi.z[i] < 0;
    const bool is_one = sides_.size() == 1;
    if (backs == 0) return sides_.front()->shade_block(points, query, answer);
    if (is_one || backs == points.count) {
      return shade_facing(*sides_.back(), points, query, answer);
    }
    // Each point takes the answer of its side.
    const wide::ScratchColumns columns(12, points.count);
    const BsdfAnswer back{columns.three(0), columns[3],  columns.three(4),
                          columns.three(7), columns[10], columns[11]};
    sides_.front()->shade_block(points, query, answer);
    shade_facing(*sides_.back(), points, query, back);
    using wide::Float;
    wide::for_lanes(points.count, [&](size_t i) {
      const wide::Mask is_back = is_back_at(points, i);
      const auto take = [&](float* to, const float* from) {
        select(is_back, Float::load(from + i), Float::load(to + i)).store(to + i);
      };
      const auto take_three = [&](const Columns3& to, const Columns3& from) {
        take(to.x, from.x), take(to.y, from.y), take(to.z, from.z);
      };
      if (query.wo.x) take_three(answer.f, back.f), take(answer.pdf, back.pdf);
      if (!query.u1) return;
      take_three(answer.wo, back.wo), take_three(answer.weight, back.weight);
      take(answer.sample_pdf, back.sample_pdf), take(answer.is_delta, back.is_delta);
    });
  }

  void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const override {
    size_t backs = 0;
    for (size_t i = 0; i < points.count; ++i) backs += points.wi.z[i] < 0;
    if (backs == 0) return sides_.front()->describe_block(points, out);
    // Of both sides in one block: point by point.
    if (sides_.size() > 1 && backs < points.count) return Bsdf::describe_block(points, out);
    const wide::ScratchColumns columns(4, points.count);
    sides_.back()->describe_block(turned_to_viewer(points, columns), out);
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->form(mirrored(si)) : sides_.front()->form(si);
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->reflectance(mirrored(si)) : sides_.front()->reflectance(si);
  }

  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->reflection_frame(mirrored(si))
                       : sides_.front()->reflection_frame(si);
  }

 private:
  static wide::Mask is_back_at(const SurfaceBlock& points, size_t i) {
    return wide::Float::load(points.wi.z + i) < 0.f;
  }

  /// -from where points are seen from behind, to `to`, which may be the same.
  static void turn(const SurfaceBlock& points, const float* from, float* to) {
    using wide::Float;
    wide::for_lanes(points.count, [&](size_t i) {
      const Float x = Float::load(from + i);
      select(is_back_at(points, i), -x, x).store(to + i);
    });
  }
  /// All points turned to the viewer: those that are seen from behind are mirrored, see mirrored().
  /// Columns 0 to 3 of `columns` hold what differs.
  static SurfaceBlock turned_to_viewer(const SurfaceBlock& points,
                                       const wide::ScratchColumns& columns) {
    SurfaceBlock facing = points;
    facing.sn = columns.three(0);
    facing.wi.z = columns[3];
    turn(points, points.sn.x, facing.sn.x), turn(points, points.sn.y, facing.sn.y);
    turn(points, points.sn.z, facing.sn.z), turn(points, points.wi.z, facing.wi.z);
    return facing;
  }

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

  /// The point as its back sees it, in a left-handed frame.
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
              "One or two one-sided BSDFs, seen from both sides.", kinome::kParameters);
