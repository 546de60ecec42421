// Checks of shapes: ray intersections, and points sampled on the surface.
//
// Uniformly distributed lines through a sphere of radius R around the shape cross its surface, with
// area A, A / (2 pi R²) times on average. They cross each part of it in proportion to the part's
// area (Cauchy and Crofton). So rays alone measure areas and positions, whatever the shape is.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "kit/scenes/emitter_scene.h"
#include "kit/scenes/shape_scene.h"

namespace kinome::check {
namespace {

bool lies_within(const Vec3& p, const Aabb& box, float error) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(p[axis] >= box.lo[axis] - error && p[axis] <= box.hi[axis] + error)) return false;
  }
  return true;
}

std::string at(const Vec3& p) {
  return fmt::format(", at ({:.5g}, {:.5g}, {:.5g})", p.x, p.y, p.z);
}

/// Returns what is wrong with a point of a surface, or nullptr.
const char* fault_of_point(const SurfaceInteraction& si) {
  if (!is_finite(si.p)) return "a point that is not finite";
  if (!(si.p_error >= 0 && std::isfinite(si.p_error))) {
    return "a p_error that is negative or not finite";
  }
  if (std::abs(glm::length(si.n) - 1) > 1e-4f) return "a normal n that is not of unit length";
  const Frame& f = si.frame;
  const float across = std::max({std::abs(glm::dot(f.s, f.t)), std::abs(glm::dot(f.s, f.n)),
                                 std::abs(glm::dot(f.t, f.n))});
  const float length = std::max({std::abs(glm::length(f.s) - 1), std::abs(glm::length(f.t) - 1),
                                 std::abs(glm::length(f.n) - 1)});
  if (!(across < 1e-3f && length < 1e-3f)) return "a shading frame that is not orthonormal";
  if (!std::isfinite(si.uv.x) || !std::isfinite(si.uv.y)) return "a uv that is not finite";
  if (!is_finite(si.dp_du) || !is_finite(si.dp_dv)) return "a dp_du or dp_dv that is not finite";
  return nullptr;
}

Outcome shape_interactions(const Subject& subject) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  Random random(subject.request().seed + 1);
  int points = 0;
  const int lines = subject.samples(10000);
  for (int i = 0; i < lines && outcome.passed; ++i) {
    const Ray line = at_shape.line(random);
    at_shape.crossings(line, [&](const RayHit& hit, const SurfaceInteraction& si) {
      ++points;
      if (const char* const fault = fault_of_point(si)) {
        outcome.fail(std::string("interaction() has ") + fault + at(si.p));
      }
      const Vec3 found = hit.ray.at(hit.ray.tmax);
      const float error = 8 * si.p_error + 4e-6f * at_shape.radius + 1e-6f * glm::length(found);
      if (!(glm::length(found - si.p) <= error)) {
        outcome.fail("interaction() has a p that is not where the ray ends" + at(si.p));
      }
      if (!(std::abs(si.t - hit.ray.tmax) <= 1e-5f * hit.ray.tmax)) {
        outcome.fail("interaction() has a t that differs from the ray's tmax" + at(si.p));
      }
      const Vec3 wi = si.frame.to_local(-line.d);
      if (!(glm::length(wi - si.wi) < 1e-3f)) {
        outcome.fail("interaction() has a wi that doesn't point to the ray's origin" + at(si.p));
      }
    });
  }
  if (points == 0) outcome.fail("no ray hits the shape within its bounds");
  outcome.measured = fmt::format("{} hits of {} lines", points, lines);
  return outcome;
}

/// Checks rays with other tmin, tmax and lengths of the direction.
Outcome shape_segments(const Subject& subject) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  Random random(subject.request().seed + 2);
  int tried = 0, other_end = 0, other_begin = 0, other_length = 0;
  for (int i = 0; i < subject.samples(3000); ++i) {
    const Ray line = at_shape.line(random);
    const RayHit hit = trace(*at_shape.scene, line.o, line.d);
    if (!hit.hit.valid()) continue;
    ++tried;
    const float t = hit.ray.tmax;
    other_end += trace(*at_shape.scene, line.o, line.d, 0, 0.999f * t).hit.valid();
    const RayHit next = trace(*at_shape.scene, line.o, line.d, 1.001f * t);
    other_begin += next.hit.valid() && next.ray.tmax < 1.001f * t;
    const RayHit twice = trace(*at_shape.scene, line.o, 2.f * line.d);
    other_length += !twice.hit.valid() || std::abs(2 * twice.ray.tmax - t) > 1e-3f * t;
  }
  outcome.fail_if_many(other_end, tried, 200, "intersect() returns a hit beyond tmax ({} of {})");
  outcome.fail_if_many(other_begin, tried, 200, "intersect() returns a hit before tmin ({} of {})");
  outcome.fail_if_many(
      other_length, tried, 200,
      "intersect() returns a wrong t for a direction of twice the length ({} of {})");
  outcome.measured = fmt::format("{} rays with other tmin, tmax and lengths", tried);
  return outcome;
}

/// Checks that lines leave a closed surface as often as they enter it.
Outcome shape_watertight(const Subject& subject) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  Random random(subject.request().seed + 3);
  const int lines = subject.samples(40000);
  int hit = 0, odd = 0;
  Ray leak;
  for (int i = 0; i < lines; ++i) {
    const Ray line = at_shape.line(random);
    const int count = at_shape.crossings(line, [](const RayHit&, const SurfaceInteraction&) {});
    hit += count > 0;
    if (count % 2) leak = line, ++odd;
  }
  outcome.measured =
      fmt::format("{} of {} lines that hit the surface cross it an odd number of times", odd, hit);
  // An open surface has many such lines. A closed one has only a few, due to rounding at edges.
  const bool is_closed = odd * 50 < hit;
  if (!is_closed) outcome.measured += ": the surface is open";
  if (is_closed && odd * 2000 > hit) {
    outcome.fail(
        fmt::format("rays pass through the closed surface without a hit, such as from "
                    "({:.7g}, {:.7g}, {:.7g}) in direction ({:.7g}, {:.7g}, {:.7g})",
                    leak.o.x, leak.o.y, leak.o.z, leak.d.x, leak.d.y, leak.d.z));
  }
  return outcome;
}

/// Cells of the shape's bounding box, subdivided by the octant of the normal.
struct SurfaceCells {
  static constexpr int kSide = 5;
  const Aabb box;
  size_t count() const { return static_cast<size_t>(kSide) * kSide * kSide * 8; }
  size_t operator()(const SurfaceInteraction& si) const {
    size_t cell = 0;
    if (!is_finite(si.p)) return cell;
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = std::max(box.hi[axis] - box.lo[axis], 1e-20f);
      // The offset keeps symmetry planes and edges of the shape away from the borders of cells.
      const float share = 0.02f + 0.93f * (si.p[axis] - box.lo[axis]) / extent;
      const int part = box.hi[axis] - box.lo[axis] < 1e-4f * glm::length(box.extent())
                           ? 0
                           : std::clamp(static_cast<int>(share * kSide), 0, kSide - 1);
      cell = cell * kSide + static_cast<size_t>(part);
    }
    return cell * 8 + static_cast<size_t>((si.n.x > 0.011f) + 2 * (si.n.y > 0.013f) +
                                          4 * (si.n.z > 0.017f));
  }
};

/// Hits of random lines with a surface: sums over the lines, by cell, and all hits of a line.
struct SurfaceCrossings {
  Moments total;
  std::vector<double> crossed, squares;
};

SurfaceCrossings count_crossings(const ShapeScene& at_shape, const SurfaceCells& cell_of,
                                 int lines, double scale, Random& random) {
  SurfaceCrossings found{{}, std::vector<double>(cell_of.count()),
                         std::vector<double>(cell_of.count())};
  std::vector<int> of_line(cell_of.count());
  for (int i = 0; i < lines; ++i) {
    std::vector<size_t> touched;
    const int count = at_shape.crossings(
        at_shape.line(random), [&](const RayHit&, const SurfaceInteraction& si) {
          const size_t cell = cell_of(si);
          if (of_line[cell]++ == 0) touched.push_back(cell);
        });
    found.total.add(scale * count);
    for (const size_t cell : touched) {
      found.crossed[cell] += of_line[cell];
      found.squares[cell] += of_line[cell] * of_line[cell];
      of_line[cell] = 0;
    }
  }
  return found;
}

/// Compares the area of each cell by lines with that by points of sample_surface(). `own_area` is
/// the area that the shapes return.
Verdict compare_positions(const SurfaceCrossings& found, const std::vector<double>& sampled,
                          int lines, int points, double scale, double own_area, double alpha) {
  std::vector<Estimate> a, b;
  Estimate rest_a, rest_b;
  for (size_t i = 0; i < sampled.size(); ++i) {
    const double n = lines, m = points;
    const Estimate by_rays{scale * found.crossed[i] / n,
                           scale * scale * found.squares[i] / n / n};
    const Estimate by_points{own_area * sampled[i] / m, own_area * own_area * sampled[i] / m / m};
    if (found.crossed[i] + sampled[i] < 40) {
      rest_a.mean += by_rays.mean, rest_a.variance_of_mean += by_rays.variance_of_mean;
      rest_b.mean += by_points.mean, rest_b.variance_of_mean += by_points.variance_of_mean;
    } else {
      a.push_back(by_rays);
      b.push_back(by_points);
    }
  }
  if (rest_a.mean + rest_b.mean > 0.002 * own_area) {
    a.push_back(rest_a);
    b.push_back(rest_b);
  }
  return mean_squares_test(a, b, alpha);
}

Outcome shape_area(const Subject& subject, double alpha) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  Random random(subject.request().seed + 4);
  const double scale =
      2 * std::numbers::pi * double{at_shape.radius} * double{at_shape.radius};
  double own_area = 0;  // by area()
  for (const auto& shape : at_shape.shapes()) own_area += double{shape->area()};
  if (own_area == 0 && at_shape.shapes()[0]->curves()) {
    outcome.measured = "not implemented for curves, which can't emit";
    return outcome;
  }
  const SurfaceCells cell_of{at_shape.scene->bounds()};
  const int lines = subject.samples(60000), points = subject.samples(60000);
  const SurfaceCrossings found = count_crossings(at_shape, cell_of, lines, scale, random);
  const Moments& total = found.total;
  const Verdict area = z_test({{total.mean(), total.variance_of_mean()}},
                              {{own_area, std::pow(1e-3 * own_area, 2)}}, alpha);
  outcome.measured = fmt::format("area() is {:.5g}, by rays {:.5g}", own_area, total.mean());
  if (!area.passed) {
    outcome.fail(fmt::format("area() is {:.4g} times the area by rays", own_area / total.mean()));
    return outcome;
  }
  std::vector<double> sampled(cell_of.count());
  for (const auto& shape : at_shape.shapes()) {
    const int count = static_cast<int>(points * double{shape->area()} / own_area);
    for (int i = 0; i < count; ++i) {
      sampled[cell_of(shape->sample_surface(random.unit2()))] += 1;
    }
  }
  const Verdict positions =
      compare_positions(found, sampled, lines, points, scale, own_area, alpha);
  outcome.measured += "; points: " + positions.text;
  if (!positions.passed) {
    outcome.fail(
        "sample_surface() is not uniform over the surface that rays hit, or returns wrong "
        "normals");
  }
  return outcome;
}

/// Checks that sampled points are on the surface that rays hit, and within the bounds.
Outcome shape_points(const Subject& subject) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  Random random(subject.request().seed + 5);
  int tried = 0, lost = 0, outside = 0;
  for (const auto& shape : at_shape.shapes()) {
    if (shape->curves() && shape->area() == 0) continue;  // curves can't emit or be sampled
    const Aabb bounds = shape->bounds();
    for (int i = 0; i < subject.samples(2000) && outcome.passed; ++i) {
      const SurfaceInteraction si = shape->sample_surface(random.unit2());
      if (const char* const fault = fault_of_point(si)) {
        outcome.fail(std::string("sample_surface() has ") + fault + at(si.p));
      }
      ++tried;
      outside += !lies_within(si.p, bounds, 4 * si.p_error + 1e-6f * at_shape.radius);
      const float off = 0.02f * at_shape.radius;
      const RayHit hit = trace(*at_shape.scene, si.p + off * si.n, -si.n);
      // The ray may also hit another surface in between.
      lost += !hit.hit.valid() || hit.ray.tmax > off * 1.01f + 4 * si.p_error;
    }
  }
  outcome.fail_if_many(outside, tried, 1000,
                       "bounds() leaves out {} of {} points of sample_surface()");
  outcome.fail_if_many(lost, tried, 100, "{} of {} points of sample_surface() are not hit by rays");
  outcome.measured = fmt::format(
      "{} points: {} outside the bounds, {} not hit by rays, bound 1 of "
      "100",
      tried, outside, lost);
  return outcome;
}

constexpr int kViews = 2;

/// Checks sample_solid_angle() and pdf_solid_angle() from some points.
Outcome shape_solid_angle(const Subject& subject, double alpha) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  const Shape& shape = *at_shape.shapes()[0];
  const Vec3 centre = shape.bounds().centre();
  const float radius = 0.5f * glm::length(shape.bounds().extent());
  Random around(subject.request().seed + 6);
  for (int view = 0; view < kViews; ++view) {
    const Vec3 p = centre + radius * (view == 0 ? 1.3f : 3.f) * around.direction();
    std::vector<float> ratios;
    for (int i = 0; i < 300; ++i) {
      const auto sample = shape.sample_solid_angle(p, around.unit2());
      if (!sample) continue;
      SurfaceInteraction si = sample->si;
      si.shape = &shape;
      ratios.push_back(ratio_of(sample->pdf, shape.pdf_solid_angle(p, si)));
    }
    if (!ratios.empty()) {
      check_ratios(ratios,
                   "sample_solid_angle() returns densities {:.4g} times those of pdf_solid_angle()",
                   outcome);
      if (!outcome.passed) return outcome;
    }
    DensityCells test;
    test.sample = [&](Random& random) -> std::optional<Vec3> {
      const auto sample = shape.sample_solid_angle(p, random.unit2());
      if (!sample || !(sample->pdf > 0)) return std::nullopt;
      return glm::normalize(sample->si.p - p);
    };
    test.pdf = [&](const Vec3& d) {
      return double{density_along(*at_shape.scene, p, d, [&](const SurfaceInteraction& si) {
        return si.shape == &shape ? shape.pdf_solid_angle(p, si) : 0.f;
      })};
    };
    test.samples = subject.samples(20000);
    test.seed = subject.request().seed + 7 + static_cast<uint64_t>(view);
    const DensityVerdict verdict = density_test(test, alpha);
    if (outcome.passed) outcome.measured = verdict.text;
    if (!verdict.passed) outcome.fail(cause_of(verdict, "pdf_solid_angle()"));
  }
  return outcome;
}

}  // namespace

void add_shape_checks(const Subject& subject, Plan& plan) {
  // Look at the scene in a separate process: a scene starts threads, and processes that are forked
  // later might wait forever for locks that these threads held.
  const Outcome emptiness = run_in_process([&] {
    Outcome outcome;
    if (ShapeScene(subject).is_empty()) outcome.measured = "empty";
    return outcome;
  });
  if (emptiness.measured == "empty") return;  // such as a group, which only instances show
  plan.add("interactions", 0, [&](double) { return shape_interactions(subject); });
  plan.add("segments", 0, [&](double) { return shape_segments(subject); });
  plan.add("watertight", 0, [&](double) { return shape_watertight(subject); });
  plan.add("points", 0, [&](double) { return shape_points(subject); });
  plan.add("area", 2, [&](double alpha) { return shape_area(subject, alpha); });
  plan.add("solid_angle", kViews, [&](double alpha) { return shape_solid_angle(subject, alpha); });
  plan.add("blocks", 0, [&](double) { return shape_blocks(subject); });
  plan.add("sample_blocks", 0, [&](double) { return shape_sample_blocks(subject); });
}

}  // namespace kinome::check
