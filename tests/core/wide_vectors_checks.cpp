// Checks of wide vectors and colours, and of their loads and stores.

#include "wide_checks.h"

namespace kinome::test {
namespace {

using wide::Float;
using wide::Int;
using wide::Mask;

/// Some 1000 pairs of vectors, including axes and equal vectors.
struct VectorPairs {
  VectorPairs() {
    uint32_t state = 1;
    const auto next = [&] {
      state = state * 1664525u + 1013904223u;
      return static_cast<float>(state >> 8) * 0x1p-23f - 1.f;
    };
    for (std::vector<float>& column : columns) column.resize(kCount);
    for (size_t i = 0; i < kCount; ++i) {
      for (std::vector<float>& column : columns) column[i] = next();
      for (size_t k = 0; k < 3 && i % 7 == 0; ++k) columns[k][i] = i % 3 == k ? 1.f : 0.f;
      for (size_t k = 0; k < 3 && i % 11 == 0; ++k) columns[3 + k][i] = columns[k][i];
      for (size_t k = 0; k < 3 && i % 13 == 0; ++k) columns[3 + k][i] = 0.3f * columns[k][i];
    }
  }
  Columns3 a() { return {columns[0].data(), columns[1].data(), columns[2].data()}; }
  Columns3 b() { return {columns[3].data(), columns[4].data(), columns[5].data()}; }
  Columns3 result() { return {columns[6].data(), columns[7].data(), columns[8].data()}; }
  static constexpr size_t kCount = 1008;
  std::array<std::vector<float>, 9> columns;
};

bool near(float a, float b, float tolerance) {
  return same(a, b) || std::abs(a - b) <= tolerance;
}

/// Compares a formula of wide vectors with that of GLM's. The bits must be equal if tolerance is 0.
template <class Formula>
void check_formula(Failures& failures, const char* name, float tolerance, const Formula& formula) {
  VectorPairs pairs;
  const Columns3 a = pairs.a(), b = pairs.b(), result = pairs.result();
  wide::for_lanes(VectorPairs::kCount, [&](size_t i) {
    const wide::Vec3 value = formula(wide::Vec3::load(a, i), wide::Vec3::load(b, i));
    wide::store(value, result, i);
  });
  for (size_t i = 0; i < VectorPairs::kCount; ++i) {
    const glm::vec3 expected = formula(a.at(i), b.at(i)), found = result.at(i);
    for (int k = 0; k < 3; ++k) {
      KINOME_CHECK(near(found[k], expected[k], tolerance),
                   name << ' ' << i << ' ' << k << ": " << found[k] << ", not " << expected[k]);
    }
  }
}

/// As in a plugin: another namespace, with kinome's names visible.
using namespace wide::formulas;

template <class F>
F fresnel(F cos_theta, float eta) {
  const F c = abs(cos_theta);
  const F sin2_t = (1.f - c * c) / (eta * eta);
  const F cos_t = safe_sqrt(1.f - sin2_t);
  const F parallel = (eta * c - cos_t) / (eta * c + cos_t);
  const F perpendicular = (c - eta * cos_t) / (c + eta * cos_t);
  return select(sin2_t < 1.f, 0.5f * (sqr(parallel) + sqr(perpendicular)), 1.f);
}

template <class V>
V reflect_or_black(const V& wi, const V& h) {
  using F = NumberOf<V>;
  const F cosine = dot(wi, h);
  const MaskOf<F> valid = cosine > 0.f && wi.z > 0.f;
  if (none(valid)) return V(0.f);
  const RgbOf<F> weight = Rgb(0.5f, 0.25f, 1.f) * fresnel(cosine, 1.5f);
  return select(valid, (2.f * cosine * h - wi) * weight, V(0.f));
}

#define KINOME_CHECK_FORMULA(tolerance, expression)                                  \
  check_formula(failures, #expression, tolerance, [](const auto& a, const auto& b) { \
    using V = std::remove_cvref_t<decltype(a)>;                                      \
    static_cast<void>(b);                                                            \
    return V(expression);                                                            \
  })

void arithmetic(Failures& failures) {
  KINOME_CHECK_FORMULA(0, a + b);
  KINOME_CHECK_FORMULA(0, a - b);
  KINOME_CHECK_FORMULA(0, a * b);
  KINOME_CHECK_FORMULA(0, a / b);
  KINOME_CHECK_FORMULA(0, -a);
  KINOME_CHECK_FORMULA(0, a * b.x + b.y * a);
  KINOME_CHECK_FORMULA(0, a / b.z);
  KINOME_CHECK_FORMULA(0, 2.f * a - b * 0.5f);
  KINOME_CHECK_FORMULA(0, 1.f - a);
  KINOME_CHECK_FORMULA(0, glm::vec3(1, 2, 3) * a + b.x * glm::vec3(0.5f));
  KINOME_CHECK_FORMULA(0, V(a[2], a[0], b[1]));
  KINOME_CHECK_FORMULA(0, select(a.x < b.x, a, b));
  KINOME_CHECK_FORMULA(0, select(a.x < b.x, a));
  KINOME_CHECK_FORMULA(0, min(a, b));
  KINOME_CHECK_FORMULA(0, max(a, b));
  KINOME_CHECK_FORMULA(0, max(a, b.x));
  KINOME_CHECK_FORMULA(0, clamp(a, -0.5f, 0.25f));
  KINOME_CHECK_FORMULA(0, abs(a));
  KINOME_CHECK_FORMULA(0, sqrt(abs(a)));
  KINOME_CHECK_FORMULA(0, V(max_component(a)));
  KINOME_CHECK_FORMULA(0, V(luminance(a)));
  KINOME_CHECK_FORMULA(0, select(is_black(a - b), a, b));
  KINOME_CHECK_FORMULA(0, select(is_finite(a / b.x), a, b));
  check_formula(failures, "assignments", 0, [](const auto& a, const auto& b) {
    auto c = a;
    c += b, c *= a, c -= b, c /= b;
    c *= b.x, c /= b.y;
    c[1] = a[0];
    return c;
  });
}

void geometry(Failures& failures) {
  KINOME_CHECK_FORMULA(1e-6f, V(dot(a, b)));
  KINOME_CHECK_FORMULA(1e-6f, V(length(a)));
  KINOME_CHECK_FORMULA(1e-6f, normalize(a));
  // The bits must be equal. A fused cross product of a vector with itself would not be 0.
  KINOME_CHECK_FORMULA(0, cross(a, b));
  KINOME_CHECK_FORMULA(0, cross(a, a));
  KINOME_CHECK_FORMULA(0, cross(a, 2.f * a));
  KINOME_CHECK_FORMULA(2e-6f, reflect_or_black(a, b));
  VectorPairs pairs;
  wide::for_lanes(VectorPairs::kCount, [&](size_t i) {
    const wide::Vec3 a = wide::Vec3::load(pairs.a(), i);
    KINOME_CHECK(all(is_black(cross(a, a))), i);
    // normalize(a)| is 1 to a few ulp.
    const wide::Vec3 n = normalize(a);
    KINOME_CHECK(all(abs(dot(n, n) - 1.f) < 4e-7f), i);
  });
}

void plane(Failures& failures) {
  VectorPairs pairs;
  const Columns2 from{pairs.columns[0].data(), pairs.columns[1].data()};
  const Columns2 to{pairs.columns[6].data(), pairs.columns[7].data()};
  const auto formula = [](const auto& u) {
    const auto doubled = 2.f * u - glm::vec2(1.f);
    auto v = floor(doubled * u) + select(u.x < u.y, -u, u / u.x) + select(u.x > 0.f, u);
    v += u, v *= u.y, v -= doubled, v *= doubled, v /= u.y;
    v[0] = doubled[1] + v[0];
    return v;
  };
  wide::for_lanes(VectorPairs::kCount, [&](size_t i) {
    store(formula(load<Float>(from, i)), to, i);
    const wide::Vec2 u = wide::Vec2::load(from, i);
    KINOME_CHECK(all(abs(dot(u, u) - (u.x * u.x + u.y * u.y)) < 1e-6f), i);
    KINOME_CHECK(all(dot(u, u) == 0.f || abs(length(normalize(u)) - 1.f) < 4e-7f), i);
  });
  for (size_t i = 0; i < VectorPairs::kCount; ++i) {
    const glm::vec2 expected = formula(load<float>(from, i)), found = to.at(i);
    KINOME_CHECK(same(found.x, expected.x) && same(found.y, expected.y),
                 i << ": " << found.x << ' ' << found.y);
  }
}

void columns(Failures& failures) {
  static_assert(padded(0) == 0 && padded(1) == 16 && padded(16) == 16 && padded(17) == 32);
  VectorPairs pairs;
  const Columns3 from = pairs.a(), to = pairs.result();
  const Columns2 plane{from.x, from.z};
  std::array<int32_t, kBlockLanes> at{};
  for (size_t i = 0; i < kBlockLanes; ++i) at[i] = static_cast<int32_t>((i * 389 + 5) % 1000);
  const Int index = Int::load(at.data());
  store(gather(from, index), to, 0);
  const wide::Vec2 two = gather(plane, index);
  for (size_t i = 0; i < wide::kLanes; ++i) {
    const auto k = static_cast<size_t>(at[i]);
    KINOME_CHECK(to.at(i) == from.at(k) && gather(from, at[i]) == from.at(k), i);
    KINOME_CHECK(gather(plane, at[i]) == plane.at(k), i);
  }
  two.store({to.y, to.z}, 0);
  for (size_t i = 0; i < wide::kLanes; ++i) {
    KINOME_CHECK(to.y[i] == plane.x[at[i]] && to.z[i] == plane.y[at[i]], i);
  }
  store(load<Float>(from.from(16), 0), to.from(32), 16);
  KINOME_CHECK(to.at(48) == from.at(16), to.x[48]);
  store(load<float>(from, 3), to, 5);
  KINOME_CHECK(to.at(5) == from.at(3), to.x[5]);
  store(load<Float>(from.x), to.x);
  store(load<float>(from.x + 7), to.x + 9);
  KINOME_CHECK(to.x[0] == from.x[0] && to.x[9] == from.x[7], to.x[9]);
  to.set(2, {1, 2, 3});
  Columns2{to.x, to.y}.from(1).set(2, {4, 5});
  KINOME_CHECK(to.at(2) == glm::vec3(1, 2, 3) && to.x[3] == 4 && to.y[3] == 5, to.x[3]);
}

/// A formula has the same values for a point and for a block; exactly if nothing is fused.
void formulas_of_both(Failures& failures) {
  const std::vector<float> cosines = floats_between(-1.f, 1.f, 20000);
  for (const float eta : {1.5f, 0.7f, 1.f, 100.f}) {
    const std::vector<float> found = map_wide(cosines, [&](Float c) { return fresnel(c, eta); });
    for (size_t i = 0; i < cosines.size(); ++i) {
      KINOME_CHECK(same(found[i], fresnel(cosines[i], eta)), cosines[i] << ' ' << eta);
    }
  }
}

}  // namespace

const std::vector<WideCheck>& vector_checks() {
  static const std::vector<WideCheck> checks = {
      {"VectorArithmetic", arithmetic},
      {"Geometry", geometry},
      {"Plane", plane},
      {"Columns", columns},
      {"Formulas", formulas_of_both},
  };
  return checks;
}

}  // namespace kinome::test
