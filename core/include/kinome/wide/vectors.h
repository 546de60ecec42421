#pragma once

// Vectors of wide numbers, and the types that belong to a number type (VecOf<F>, MaskOf<F> ...) for
// formulas.

#include "kinome/color.h"
#include "kinome/math.h"
#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// 2D vector per lane.
struct Vec2 {
  Float x, y;

  Vec2() = default;
  KINOME_WIDE Vec2(Float x_, Float y_) : x(x_), y(y_) {}
  KINOME_WIDE explicit Vec2(Float a) : x(a), y(a) {}
  KINOME_WIDE Vec2(const glm::vec2& a) : x(a.x), y(a.y) {}
  /// Loads values i, i + 1 ... of columns.
  KINOME_WIDE static Vec2 load(const Columns2& c, size_t i) {
    return {Float::load(c.x + i), Float::load(c.y + i)};
  }
  KINOME_WIDE void store(const Columns2& c, size_t i) const { x.store(c.x + i), y.store(c.y + i); }
  /// Loads x, y, x, y ...
  KINOME_WIDE static Vec2 load_interleaved(const float* p) {
    Vec2 a;
    hn::LoadInterleaved2(FloatTag(), p, a.x.v, a.y.v);
    return a;
  }
  KINOME_WIDE void store_interleaved(float* p) const {
    hn::StoreInterleaved2(x.v, y.v, FloatTag(), p);
  }
  KINOME_WIDE Float& operator[](int i) { return i == 0 ? x : y; }
  KINOME_WIDE const Float& operator[](int i) const { return i == 0 ? x : y; }

  friend KINOME_WIDE Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend KINOME_WIDE Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend KINOME_WIDE Vec2 operator*(Vec2 a, Vec2 b) { return {a.x * b.x, a.y * b.y}; }
  friend KINOME_WIDE Vec2 operator/(Vec2 a, Vec2 b) { return {a.x / b.x, a.y / b.y}; }

  friend KINOME_WIDE Vec2 operator-(Vec2 a) { return {-a.x, -a.y}; }
  friend KINOME_WIDE Vec2 select(Mask m, Vec2 a, Vec2 b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y)};
  }
  friend KINOME_WIDE Vec2 select(Mask m, Vec2 a) { return {select(m, a.x), select(m, a.y)}; }
  friend KINOME_WIDE Float dot(Vec2 a, Vec2 b) { return mul_add(a.x, b.x, a.y * b.y); }
  friend KINOME_WIDE Float length(Vec2 a) { return sqrt(dot(a, a)); }
  friend KINOME_WIDE Vec2 floor(Vec2 a) { return {floor(a.x), floor(a.y)}; }
};

/// Point, direction or colour per lane.
struct Vec3 {
  Float x, y, z;

  Vec3() = default;
  KINOME_WIDE Vec3(Float x_, Float y_, Float z_) : x(x_), y(y_), z(z_) {}
  KINOME_WIDE explicit Vec3(Float a) : x(a), y(a), z(a) {}
  KINOME_WIDE Vec3(const glm::vec3& a) : x(a.x), y(a.y), z(a.z) {}
  /// Loads values i, i + 1 ... of columns.
  KINOME_WIDE static Vec3 load(const Columns3& c, size_t i) {
    return {Float::load(c.x + i), Float::load(c.y + i), Float::load(c.z + i)};
  }
  KINOME_WIDE void store(const Columns3& c, size_t i) const {
    x.store(c.x + i), y.store(c.y + i), z.store(c.z + i);
  }
  /// Loads x, y, z, x, y, z ...
  KINOME_WIDE static Vec3 load_interleaved(const float* p) {
    Vec3 a;
    hn::LoadInterleaved3(FloatTag(), p, a.x.v, a.y.v, a.z.v);
    return a;
  }
  KINOME_WIDE void store_interleaved(float* p) const {
    hn::StoreInterleaved3(x.v, y.v, z.v, FloatTag(), p);
  }
  KINOME_WIDE Float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  KINOME_WIDE const Float& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }

  friend KINOME_WIDE Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend KINOME_WIDE Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend KINOME_WIDE Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend KINOME_WIDE Vec3 operator/(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }

  friend KINOME_WIDE Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend KINOME_WIDE Vec3 select(Mask m, Vec3 a, Vec3 b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
  }
  friend KINOME_WIDE Vec3 select(Mask m, Vec3 a) {
    return {select(m, a.x), select(m, a.y), select(m, a.z)};
  }
  /// a b + c, as for numbers.
  friend KINOME_WIDE Vec3 mul_add(Float a, Vec3 b, Vec3 c) {
    return {mul_add(a, b.x, c.x), mul_add(a, b.y, c.y), mul_add(a, b.z, c.z)};
  }
  friend KINOME_WIDE Float dot(Vec3 a, Vec3 b) {
    return mul_add(a.x, b.x, mul_add(a.y, b.y, a.z * b.z));
  }
  /// Rounds both products of each difference, so that equal products give 0.
  friend KINOME_WIDE Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  friend KINOME_WIDE Float length(Vec3 a) { return sqrt(dot(a, a)); }
  /// Componentwise functions.
  friend KINOME_WIDE Vec3 min(Vec3 a, Vec3 b) {
    return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
  }
  friend KINOME_WIDE Vec3 max(Vec3 a, Vec3 b) {
    return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
  }
  friend KINOME_WIDE Vec3 min(Vec3 a, Float b) { return min(a, Vec3(b)); }
  friend KINOME_WIDE Vec3 max(Vec3 a, Float b) { return max(a, Vec3(b)); }
  friend KINOME_WIDE Vec3 clamp(Vec3 a, Float lo, Float hi) { return min(max(a, lo), hi); }
  friend KINOME_WIDE Vec3 abs(Vec3 a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
  friend KINOME_WIDE Vec3 sqrt(Vec3 a) { return {sqrt(a.x), sqrt(a.y), sqrt(a.z)}; }
  friend KINOME_WIDE Float max_component(Vec3 a) { return max(max(a.x, a.y), a.z); }
  friend KINOME_WIDE Mask is_finite(Vec3 a) {
    return is_finite(a.x) & is_finite(a.y) & is_finite(a.z);
  }
  friend KINOME_WIDE Mask is_black(Vec3 c) { return (c.x == 0.f) & (c.y == 0.f) & (c.z == 0.f); }
  /// Luminance of linear Rec.709, see kinome/color.h.
  friend KINOME_WIDE Float luminance(Vec3 c) {
    return 0.212671f * c.x + 0.715160f * c.y + 0.072169f * c.z;
  }
};
using Rgb = Vec3;

/// Operators between a vector and a number, and assignments.
#define KINOME_WIDE_OPERATORS(V, op)             \
  KINOME_WIDE V operator op(V a, Float b) {      \
    return a op V(b);                            \
  }                                              \
  KINOME_WIDE V operator op(Float a, V b) {      \
    return V(a) op b;                            \
  }                                              \
  KINOME_WIDE V& operator op##=(V& a, V b) {     \
    return a = a op b;                           \
  }                                              \
  KINOME_WIDE V& operator op##=(V& a, Float b) { \
    return a = a op b;                           \
  }
KINOME_WIDE_OPERATORS(Vec2, +)
KINOME_WIDE_OPERATORS(Vec2, -)
KINOME_WIDE_OPERATORS(Vec2, *)
KINOME_WIDE_OPERATORS(Vec2, /)
KINOME_WIDE_OPERATORS(Vec3, +)
KINOME_WIDE_OPERATORS(Vec3, -)
KINOME_WIDE_OPERATORS(Vec3, *)
KINOME_WIDE_OPERATORS(Vec3, /)
#undef KINOME_WIDE_OPERATORS

/// Requires a squared length that is neither 0 nor infinite.
KINOME_WIDE Vec2 normalize(Vec2 a) {
  return a * (1.f / length(a));
}
KINOME_WIDE Vec3 normalize(Vec3 a) {
  return a * (1.f / length(a));
}

template <class M, class V>
KINOME_WIDE V matrix_times(const M& m, V a) {
  return {m[0][0] * a.x + m[1][0] * a.y + m[2][0] * a.z,
          m[0][1] * a.x + m[1][1] * a.y + m[2][1] * a.z,
          m[0][2] * a.x + m[1][2] * a.y + m[2][2] * a.z};
}
KINOME_WIDE Vec3 operator*(const glm::mat3& m, Vec3 a) {
  return matrix_times(m, a);
}
/// Product with the transpose of m.
KINOME_WIDE Vec3 operator*(Vec3 a, const glm::mat3& m) {
  return matrix_times(glm::transpose(m), a);
}

/// Loads values of columns at each lane's index.
KINOME_WIDE Vec2 gather(const Columns2& c, Int i) {
  return {gather(c.x, i), gather(c.y, i)};
}
KINOME_WIDE Vec3 gather(const Columns3& c, Int i) {
  return {gather(c.x, i), gather(c.y, i), gather(c.z, i)};
}

template <class F>
struct NumberTraits;
template <>
struct NumberTraits<float> {
  using Mask = bool;
  using Int = int32_t;
  using Uint = uint32_t;
  using Vec2 = glm::vec2;
  using Vec3 = glm::vec3;
};
template <>
struct NumberTraits<Float> {
  using Mask = wide::Mask;
  using Int = wide::Int;
  using Uint = wide::Uint;
  using Vec2 = wide::Vec2;
  using Vec3 = wide::Vec3;
};

inline namespace formulas {

/// Types that belong to the number type F, float or wide::Float. The compiler can't deduce F from a
/// parameter of type VecOf<F>; another parameter or the caller must determine it. NumberOf is the
/// reverse.
template <class F>
using MaskOf = typename NumberTraits<F>::Mask;
template <class F>
using IntOf = typename NumberTraits<F>::Int;
template <class F>
using UintOf = typename NumberTraits<F>::Uint;
template <class F>
using Vec2Of = typename NumberTraits<F>::Vec2;
template <class F>
using VecOf = typename NumberTraits<F>::Vec3;
template <class F>
using RgbOf = VecOf<F>;
/// Number type of a vector type: NumberOf<decltype(wo)>.
template <class V>
using NumberOf = std::remove_cvref_t<decltype(std::declval<V>().x)>;

using glm::cross;
using glm::dot;
using glm::length;
using glm::normalize;
using kinome::is_black;
using kinome::is_finite;
using kinome::luminance;
using kinome::max_component;
using kinome::safe_sqrt;
using kinome::sqr;

KINOME_WIDE glm::vec2 gather(const Columns2& c, std::same_as<int32_t> auto i) {
  return c.at(static_cast<size_t>(i));
}
KINOME_WIDE glm::vec3 gather(const Columns3& c, std::same_as<int32_t> auto i) {
  return c.at(static_cast<size_t>(i));
}

/// Loads an F from p, or a vector from values i ... of columns.
template <class F>
KINOME_WIDE F load(const float* p) {
  if constexpr (std::same_as<F, float>) {
    return *p;
  } else {
    return F::load(p);
  }
}
template <class F>
KINOME_WIDE Vec2Of<F> load(const Columns2& c, size_t i) {
  return {load<F>(c.x + i), load<F>(c.y + i)};
}
template <class F>
KINOME_WIDE VecOf<F> load(const Columns3& c, size_t i) {
  return {load<F>(c.x + i), load<F>(c.y + i), load<F>(c.z + i)};
}
KINOME_WIDE void store(Real auto a, float* p) {
  *p = a;
}
KINOME_WIDE void store(const glm::vec2& a, const Columns2& c, size_t i) {
  c.set(i, a);
}
KINOME_WIDE void store(const glm::vec3& a, const Columns3& c, size_t i) {
  c.set(i, a);
}

}  // namespace formulas

KINOME_WIDE void store(Float a, float* p) {
  a.store(p);
}
KINOME_WIDE void store(Vec2 a, const Columns2& c, size_t i) {
  a.store(c, i);
}
KINOME_WIDE void store(Vec3 a, const Columns3& c, size_t i) {
  a.store(c, i);
}

/// Calls fn(i) for each vector of `count` values, where i is the index of its first value: 0,
/// kLanes ... The last vector may extend into the columns' padding.
template <class Function>
KINOME_WIDE void for_lanes(size_t count, const Function& fn) {
  for (size_t i = 0; i < count; i += kLanes) fn(i);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
