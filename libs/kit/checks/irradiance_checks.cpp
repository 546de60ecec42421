// Compares the light at a receiver by sample_emission(), with rays from the emitter, and by
// sample_direct(), at points of the receiver. The two use different densities, so a density with a
// wrong constant factor is found.

#include <cmath>

#include <fmt/format.h>

#include "kit/scenes/light_paths.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Minimum number of rays that cross a receiver, so that means are normally distributed.
constexpr double kMinCrossings = 100;

/// Describes a difference between the flux by light tracing, `emitted`, and by sample_direct(),
/// `seen`.
std::string cause_of_difference(const Receiver& receiver, double emitted, double seen) {
  if (seen == 0) {
    return fmt::format("sample_emission() sends light to a {}, where sample_direct() returns none",
                       receiver.name());
  }
  const double ratio = emitted / seen;
  if (std::abs(ratio - 1) < 0.02) {
    return fmt::format(
        "sample_emission() sends other colours, or light to other parts of a {}, "
        "than sample_direct() returns there",
        receiver.name());
  }
  return fmt::format(
      "sample_emission() sends {:.3g} times the light to a {} that sample_direct() "
      "returns there",
      ratio, receiver.name());
}

void test_receiver(const Subject& subject, const EmitterScene& at, const ProbeRays& probes,
                   const Receiver& receiver, uint64_t seed, double alpha, Outcome& outcome) {
  const int count = subject.samples(150000);
  const ReceiverPlan plan(receiver, probes, count);
  const CellFlux seen = flux_by_sample_direct(at.emitter(), receiver, plan, count, seed);
  const CellFlux emitted =
      flux_by_emission(at.emitter(), receiver, plan.cells, count, seed + 1);
  if (at.is_surface() && seen.contributions() == 0) {
    outcome.measured =
        "sample_direct() returns no light, as for surfaces that emit in single "
        "directions";
    return;
  }
  const bool has_light = seen.contributions() > kMinCrossings;
  if (plan.expected_hits < kMinCrossings && (has_light || plan.expected_hits > 0)) {
    const std::string text = fmt::format("{} of {} rays of sample_emission() hit a {}",
                                         emitted.contributions(), count, receiver.name());
    if (has_light && plan.expected_hits == 0) {
      outcome.fail(text + ", where sample_direct() returns light");
    } else {
      outcome.measured += (outcome.measured.empty() ? "" : "; ") + text + ": too few to test";
    }
    return;
  }
  const Verdict verdict = largest_z_test(emitted.estimates(), seen.estimates(), alpha);
  if (outcome.passed) {
    if (!outcome.measured.empty()) outcome.measured += "; ";
    outcome.measured +=
        fmt::format("{}: {:.4g} times the light, p {:.2g} for {} cells", receiver.name(),
                    emitted.total() / seen.total(), verdict.p_value, plan.cells.count());
  }
  if (!verdict.passed) {
    outcome.fail(cause_of_difference(receiver, emitted.total(), seen.total()));
  }
}

Outcome emitter_irradiance(const Subject& subject, double alpha) {
  Outcome outcome;
  const uint64_t seed = subject.request().seed + 60;
  for (int i = 0; i < EmitterScene::count(subject); ++i) {
    const EmitterScene at(subject, i);
    const ProbeRays probes(at, subject.samples(10000), seed + static_cast<uint64_t>(i));
    if (probes.rays.empty()) {
      outcome.measured = "sample_emission() is not implemented, or returns no light";
      return outcome;
    }
    const Aabb bounds = at.scene().bounds();
    const uint64_t own_seed = seed + 10 + 4 * static_cast<uint64_t>(i);
    test_receiver(subject, at, probes, plane_in_the_way(probes, bounds), own_seed, alpha, outcome);
    test_receiver(subject, at, probes, sphere_in_the_way(probes, bounds), own_seed + 2, alpha,
                  outcome);
  }
  outcome.measured += fmt::format(", bound {:.0e}", alpha);
  return outcome;
}

}  // namespace

void add_irradiance_checks(const Subject& subject, Plan& plan) {
  plan.add("irradiance", 2 * EmitterScene::count(subject),
           [&](double alpha) { return emitter_irradiance(subject, alpha); });
}

}  // namespace kinome::check
