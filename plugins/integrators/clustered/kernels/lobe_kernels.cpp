#include "clustered/kernels/lobe_kernels.h"

// A scalar target, too, wherever the baseline is one: tests compare with it.
#define HWY_COMPILE_ALL_ATTAINABLE
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clustered/kernels/lobe_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace kinome::simd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kLobeLanes>;
using V = hn::Vec<Tag>;
using IndexTag = hn::RebindToSigned<Tag>;
using Index = hn::Vec<IndexTag>;

constexpr float kPi = std::numbers::pi_v<float>;

struct V3 {
  V x, y, z;
};
HWY_INLINE V3 gather(const kinome::Column<float> (&from)[3], Index i) {
  const Tag d;
  return {hn::GatherIndex(d, from[0].data(), i), hn::GatherIndex(d, from[1].data(), i),
          hn::GatherIndex(d, from[2].data(), i)};
}
HWY_INLINE V dot(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y))};
}

/// Sine and cosine of a turn's share u in [0, 1), to 1e-6: polynomials over an eighth of a turn
/// (Taylor's, as cos and sin of at most pi / 4).
HWY_INLINE void sin_cos_turn(V u, V& sine, V& cosine) {
  const Tag d;
  const V quarters = hn::Round(hn::Mul(u, hn::Set(d, 4.f)));
  const V x = hn::Mul(hn::NegMulAdd(quarters, hn::Set(d, 0.25f), u), hn::Set(d, 2 * kPi));
  const V x2 = hn::Mul(x, x);
  V s = hn::MulAdd(x2, hn::Set(d, 2.75573192e-6f), hn::Set(d, -1.98412698e-4f));
  s = hn::MulAdd(x2, s, hn::Set(d, 8.33333333e-3f));
  s = hn::MulAdd(x2, s, hn::Set(d, -1.66666667e-1f));
  s = hn::Mul(x, hn::MulAdd(x2, s, hn::Set(d, 1.f)));
  V c = hn::MulAdd(x2, hn::Set(d, 2.48015873e-5f), hn::Set(d, -1.38888889e-3f));
  c = hn::MulAdd(x2, c, hn::Set(d, 4.16666667e-2f));
  c = hn::MulAdd(x2, c, hn::Set(d, -0.5f));
  c = hn::MulAdd(x2, c, hn::Set(d, 1.f));
  const auto k = hn::ConvertTo(IndexTag(), quarters);
  const auto one = hn::Set(IndexTag(), 1), two = hn::Set(IndexTag(), 2);
  const auto swap = hn::RebindMask(d, hn::Eq(hn::And(k, one), one));
  const auto negate_sine = hn::RebindMask(d, hn::Eq(hn::And(k, two), two));
  const auto negate_cosine = hn::RebindMask(d, hn::Eq(hn::And(hn::Add(k, one), two), two));
  const V a = hn::IfThenElse(swap, c, s), b = hn::IfThenElse(swap, s, c);
  sine = hn::IfThenElse(negate_sine, hn::Neg(a), a);
  cosine = hn::IfThenElse(negate_cosine, hn::Neg(b), b);
}

/// What a kernel needs to know of a point.
struct Point {
  V3 n, t, b, w;
};
HWY_INLINE Point gather_point(const PointFrames& frames, Index k) {
  Point p{gather(frames.normal, k), gather(frames.tangent, k), {}, gather(frames.viewer, k)};
  p.b = cross(p.n, p.t);
  return p;
}

/// The same of each lane's member of a group, by gathering from memory.
class GatheredPoints {
 public:
  explicit GatheredPoints(const PointGroup& group) : group_(group) {}
  HWY_INLINE Index index(const uint32_t* member) const {
    const IndexTag di;
    const Index m = hn::BitCast(di, hn::LoadU(hn::RebindToUnsigned<Tag>(), member));
    return hn::GatherIndex(di, reinterpret_cast<const int32_t*>(group_.points), m);
  }
  HWY_INLINE Point at(Index k) const { return gather_point(group_.frames, k); }
  /// Values of all points, from which look_up takes those of members.
  using Column = const float*;
  HWY_INLINE void prepare(const kinome::Column<float>& values, Column& column) const {
    column = values.data();
  }
  HWY_INLINE V look_up(const Column& column, Index k) const {
    return hn::GatherIndex(Tag(), column, k);
  }

 private:
  const PointGroup& group_;
};

/// The same where the group fits a few vectors: its members are gathered once, and each direction
/// picks its own by permutations, in place of gathering once more.
class PermutedPoints {
 public:
  static constexpr size_t kMostVectors = 8;
  static constexpr size_t kMostMembers = kMostVectors * kLobeLanes;
  static bool fit(const PointGroup& group) {
    return group.count <= kMostVectors * hn::Lanes(Tag());
  }
  explicit PermutedPoints(const PointGroup& group) : group_(group) {
    const Tag d;
    const size_t lanes = hn::Lanes(d);
    vectors_ = (group.count + lanes - 1) / lanes;
    for (size_t r = 0; r < vectors_; ++r) {
      const Point p = gather_point(group.frames, members(r));
      const V columns[kColumns] = {p.n.x, p.n.y, p.n.z, p.t.x, p.t.y, p.t.z,
                                   p.b.x, p.b.y, p.b.z, p.w.x, p.w.y, p.w.z};
      for (size_t c = 0; c < kColumns; ++c) hn::Store(columns[c], d, &columns_[c][r * lanes]);
    }
  }
  /// Of each direction's member: its place in its vector, and which vector that is.
  struct Places {
    decltype(hn::IndicesFromVec(Tag(), hn::Zero(hn::RebindToUnsigned<Tag>()))) place;
    hn::Vec<hn::RebindToUnsigned<Tag>> first;  ///< of the vector, lanes x its number
  };
  HWY_INLINE Places index(const uint32_t* member) const {
    const hn::RebindToUnsigned<Tag> du;
    const auto m = hn::LoadU(du, member);
    const auto within = hn::Set(du, static_cast<uint32_t>(hn::Lanes(du) - 1));
    return {hn::IndicesFromVec(Tag(), hn::And(m, within)), hn::AndNot(within, m)};
  }
  HWY_INLINE Point at(const Places& places) const {
    const auto three = [&](size_t c) {
      return V3{pick(columns_[c], places), pick(columns_[c + 1], places),
                pick(columns_[c + 2], places)};
    };
    return {three(0), three(3), three(6), three(9)};
  }
  struct Column {
    HWY_ALIGN float values[kMostMembers];
  };
  HWY_INLINE void prepare(const kinome::Column<float>& values, Column& column) const {
    const Tag d;
    for (size_t r = 0; r < vectors_; ++r) {
      hn::Store(hn::GatherIndex(d, values.data(), members(r)), d, column.values + r * hn::Lanes(d));
    }
  }
  HWY_INLINE V look_up(const Column& column, const Places& places) const {
    return pick(column.values, places);
  }

 private:
  static constexpr size_t kColumns = 12;
  /// Of the r-th vector; behind the last member, the first again.
  HWY_INLINE Index members(size_t r) const {
    HWY_ALIGN int32_t k[kLobeLanes];
    for (size_t i = 0; i < hn::Lanes(Tag()); ++i) {
      const size_t member = r * hn::Lanes(Tag()) + i;
      k[i] = static_cast<int32_t>(group_.points[member < group_.count ? member : 0]);
    }
    return hn::Load(IndexTag(), k);
  }
  HWY_INLINE V pick(const float* column, const Places& places) const {
    const Tag d;
    const hn::RebindToUnsigned<Tag> du;
    const size_t lanes = hn::Lanes(d);
    V value = hn::TableLookupLanes(hn::Load(d, column), places.place);
    for (size_t r = 1; r < vectors_; ++r) {
      const auto here = hn::Eq(places.first, hn::Set(du, static_cast<uint32_t>(r * lanes)));
      value = hn::IfThenElse(hn::RebindMask(d, here),
                             hn::TableLookupLanes(hn::Load(d, column + r * lanes), places.place),
                             value);
    }
    return value;
  }
  const PointGroup& group_;
  size_t vectors_;
  HWY_ALIGN float columns_[kColumns][kMostMembers];
};

/// fn(points) with what suits the group and the number of directions.
template <class Function>
HWY_INLINE void with_points(const PointGroup& group, size_t count, const Function& fn) {
  if (PermutedPoints::fit(group) && group.count <= count) {
    fn(PermutedPoints(group));
  } else {
    fn(GatheredPoints(group));
  }
}

/// As to_unit_float.
HWY_INLINE V unit_floats(const uint32_t* numbers, uint32_t shift) {
  const Tag d;
  const hn::RebindToUnsigned<Tag> du;
  const auto bits = hn::ShiftRight<8>(hn::Xor(hn::LoadU(du, numbers), hn::Set(du, shift)));
  return hn::Mul(hn::ConvertTo(d, hn::BitCast(IndexTag(), bits)), hn::Set(d, 0x1p-24f));
}

template <class Points>
HWY_INLINE void sample_lobe_of(const HalfVectorLobe& lobe, const Points& points,
                               const uint32_t* member, const ShiftedNumbers& numbers, size_t count,
                               float* dx, float* dy, float* dz) {
  const Tag d;
  const V one = hn::Set(d, 1.f);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Point p = points.at(points.index(member + i));
    const V u = unit_floats(numbers.u1 + i, numbers.shift[0]);
    V sine, cosine;
    sin_cos_turn(unit_floats(numbers.u2 + i, numbers.shift[1]), sine, cosine);
    const V r = hn::Sqrt(hn::Div(u, hn::Max(hn::Sub(one, u), hn::Set(d, 0x1p-25f))));
    const V x = hn::Mul(hn::Mul(r, cosine), hn::Set(d, lobe.alpha_u));
    const V y = hn::Mul(hn::Mul(r, sine), hn::Set(d, lobe.alpha_v));
    const V3 h{hn::MulAdd(p.t.x, x, hn::MulAdd(p.b.x, y, p.n.x)),
               hn::MulAdd(p.t.y, x, hn::MulAdd(p.b.y, y, p.n.y)),
               hn::MulAdd(p.t.z, x, hn::MulAdd(p.b.z, y, p.n.z))};
    const V scale = hn::Div(hn::Mul(hn::Set(d, 2.f), dot(p.w, h)), dot(h, h));
    const V3 m{hn::MulSub(scale, h.x, p.w.x), hn::MulSub(scale, h.y, p.w.y),
               hn::MulSub(scale, h.z, p.w.z)};
    const V inverse = hn::Div(one, hn::Sqrt(dot(m, m)));
    hn::StoreU(hn::Mul(m.x, inverse), d, dx + i);
    hn::StoreU(hn::Mul(m.y, inverse), d, dy + i);
    hn::StoreU(hn::Mul(m.z, inverse), d, dz + i);
  }
}

void SampleLobe(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                const ShiftedNumbers& numbers, size_t count, float* dx, float* dy, float* dz) {
  with_points(group, count, [&](const auto& points) {
    sample_lobe_of(lobe, points, member, numbers, count, dx, dy, dz);
  });
}

void LobeDensity(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                 const float* dx, const float* dy, const float* dz, size_t count, float* density) {
  const Tag d;
  const V zero = hn::Zero(d);
  const V norm = hn::Set(d, 1 / (4 * kPi * lobe.alpha_u * lobe.alpha_v));
  const V inverse_u2 = hn::Set(d, 1 / (lobe.alpha_u * lobe.alpha_u));
  const V inverse_v2 = hn::Set(d, 1 / (lobe.alpha_v * lobe.alpha_v));
  const GatheredPoints points(group);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Point p = points.at(points.index(member + i));
    const V3 h{hn::Add(p.w.x, hn::LoadU(d, dx + i)), hn::Add(p.w.y, hn::LoadU(d, dy + i)),
               hn::Add(p.w.z, hn::LoadU(d, dz + i))};
    // Unnormalised: D is homogeneous in h, D cos / (4 w.h) = hh² (h.n) / (pi au av q² 4 (w.h)).
    const V hh = dot(h, h), hn_ = dot(h, p.n), wh = dot(p.w, h);
    // Both tangential parts: what hh leaves of the second one would be lost in the rounding of hh
    // where the lobe is sharp.
    const V hu = dot(h, p.t), hv = dot(h, p.b);
    const V q = hn::MulAdd(hn::Mul(hu, hu), inverse_u2,
                           hn::MulAdd(hn::Mul(hv, hv), inverse_v2, hn::Mul(hn_, hn_)));
    const V value = hn::Div(hn::Mul(norm, hn::Mul(hn::Mul(hh, hh), hn_)),
                            hn::Max(hn::Mul(hn::Mul(q, q), wh), hn::Set(d, 1e-30f)));
    const auto valid = hn::And(hn::Gt(hn_, zero), hn::Gt(wh, hn::Set(d, 1e-12f)));
    hn::StoreU(hn::IfThenElseZero(valid, value), d, density + i);
  }
}

/// Share of the microfacets facing v that is seen from v; slope2 = (alpha tan theta)².
HWY_INLINE V smith_g1(bool is_ggx, V slope2) {
  const Tag d;
  const V one = hn::Set(d, 1.f);
  if (is_ggx) return hn::Div(hn::Set(d, 2.f), hn::Add(one, hn::Sqrt(hn::Add(one, slope2))));
  const V a = hn::Div(one, hn::Sqrt(hn::Max(slope2, hn::Set(d, 1e-12f))));
  const V top = hn::Mul(a, hn::MulAdd(a, hn::Set(d, 2.181f), hn::Set(d, 3.535f)));
  const V bottom = hn::MulAdd(a, hn::MulAdd(a, hn::Set(d, 2.577f), hn::Set(d, 2.276f)), one);
  return hn::IfThenElse(hn::Ge(a, hn::Set(d, 1.6f)), one, hn::Div(top, bottom));
}

HWY_INLINE V fresnel_dielectric(V cosine, float eta) {
  const Tag d;
  const V one = hn::Set(d, 1.f), e = hn::Set(d, eta);
  if (eta == 1) return hn::Zero(d);
  const V sin2 = hn::Mul(hn::NegMulAdd(cosine, cosine, one), hn::Set(d, 1 / (eta * eta)));
  const V inside = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(one, sin2)));
  const V s = hn::Div(hn::NegMulAdd(e, inside, cosine), hn::MulAdd(e, inside, cosine));
  const V p = hn::Div(hn::MulSub(e, cosine, inside), hn::MulAdd(e, cosine, inside));
  const V value = hn::Mul(hn::Set(d, 0.5f), hn::MulAdd(s, s, hn::Mul(p, p)));
  return hn::IfThenElse(hn::Ge(sin2, one), one, value);
}

HWY_INLINE V fresnel_conductor(V cosine, float eta, float k) {
  const Tag d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.f), half = hn::Set(d, 0.5f);
  const V cos2 = hn::Mul(cosine, cosine), sin2 = hn::Sub(one, cos2);
  const V t = hn::Sub(hn::Set(d, eta * eta - k * k), sin2);
  const V sum = hn::Sqrt(hn::Max(zero, hn::MulAdd(t, t, hn::Set(d, 4 * eta * eta * k * k))));
  const V a = hn::Sqrt(hn::Max(zero, hn::Mul(half, hn::Add(sum, t))));
  const V c = hn::Mul(hn::Add(cosine, cosine), a);
  const V s_sum = hn::Add(sum, cos2), s_bottom = hn::Add(s_sum, c);
  const V s = hn::IfThenElse(hn::Gt(s_bottom, zero), hn::Div(hn::Sub(s_sum, c), s_bottom), one);
  const V p_sum = hn::MulAdd(sum, cos2, hn::Mul(sin2, sin2));
  const V p_bottom = hn::MulAdd(c, sin2, p_sum);
  const V p =
      hn::IfThenElse(hn::Gt(p_bottom, zero), hn::Div(hn::NegMulAdd(c, sin2, p_sum), p_bottom), one);
  return hn::Max(zero, hn::Mul(half, hn::MulAdd(s, p, s)));
}

/// (alpha tan theta)² of the direction v at a point, alpha being that along v.
HWY_INLINE V slope_squared(const Point& p, const V3& v, V cosine, V alpha_u, V alpha_v) {
  const V x = hn::Mul(dot(p.t, v), alpha_u), y = hn::Mul(dot(p.b, v), alpha_v);
  return hn::Div(hn::MulAdd(x, x, hn::Mul(y, y)),
                 hn::Max(hn::Mul(cosine, cosine), hn::Set(Tag(), 1e-20f)));
}

template <class Points>
HWY_INLINE void evaluate_microfacets_of(const MicrofacetKind& kind, const FirstMicrofacet& first,
                                        const MicrofacetPoints* varying, const HalfVectorLobe& lobe,
                                        const Points& points, const uint32_t* member,
                                        const float* dx, const float* dy, const float* dz,
                                        size_t count, const MicrofacetValues& out) {
  const Tag d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.f);
  const V density_norm = hn::Set(d, 1 / (4 * kPi * lobe.alpha_u * lobe.alpha_v));
  const V inverse_u2 = hn::Set(d, 1 / (lobe.alpha_u * lobe.alpha_u));
  const V inverse_v2 = hn::Set(d, 1 / (lobe.alpha_v * lobe.alpha_v));
  V alpha_u = hn::Set(d, first.alpha_u), alpha_v = hn::Set(d, first.alpha_v);
  V inverse_u = hn::Set(d, 1 / first.alpha_u), inverse_v = hn::Set(d, 1 / first.alpha_v);
  typename Points::Column alpha_column[2], specular_column[3];
  if (varying) {
    points.prepare(varying->alpha_u, alpha_column[0]);
    points.prepare(varying->alpha_v, alpha_column[1]);
    for (int c = 0; c < 3; ++c) points.prepare(varying->specular[c], specular_column[c]);
  }
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto at = points.index(member + i);
    const Point p = points.at(at);
    const V3 o{hn::LoadU(d, dx + i), hn::LoadU(d, dy + i), hn::LoadU(d, dz + i)};
    if (varying) {
      alpha_u = points.look_up(alpha_column[0], at);
      alpha_v = points.look_up(alpha_column[1], at);
      inverse_u = hn::Div(one, alpha_u);
      inverse_v = hn::Div(one, alpha_v);
    }
    const V3 sum{hn::Add(p.w.x, o.x), hn::Add(p.w.y, o.y), hn::Add(p.w.z, o.z)};
    const V scale = hn::Div(one, hn::Sqrt(hn::Max(dot(sum, sum), hn::Set(d, 1e-20f))));
    const V3 h{hn::Mul(sum.x, scale), hn::Mul(sum.y, scale), hn::Mul(sum.z, scale)};
    const V cos_i = dot(p.n, p.w), cos_o = dot(p.n, o), cos_h = dot(p.n, h);
    const V cos_half = hn::Min(hn::Max(dot(p.w, h), zero), one);
    const V ht = dot(p.t, h), hb = dot(p.b, h), z2 = hn::Mul(cos_h, cos_h);
    {  // as lobe_density
      const V q =
          hn::MulAdd(hn::Mul(ht, ht), inverse_u2, hn::MulAdd(hn::Mul(hb, hb), inverse_v2, z2));
      const V value = hn::Div(hn::Mul(density_norm, cos_h),
                              hn::Max(hn::Mul(hn::Mul(q, q), cos_half), hn::Set(d, 1e-30f)));
      const auto met = hn::And(hn::Gt(cos_h, zero), hn::Gt(cos_half, hn::Set(d, 1e-6f)));
      hn::StoreU(hn::IfThenElseZero(met, value), d, out.density + i);
    }
    const V hu = hn::Mul(ht, inverse_u), hv = hn::Mul(hb, inverse_v);
    const V r2 = hn::MulAdd(hu, hu, hn::Mul(hv, hv));
    V distribution = hn::Mul(hn::Mul(inverse_u, inverse_v), hn::Set(d, 1 / kPi));
    if (kind.is_ggx) {
      const V q = hn::Add(r2, z2);
      distribution = hn::Div(distribution, hn::Max(hn::Mul(q, q), hn::Set(d, 1e-30f)));
    } else {
      const V safe2 = hn::Max(z2, hn::Set(d, 1e-12f));
      const V exponent = hn::Max(hn::Neg(hn::Div(r2, safe2)), hn::Set(d, -87.f));
      distribution = hn::Div(hn::Mul(distribution, hn::Exp(d, exponent)), hn::Mul(safe2, safe2));
    }
    const V g = hn::Mul(smith_g1(kind.is_ggx, slope_squared(p, p.w, cos_i, alpha_u, alpha_v)),
                        smith_g1(kind.is_ggx, slope_squared(p, o, cos_o, alpha_u, alpha_v)));
    const auto valid = hn::And(
        hn::And(hn::Gt(cos_i, zero), hn::Gt(cos_o, zero)),
        hn::And(hn::Gt(hn::Mul(distribution, cos_h), hn::Set(d, 1e-20f)), hn::Gt(cos_half, zero)));
    const V value = hn::IfThenElseZero(
        valid, hn::Div(hn::Mul(distribution, g),
                       hn::Max(hn::Mul(hn::Set(d, 4.f), cos_i), hn::Set(d, 1e-20f))));
    V fresnel = zero;
    if (!kind.is_conductor) fresnel = fresnel_dielectric(cos_half, kind.eta[0]);
    for (int c = 0; c < 3; ++c) {
      if (kind.is_conductor) fresnel = fresnel_conductor(cos_half, kind.eta[c], kind.k[c]);
      const V specular =
          varying ? points.look_up(specular_column[c], at) : hn::Set(d, first.specular[c]);
      hn::StoreU(hn::Mul(value, hn::Mul(fresnel, specular)), d, out.f[c] + i);
    }
  }
}

void EvaluateMicrofacets(const MicrofacetKind& kind, const FirstMicrofacet& first,
                         const MicrofacetPoints* varying, const HalfVectorLobe& lobe,
                         const PointGroup& group, const uint32_t* member, const float* dx,
                         const float* dy, const float* dz, size_t count,
                         const MicrofacetValues& out) {
  with_points(group, count, [&](const auto& points) {
    evaluate_microfacets_of(kind, first, varying, lobe, points, member, dx, dy, dz, count, out);
  });
}

void MultiplyTurnedFactors(const TurnedPoints& turned, const PointGroup& group,
                           const uint32_t* member, const float* dx, const float* dy,
                           const float* dz, size_t count, float* const f[3]) {
  const Tag d;
  const V one = hn::Set(d, 1.f);
  const GatheredPoints points(group);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Index k = points.index(member + i);
    const V3 o{hn::LoadU(d, dx + i), hn::LoadU(d, dy + i), hn::LoadU(d, dz + i)};
    const V cosine = dot(gather(turned.normal, k), o);
    const V cos2 = hn::Min(hn::Max(hn::Mul(cosine, cosine), hn::Set(d, 1e-12f)), one);
    const V tan2 = hn::Div(hn::Sub(one, cos2), cos2);
    const V alpha2 = hn::GatherIndex(d, turned.bump_alpha2.data(), k);
    const V root = hn::Sqrt(hn::MulAdd(alpha2, tan2, one));
    const V factor = hn::IfThenElseZero(hn::Gt(cosine, hn::Zero(d)),
                                        hn::Div(hn::Set(d, 2.f), hn::Add(one, root)));
    for (int c = 0; c < 3; ++c) {
      hn::StoreU(hn::Mul(hn::LoadU(d, f[c] + i), factor), d, f[c] + i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinome::simd {

HWY_EXPORT(SampleLobe);
HWY_EXPORT(LobeDensity);
HWY_EXPORT(EvaluateMicrofacets);
HWY_EXPORT(MultiplyTurnedFactors);

void sample_lobe(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                 const ShiftedNumbers& numbers, size_t count, float* dx, float* dy, float* dz) {
  HWY_DYNAMIC_DISPATCH(SampleLobe)(lobe, group, member, numbers, count, dx, dy, dz);
}

void lobe_density(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                  const float* dx, const float* dy, const float* dz, size_t count, float* density) {
  HWY_DYNAMIC_DISPATCH(LobeDensity)(lobe, group, member, dx, dy, dz, count, density);
}

void evaluate_microfacets(const MicrofacetKind& kind, const FirstMicrofacet& first,
                          const MicrofacetPoints* varying, const HalfVectorLobe& lobe,
                          const PointGroup& group, const uint32_t* member, const float* dx,
                          const float* dy, const float* dz, size_t count,
                          const MicrofacetValues& out) {
  HWY_DYNAMIC_DISPATCH(EvaluateMicrofacets)
  (kind, first, varying, lobe, group, member, dx, dy, dz, count, out);
}

void multiply_turned_factors(const TurnedPoints& points, const PointGroup& group,
                             const uint32_t* member, const float* dx, const float* dy,
                             const float* dz, size_t count, float* const f[3]) {
  HWY_DYNAMIC_DISPATCH(MultiplyTurnedFactors)(points, group, member, dx, dy, dz, count, f);
}

}  // namespace kinome::simd
#endif
