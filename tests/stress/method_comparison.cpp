#include "method_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "kinome/sampler.h"
#include "kinome/sensor.h"
#include "luck.h"

namespace kinome::test {
namespace {

constexpr double kSuspicious = 1e-4, kCertain = 1e-6;
/// Number of repetitions of a suspicious comparison. The last one has as many renders as a number
/// of samples allows. Cheap methods find rarely what the others find reliably. If clusters nearly
/// always miss a point next to a surface, even a thousand renders are all too dark, and their
/// variance doesn't show it.
constexpr size_t kRepetitions = 3;
constexpr double kMaxSamples = 8e6, kMaxSamplesOfCostly = 2e6;
/// The last repetition has between these multiples of the renders of the one before.
constexpr int kMinFactor = 2, kMaxFactor = 32, kMaxFactorOfCostly = 4;
constexpr int kTiles = 2;
/// Expected number of hits below which light is found only by chance.
constexpr double kMinHits = 10;
/// Expected number of hits below which light is hardly ever found.
constexpr double kMinHiddenHits = 1;
/// A comparison is open if a single sample contributes a larger fraction of the sum.
constexpr double kMaxContribution = 0.05;

/// True if all renders are identical.
bool is_constant(const std::vector<TileEstimate>& tiles) {
  return std::all_of(tiles.begin(), tiles.end(),
                     [](const TileEstimate& tile) { return tile.estimate.variance_of_mean == 0; });
}
void make_exact(std::vector<TileEstimate>& tiles) {
  for (TileEstimate& tile : tiles) {
    tile.freedom = tile.spread = std::numeric_limits<double>::infinity();
  }
}
/// Returns how much less light b has than a, in the tile and channel with the largest difference
/// beyond noise.
double missing_light(const std::vector<TileEstimate>& a, const std::vector<TileEstimate>& b) {
  constexpr double kNoise = 4;
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const Estimate &more = a[i].estimate, &less = b[i].estimate;
    const double missing = more.mean - less.mean;
    const double noise = std::sqrt(more.variance_of_mean + less.variance_of_mean);
    if (missing > kNoise * noise) largest = std::max(largest, missing);
  }
  return largest;
}
/// Number of samples of one comparison, assuming one per pixel.
double number_of_pixels(const Renders& renders) {
  return static_cast<double>(renders.pixels.size() * renders.pixels[0].size()) / 3;
}
bool is_cheap(const Method& method) {
  return !method.name.starts_with("product") && !method.same_seeds &&
         !method.name.starts_with("groundtruth");
}

}  // namespace

bool MethodComparison::Comparison::is_open() const {
  return agreement.is_open || largest > kMaxContribution || is_chance;
}

const Method& MethodComparison::method_named(const std::string& name) const {
  for (const Method& method : scene_.task().methods) {
    if (method.name == name) return method;
  }
  throw std::logic_error("no method '" + name + "'");
}

bool MethodComparison::has_expectation_of(const Method& method) {
  const Scene& scene = scene_.scene_of(method);
  const std::string& text = scene_.text();
  const bool is_light_tracing = method.name.starts_with("ptracer");
  const bool is_product = method.name.starts_with("product");
  const bool has_bounce = method.name.ends_with("one bounce");
  const bool is_blunt = is_light_tracing || method.against == "emitter sampling";
  const bool has_mirror = has_mirrors(scene), is_sharp = has_sharp_lobes(text, kMinAlpha);
  if (is_blunt && (has_mirror || has_sharp_lobes(text, kMinBluntAlpha))) return false;
  // With hide_emitters (see integrator_of()), only `ptracer` shows light that reflects off emitting
  // surfaces.
  if (is_light_tracing && scene.environment() && scene.has_surface_emitters()) return false;
  if (is_light_tracing && (has_specks(scene) || has_needles(text))) return false;
  // Clusters are chosen by the lobe at one of their points, so that a sharp lobe at other points
  // finds light only by chance. The same holds for light points on glossy surfaces, because
  // clusters are chosen without regard to these lobes.
  if (method.same_seeds && (is_sharp || (has_bounce && has_sharp_lobes(text, kMinBluntAlpha))))
    return false;
  // `product` includes light of lamps by way of mirrors and near-mirrors; `path` never or hardly
  // ever does.
  if (is_product && has_bounce && (has_mirror || is_sharp)) return false;
  if (is_product && !has_bounce) {
    // Like `joint`, it has the expectation of the light points if an environment is one of
    // several emitters.
    return scene.emitters().size() <= 1 || !scene.environment();
  }
  return true;
}

int MethodComparison::renders_of_repetition(size_t i, const Method& method, bool is_costly) {
  const CheckTask& task = scene_.task();
  if (i + 1 < kRepetitions) return task.repeated[i];
  const int before = task.repeated.back();
  const double samples = is_costly ? kMaxSamplesOfCostly : kMaxSamples;
  return static_cast<int>(
      std::clamp<double>(samples / scene_.samples_of(method), kMinFactor * before,
                         (is_costly ? kMaxFactorOfCostly : kMaxFactor) * before));
}

std::optional<MethodComparison::Comparison> MethodComparison::comparison(
    const Method& method, const Method& other, std::optional<size_t> repetition) {
  Renders own, others;
  if (repetition) {
    const bool is_costly = !is_cheap(method) || !is_cheap(other);
    const int count = renders_of_repetition(*repetition, method, is_costly);
    const uint64_t seed = 200'001 + 400'000 * uint64_t{*repetition};
    own = render_often(scene_.scene_of(method), count, seed);
    others = render_often(scene_.scene_of(other), count, method.same_seeds ? seed : seed + 100'000);
  } else {
    own = scene_.renders_of(method);
    others = scene_.renders_of(other);
  }
  const bool is_own_finite = scene_.is_finite(method, own);
  if (!scene_.is_finite(other, others) || !is_own_finite) return {};
  auto own_tiles = estimate_tiles_of(own, kTiles), other_tiles = estimate_tiles_of(others, kTiles);
  Comparison result;
  result.largest = std::max(own.tails().largest, others.tails().largest);
  result.missing = missing_light(own_tiles, other_tiles);
  result.lost = missing_light(other_tiles, own_tiles);
  result.has_constant_side = is_constant(own_tiles) || is_constant(other_tiles);
  if (method.same_seeds) {
    const auto difference = estimate_tile_differences(own, others, kTiles);
    std::vector<double> scale;
    for (const TileEstimate& tile : other_tiles) scale.push_back(std::abs(tile.estimate.mean));
    result.agreement = compare(difference, exact_zeros(difference.size()), scale);
    return result;
  }
  if (repetition && *repetition + 1 == kRepetitions) {
    judge_constants(method, other, own, others, own_tiles, other_tiles, result);
  }
  result.agreement = compare(own_tiles, other_tiles);
  return result;
}

void MethodComparison::judge_constants(const Method& method, const Method& other,
                                       const Renders& own, const Renders& others,
                                       std::vector<TileEstimate>& own_tiles,
                                       std::vector<TileEstimate>& other_tiles,
                                       Comparison& result) {
  // If a thousand renders are identical, that isn't chance but the method's result: a method that
  // loses all samples is black.
  const bool is_light_tracing = method.name.starts_with("ptracer");
  // A hundred photons give a rough estimate of the variance; an image without light needs more.
  const double few = is_constant(own_tiles) ? 3000 : 100;
  result.is_chance =
      is_light_tracing && sees_few_photons(scene_.scene_of(method), number_of_pixels(own), few);
  // Splats also show the tails of a filter, which camera rays hardly ever reach.
  const bool may_be_missed =
      has_faint_lobes(scene_.text()) ||
      (is_light_tracing && (scene_.text().find("\"box\"") == std::string::npos ||
                            is_hardly_seen(scene_.scene_of(other), number_of_pixels(others))));
  if (is_constant(own_tiles)) make_exact(own_tiles);
  if (is_constant(other_tiles)) {
    result.is_chance |= may_be_missed;
    make_exact(other_tiles);
  }
}

std::optional<std::vector<TileEstimate>> MethodComparison::long_tiles_of(const Method& method,
                                                                         uint64_t seed) {
  const int count = renders_of_repetition(kRepetitions - 1, method, !is_cheap(method));
  const Renders renders = render_often(scene_.scene_of(method), count, seed);
  if (!scene_.is_finite(method, renders)) return {};
  auto tiles = estimate_tiles_of(renders, kTiles);
  if (is_constant(tiles)) make_exact(tiles);
  return tiles;
}

std::string MethodComparison::reason_for_missing_light(const Method& standard, const Method& method,
                                                       double missing_before) {
  if (standard.name != "path, one bounce") return "";
  const auto tiles = long_tiles_of(method, 3'500'001);
  if (!long_standard_) long_standard_ = long_tiles_of(standard, 2'000'001);
  if (!tiles || !long_standard_) return "";
  if (missing_light(*long_standard_, *tiles) > 0) return "";  // light that only paths find
  const double missing = missing_light(*tiles, *long_standard_);
  if (!(missing > 0)) return "";  // the difference is in the sum of all tiles
  if (compare(*tiles, *long_standard_).p >= kCertain && missing < 0.5 * missing_before) {
    return "longer paths find it";
  }
  // Samples of each pixel, because tiles sum the radiances of pixels.
  const Scene& scene = scene_.scene_of(standard);
  const double samples = renders_of_repetition(kRepetitions - 1, standard, false) *
                         static_cast<double>(scene.sensors().at(0)->sampler().sample_count());
  const double hits = samples * missing / brightest_reflection(scene);
  return hits < kMinHits ? fmt::format("paths would find it {:.2g} times", hits) : "";
}

std::string MethodComparison::reason_for_lost_light(const Method& method,
                                                    const Comparison& comparison) {
  if (method.name != "product") return "";
  if (!(comparison.lost > 0) || comparison.missing > 0) return "";
  const double hidden = brightest_hidden(scene_.scene_of(method));
  if (!(hidden > 0)) return "";
  const double rays = kRaysPerPixel * renders_of_repetition(kRepetitions - 1, method, true);
  const double hits = rays * comparison.lost / hidden;
  return hits < kMinHiddenHits ? fmt::format("beside hidden light it is met {:.2g} times", hits)
                               : "";
}

void MethodComparison::leave_open(const Method& method, const Method& other,
                                  const std::string& excuse) {
  ++scene_.report().open;
  scene_.report().excuses.push_back(
      fmt::format("{} and {}: {}", method.name, other.name, excuse));
}

std::optional<MethodComparison::Comparison> MethodComparison::repeat(const Method& method,
                                                                     const Method& other) {
  std::optional<Comparison> longer;
  std::string confirmed;  // the result of a thousand renders
  for (size_t i = 0; i < kRepetitions; ++i) {
    longer = comparison(method, other, i);
    if (!longer) return {};
    const bool is_last = i + 1 == kRepetitions;
    const bool differs = longer->agreement.p < kCertain;
    if (!confirmed.empty() && (!differs || longer->is_open())) {
      const char* const why = !differs            ? "more renders don't confirm it"
                              : longer->is_chance ? "one method hardly ever finds it"
                                                  : "few samples decide the longer run";
      leave_open(method, other, fmt::format("{}: {}: {}", confirmed, why, longer->agreement.text));
      return {};
    }
    if (!differs) return {};
    if (!longer->is_open()) {
      if (i + 2 == kRepetitions) confirmed = longer->agreement.text;
      continue;
    }
    // Light that a hundred renders miss may be found by a thousand. If one method finds none, a
    // thousand renders show whether it ever does. If both find some, and a few samples decide, more
    // renders hardly help: they may find only the dim part, with a plausible variance, and still
    // miss the bright part. That took much time and gave two false alarms in 150 scenes: a lamp too
    // thin for rays from the sensor, and a lobe that samples of a lamp as large as the sky hardly
    // ever meet.
    if (is_last || !longer->has_constant_side) {
      ++scene_.report().open;
      return {};
    }
  }
  return longer;
}

void MethodComparison::compare_with_other(const Method& method) {
  if (method.against.empty() || !has_expectation_of(method)) return;
  const Method& other = method_named(method.against);
  if (scene_.is_excluded(other)) return;
  if (scene_.was_not_finite(method) || scene_.was_not_finite(other)) return;
  const auto first = comparison(method, other, std::nullopt);
  if (!first) return;
  ++scene_.report().comparisons;
  if (first->agreement.p >= kSuspicious) return;
  const std::optional<Comparison> longer = repeat(method, other);
  if (!longer) return;
  const std::string excuse = longer->agreement.has_more
                                 ? reason_for_missing_light(other, method, longer->missing)
                                 : reason_for_lost_light(method, *longer);
  if (!excuse.empty()) {
    return leave_open(method, other, longer->agreement.text + ": " + excuse);
  }
  scene_.report().findings.push_back(
      {"differs", method.name,
       fmt::format("from {}: z = {:.1f}, {}; largest contribution {:.2g} of the sum", other.name,
                   longer->agreement.worst_z, longer->agreement.text, longer->largest)});
}

}  // namespace kinome::test
