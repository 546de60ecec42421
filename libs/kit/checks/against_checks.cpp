// Compares two emitters that should emit the same light, at receivers in the scene.

#include <cmath>

#include <fmt/format.h>

#include "kit/scenes/light_paths.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Number of tests for a pair of emitters: two for each of two receivers, and one for radiance.
constexpr int kTestsPerPair = 5;

/// Compares the estimates a and b, whose difference was estimated with common random numbers. Equal
/// values may differ by rounding.
Verdict paired_test(const CellFlux& a, const CellFlux& difference, double alpha) {
  constexpr double kRounding = 1e-4;
  std::vector<Estimate> first, second;
  const auto means = a.estimates(), differences = difference.estimates();
  for (size_t i = 0; i < means.size(); ++i) {
    first.push_back({means[i].mean, differences[i].variance_of_mean});
    second.push_back({means[i].mean - differences[i].mean,
                      std::pow(kRounding * means[i].mean, 2)});
  }
  return largest_z_test(first, second, alpha);
}

/// Compares the radiance of two environments in parts of the sphere, at common directions.
Verdict radiance_test(const Emitter& a, const Emitter& b, int count, uint64_t seed, double alpha) {
  Random random(seed);
  std::vector<Vec2> points;
  std::vector<ReceiverCells::Hit> hits;
  for (int i = 0; i < 10000; ++i) {
    const auto sample = (i % 2 ? a : b).sample_direct(Vec3(0.f), random.unit2());
    if (!sample || !(sample->pdf > 0)) continue;
    points.push_back(square_of_direction(sample->d));
    hits.push_back({points.back(), true});
  }
  const ReceiverCells cells(hits, count);
  const ProbeGrid density(points);
  CellFlux first(cells.count()), difference(cells.count());
  for (int i = 0; i < count; ++i) {
    const ProbeGrid::Sample point = density.sample(random);
    const Vec3 d = direction_of_square(point.uv);
    const auto weight = static_cast<float>(4 * std::numbers::pi / point.pdf);
    const Rgb of_a = a.eval_environment(d) * weight;
    first.add(cells.cell_of(point.uv, true), of_a);
    difference.add(cells.cell_of(point.uv, true), of_a - b.eval_environment(d) * weight);
    first.end_sample();
    difference.end_sample();
  }
  return paired_test(first, difference, alpha);
}

class Comparison {
 public:
  Comparison(const Subject& subject, int index, double alpha, Outcome& outcome)
      : own_(subject, index),
        other_(subject, subject.xml_against(), index),
        name_(other_.emitter().plugin()),
        count_(subject.samples(150000)),
        seed_(subject.request().seed + 100 + 20 * static_cast<uint64_t>(index)),
        alpha_(alpha),
        outcome_(outcome) {}

  void run() {
    ProbeRays probes(own_, count_ / 15, seed_);
    if (probes.rays.empty()) probes = ProbeRays(other_, count_ / 15, seed_);
    probes.is_distant |= probes.rays.empty();  // then receivers cover the whole scene
    const Aabb bounds = own_.scene().bounds();
    compare_at(plane_in_the_way(probes, bounds), probes, 1);
    compare_at(sphere_in_the_way(probes, bounds), probes, 5);
    if (!own_.emitter().is_environment() || !other_.emitter().is_environment()) return;
    const Verdict verdict =
        radiance_test(own_.emitter(), other_.emitter(), count_, seed_ + 9, alpha_);
    note("radiance", verdict);
    if (!verdict.passed) outcome_.fail("its radiance differs from that of " + name_);
  }

 private:
  void compare_at(const Receiver& receiver, const ProbeRays& probes, uint64_t offset) {
    const ReceiverPlan plan(receiver, probes, count_);
    const CellFlux own =
        flux_by_sample_direct(own_.emitter(), receiver, plan, count_, seed_ + offset);
    const CellFlux difference = flux_by_sample_direct(own_.emitter(), receiver, plan, count_,
                                                      seed_ + offset, &other_.emitter());
    judge(receiver, "sample_direct()", own.total(), own.total() - difference.total(),
          paired_test(own, difference, alpha_));
    const CellFlux emitted =
        flux_by_emission(own_.emitter(), receiver, plan.cells, count_, seed_ + offset + 1);
    const CellFlux expected =
        flux_by_emission(other_.emitter(), receiver, plan.cells, count_, seed_ + offset + 2);
    if (emitted.contributions() == 0 || expected.contributions() == 0) return;  // not implemented
    judge(receiver, "sample_emission()", emitted.total(), expected.total(),
          largest_z_test(emitted.estimates(), expected.estimates(), alpha_));
  }

  void judge(const Receiver& receiver, const char* function, double own, double other,
             const Verdict& verdict) {
    note(fmt::format("{} at a {}", function, receiver.name()), verdict);
    if (verdict.passed) return;
    const double ratio = own / other;
    outcome_.fail(std::abs(ratio - 1) < 0.01
                      ? fmt::format("its {} sends other colours, or light to other parts of a {}, "
                                    "than that of {}",
                                    function, receiver.name(), name_)
                      : fmt::format("its {} sends {:.4g} times the light of {} to a {}", function,
                                    ratio, name_, receiver.name()));
  }

  void note(const std::string& what, const Verdict& verdict) {
    if (!outcome_.passed) return;
    outcome_.measured += fmt::format("{}{}: p {:.2g}", outcome_.measured.empty() ? "" : ", ", what,
                                     verdict.p_value);
  }

  EmitterScene own_, other_;
  std::string name_;
  int count_;
  uint64_t seed_;
  double alpha_;
  Outcome& outcome_;
};

Outcome emitter_light(const Subject& subject, double alpha) {
  Outcome outcome;
  for (int i = 0; i < EmitterScene::count(subject); ++i) {
    Comparison(subject, i, alpha, outcome).run();
  }
  outcome.measured += fmt::format(", bound {:.0e}", alpha);
  return outcome;
}

}  // namespace

void add_against_check(const Subject& subject, Plan& plan) {
  if (subject.request().against.empty()) return;
  const auto other = std::dynamic_pointer_cast<Emitter>(subject.load(subject.xml_against()));
  if (other->is_surface() != subject.make<Emitter>()->is_surface()) {
    throw Error(
        fmt::format("--against: {} and {} can't be compared, because only one of them is "
                    "part of a shape",
                    subject.title(), other->plugin()));
  }
  plan.add("light", kTestsPerPair * EmitterScene::count(subject),
           [&](double alpha) { return emitter_light(subject, alpha); });
}

}  // namespace kinome::check
