#include "clustered/kernels/lobe_kernels.h"

#include <algorithm>
#include <optional>

#include "clustered/kernels/vector_columns.h"
#include "kinome/warp.h"
#include "kinome/wide/bsdf.h"
#include "kinome/wide/fresnel.h"
#include "kinome/wide/microfacet.h"
#include "kinome/wide/random.h"
#include "kinome/wide/textures.h"

namespace kinome::simd {
namespace {

using namespace wide::formulas;
using wide::Float;
using wide::Int;
using wide::Uint;
using wide::Vec3;

// Values of a group's members are computed once, as columns by member. Each direction then picks
// its member's values.

/// Ways to pick values from a column. If it fits one vector or a few, permutations are faster than
/// gathering.
enum class Picking { kFromOne, kFromFew, kGathered };

template <Picking kPicking>
class GroupMembers {
 public:
  explicit GroupMembers(const PointGroup& group)
      : group_(group), size_(size_of(group.count)), memory_(kMaxColumns, size_) {}

  /// Size of columns: one vector or an even number of vectors. Values behind the last member are
  /// those of the first.
  size_t size() const { return size_; }
  /// Returns memory for one of at most kMaxColumns columns, valid for the lifetime of this object.
  float* column() const { return memory_[columns_++]; }
  /// Indices of the points of members i, i + 1 ...
  KINOME_WIDE wide::Int points(size_t i) const {
    if (i + wide::kLanes <= group_.count) return wide::Int::load(group_.points + i);
    uint32_t points[wide::kLanes];
    for (size_t k = 0; k < wide::kLanes; ++k) {
      points[k] = group_.points[i + k < group_.count ? i + k : 0];
    }
    return wide::Int::load(points);
  }

 private:
  static constexpr size_t kMaxColumns = 16;
  static size_t size_of(size_t count) {
    constexpr size_t two = 2 * wide::kLanes;
    return kPicking == Picking::kFromOne ? wide::kLanes : (count + two - 1) / two * two;
  }
  const PointGroup& group_;
  size_t size_;
  wide::ScratchColumns memory_;
  mutable size_t columns_ = 0;
};

template <Picking kPicking>
class MemberColumn {
 public:
  using Members = GroupMembers<kPicking>;
  /// Gathers the members' values from those of points.
  KINOME_WIDE MemberColumn(const Members& members, const Column<float>& of_points)
      : MemberColumn(members,
                     [&](size_t i) { return gather(of_points.data(), members.points(i)); }) {}
  /// Computes the values by of_members(i), for members i, i + 1 ...
  template <class Function>
  KINOME_WIDE MemberColumn(const Members& members, const Function& of_members)
      : size_(members.size()), values_(members.column()) {
    wide::for_lanes(size_, [&](size_t i) { of_members(i).store(values_ + i); });
  }
  /// Values of members i, i + 1 ...
  KINOME_WIDE wide::Float vector(size_t i) const { return wide::Float::load(values_ + i); }
  /// Values of each direction's member.
  KINOME_WIDE wide::Float operator[](wide::Int member) const {
    if constexpr (kPicking == Picking::kFromOne) {
      return pick(vector(0), member);
    } else if constexpr (kPicking == Picking::kFromFew) {
      constexpr auto two = static_cast<int32_t>(2 * wide::kLanes);
      const wide::Int place = member & (two - 1), first = member - place;
      wide::Float value = pick(vector(0), vector(wide::kLanes), place);
      for (size_t i = two; i < size_; i += two) {
        value = select(first == static_cast<int32_t>(i),
                       pick(vector(i), vector(i + wide::kLanes), place), value);
      }
      return value;
    } else {
      return gather(values_, member);
    }
  }

 private:
  size_t size_;
  float* values_;
};

/// Three columns: vectors of members.
template <Picking kPicking>
class MemberColumns3 {
 public:
  KINOME_WIDE MemberColumns3(const GroupMembers<kPicking>& members,
                             const Column<float> (&of_points)[3])
      : x_(members, of_points[0]), y_(members, of_points[1]), z_(members, of_points[2]) {}
  KINOME_WIDE wide::Vec3 vector(size_t i) const {
    return {x_.vector(i), y_.vector(i), z_.vector(i)};
  }
  KINOME_WIDE wide::Vec3 operator[](wide::Int member) const {
    return {x_[member], y_[member], z_[member]};
  }

 private:
  MemberColumn<kPicking> x_, y_, z_;
};

/// Calls fn(GroupMembers) with the fastest way of picking for this group.
template <class Function>
void with_members(const PointGroup& group, const Function& fn) {
  constexpr size_t kMaxVectorsOfFew = 8;
  if (group.count <= wide::kLanes) return fn(GroupMembers<Picking::kFromOne>(group));
  if (group.count <= kMaxVectorsOfFew * wide::kLanes) {
    return fn(GroupMembers<Picking::kFromFew>(group));
  }
  fn(GroupMembers<Picking::kGathered>(group));
}

KINOME_WIDE Vec3 gather(const Column<float> (&from)[3], Int k) {
  return {wide::gather(from[0].data(), k), wide::gather(from[1].data(), k),
          wide::gather(from[2].data(), k)};
}

/// Indices of the members' points.
KINOME_WIDE Int points_of(const PointGroup& group, const uint32_t* member) {
  return as_int(wide::gather(group.points, Int::load(member)));
}

KINOME_WIDE Float unit_floats(const uint32_t* numbers, uint32_t shift) {
  return to_unit_float(Uint::load(numbers) ^ Uint(shift));
}

/// Returns the tangential part of v for Microfacet::over_alpha2. `tangent` is called only for
/// anisotropic roughness. Then both coordinates are computed: if the second one were computed from
/// |v|², rounding would lose it for sharp lobes.
template <bool is_isotropic, class Tangent>
KINOME_WIDE auto tangential(Vec3 normal, const Tangent& tangent, Vec3 v) {
  if constexpr (is_isotropic) {
    const Vec3 across = cross(normal, v);
    return dot(across, across);
  } else {
    const Vec3 t = tangent();
    return Vec3(dot(t, v), dot(cross(normal, t), v), 0.f);
  }
}

using Ggx = Microfacet<MicrofacetType::kGgx, Float>;

/// Density of sample_lobe; h is the sum of the viewer and the direction.
template <class Tangential>
KINOME_WIDE Float density_of(const Ggx& ggx, const Tangential& h_xy, Float h_z, Float length2) {
  return select(h_z > 0.f && length2 > 1e-12f,
                ggx.mirrored_density(ggx.over_alpha2(h_xy), h_z, length2));
}

template <Picking kPicking>
void sample_lobe_of(const HalfVectorLobe& lobe, const PointFrames& frames,
                    const GroupMembers<kPicking>& members, const uint32_t* member,
                    const ShiftedNumbers& numbers, size_t count, float* dx, float* dy, float* dz) {
  const Ggx ggx(lobe.alpha_u, lobe.alpha_v);
  const MemberColumns3 normal(members, frames.normal), tangent(members, frames.tangent),
      viewer(members, frames.viewer);
  wide::for_lanes(count, [&](size_t i) {
    const Int at = Int::load(member + i);
    const Vec3 n = normal[at], t = tangent[at];
    const Vec3 local = ggx.sample_all_along({unit_floats(numbers.u2 + i, numbers.shift[1]),
                                             unit_floats(numbers.u1 + i, numbers.shift[0])});
    const Vec3 h = mul_add(local.x, t, mul_add(local.y, cross(n, t), n));
    const Vec3 d = mirrored_along(viewer[at], h);
    // A unit vector except for rounding: one Newton step toward 1 / |d|.
    const Vec3 unit = d * (1.5f - 0.5f * dot(d, d));
    unit.store({dx, dy, dz}, i);
  });
}

KINOME_WIDE Float factor_at(const TurnedPoints& turned, Int point, Vec3 d) {
  return perturbed_normal_factor(dot(gather(turned.normal, point), d),
                                 wide::gather(turned.bump_alpha2.data(), point));
}

/// Arguments of evaluate_microfacets that describe its points.
struct Surface {
  const MicrofacetKind& kind;
  const FirstMicrofacet& first;
  const MicrofacetPoints* varying;
  const PointFrames& frames;

  bool is_isotropic(const PointGroup& group) const {
    if (!varying) return first.alpha_u == first.alpha_v;
    return std::all_of(group.points, group.points + group.count,
                       [&](uint32_t k) { return varying->alpha_u[k] == varying->alpha_v[k]; });
  }
  KINOME_WIDE Vec3 fresnel(Float cos_half) const {
    if (!kind.is_conductor) return Vec3(fresnel_dielectric(cos_half, kind.eta[0]));
    const auto channel = [&](int c) {
      return fresnel_conductor(cos_half, Float(kind.eta[c]), Float(kind.k[c]));
    };
    return {channel(0), channel(1), channel(2)};
  }
};

template <Picking kPicking>
struct VaryingColumns {
  VaryingColumns(const GroupMembers<kPicking>& members, const MicrofacetPoints& points)
      : alpha_u(members, points.alpha_u),
        alpha_v(members, points.alpha_v),
        specular(members, points.specular) {}
  MemberColumn<kPicking> alpha_u, alpha_v;
  MemberColumns3<kPicking> specular;
};

template <bool is_isotropic, MicrofacetType kType, Picking kPicking>
void evaluate_microfacets_of(const Surface& surface, const HalfVectorLobe& lobe,
                             const GroupMembers<kPicking>& members, const uint32_t* member,
                             const float* dx, const float* dy, const float* dz, size_t count,
                             const MicrofacetValues& out) {
  using Distribution = Microfacet<kType, Float>;
  const PointFrames& frames = surface.frames;
  const MemberColumns3 normal(members, frames.normal), viewer(members, frames.viewer);
  std::optional<MemberColumns3<kPicking>> tangent;
  if (!is_isotropic) tangent.emplace(members, frames.tangent);

  std::optional<VaryingColumns<kPicking>> varying;
  if (surface.varying) varying.emplace(members, *surface.varying);
  const FirstMicrofacet& first = surface.first;
  Distribution distribution(first.alpha_u, first.alpha_v);
  Vec3 specular(first.specular[0], first.specular[1], first.specular[2]);

  const MemberColumn<kPicking> viewer_g1(members, [&](size_t i) {
    const Vec3 n = normal.vector(i), w = viewer.vector(i);
    if (varying) distribution = {varying->alpha_u.vector(i), varying->alpha_v.vector(i)};
    const auto w_xy = tangential<is_isotropic>(
        n, [&] { return tangent->vector(i); }, w);
    const Float cos_i = dot(n, w);
    return select(cos_i > 0.f, distribution.viewer_g1(distribution.times_alpha2(w_xy), cos_i));
  });

  const Ggx drawn(lobe.alpha_u, lobe.alpha_v);
  wide::for_lanes(count, [&](size_t i) {
    const Int at = Int::load(member + i);
    const Vec3 n = normal[at], w = viewer[at], o = load(dx, dy, dz, i);
    if (varying) {
      distribution = Distribution(varying->alpha_u[at], varying->alpha_v[at]);
      specular = varying->specular[at];
    }
    const auto tangent_at = [&] { return (*tangent)[at]; };
    const Vec3 h = w + o;
    const Float h_z = dot(n, h), length2 = dot(h, h);
    const auto h_xy = tangential<is_isotropic>(n, tangent_at, h);
    density_of(drawn, h_xy, h_z, length2).store(out.density + i);

    const auto reflected =
        distribution.reflect({distribution.over_alpha2(h_xy), h_z, length2},
                             distribution.times_alpha2(tangential<is_isotropic>(n, tangent_at, o)),
                             dot(n, o), viewer_g1[at]);
    const Vec3 f = reflected.dg * surface.fresnel(reflected.cos_half) * specular;
    f.store({out.f[0], out.f[1], out.f[2]}, i);
  });
}

}  // namespace

void sample_lobe(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                 const ShiftedNumbers& numbers, size_t count, float* dx, float* dy, float* dz) {
  with_members(group, [&](const auto& members) {
    sample_lobe_of(lobe, group.frames, members, member, numbers, count, dx, dy, dz);
  });
}

void lobe_density(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                  const float* dx, const float* dy, const float* dz, size_t count, float* density) {
  const Ggx ggx(lobe.alpha_u, lobe.alpha_v);
  wide::for_lanes(count, [&](size_t i) {
    const Int k = points_of(group, member + i);
    const Vec3 n = gather(group.frames.normal, k);
    const Vec3 h = gather(group.frames.viewer, k) + load(dx, dy, dz, i);
    const auto tangent = [&] { return gather(group.frames.tangent, k); };
    density_of(ggx, tangential<false>(n, tangent, h), dot(n, h), dot(h, h)).store(density + i);
  });
}

void evaluate_microfacets(const MicrofacetKind& kind, const FirstMicrofacet& first,
                          const MicrofacetPoints* varying, const HalfVectorLobe& lobe,
                          const PointGroup& group, const uint32_t* member, const float* dx,
                          const float* dy, const float* dz, size_t count,
                          const MicrofacetValues& out) {
  const Surface surface{kind, first, varying, group.frames};
  const bool is_isotropic = lobe.alpha_u == lobe.alpha_v && surface.is_isotropic(group);
  const auto type = kind.is_ggx ? MicrofacetType::kGgx : MicrofacetType::kBeckmann;
  with_members(group, [&](const auto& members) {
    with_microfacet_type(type, [&](auto constant_type) {
      constexpr MicrofacetType kType = decltype(constant_type)::value;
      if (is_isotropic) {
        evaluate_microfacets_of<true, kType>(surface, lobe, members, member, dx, dy, dz, count,
                                             out);
      } else {
        evaluate_microfacets_of<false, kType>(surface, lobe, members, member, dx, dy, dz, count,
                                              out);
      }
    });
  });
}

void multiply_turned_factors(const TurnedPoints& turned, const PointGroup& group,
                             const uint32_t* member, const float* dx, const float* dy,
                             const float* dz, size_t count, float* const f[3]) {
  wide::for_lanes(count, [&](size_t i) {
    const Int k = points_of(group, member + i);
    const Float factor = factor_at(turned, k, load(dx, dy, dz, i));
    for (int c = 0; c < 3; ++c) (Float::load(f[c] + i) * factor).store(f[c] + i);
  });
}

void add_diffuse(const DiffusePoints& points, const PointGroup& group, const uint32_t* member,
                 const float* dx, const float* dy, const float* dz, size_t count,
                 float* const f[3]) {
  wide::for_lanes(count, [&](size_t i) {
    const Int k = points_of(group, member + i);
    const Vec3 d = load(dx, dy, dz, i);
    const Float cosine = dot(gather(group.frames.normal, k), d);
    Float factor = warp::cosine_hemisphere_pdf(cosine);
    if (points.transmittance) factor = factor * tabulated(points.transmittance, cosine);
    if (points.turned) factor = factor * factor_at(*points.turned, k, d);
    for (int c = 0; c < 3; ++c) {
      const Float diffuse = wide::gather(points.diffuse[c].data(), k);
      mul_add(factor, diffuse, Float::load(f[c] + i)).store(f[c] + i);
    }
  });
}

void mix_densities(float share, const PointGroup& group, const uint32_t* member, const float* dx,
                   const float* dy, const float* dz, size_t count, float* density) {
  wide::for_lanes(count, [&](size_t i) {
    const Vec3 n = gather(group.frames.normal, points_of(group, member + i));
    const Float by_cosine = warp::cosine_hemisphere_pdf(dot(n, load(dx, dy, dz, i)));
    mul_add(share, by_cosine, (1 - share) * Float::load(density + i)).store(density + i);
  });
}

}  // namespace kinome::simd
