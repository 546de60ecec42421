#include "matrix.h"

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>

#include "kinome/error.h"
#include "measure.h"
#include "xml.h"

namespace kinome::test {
namespace {

// A comparison below kSuspicious is repeated with kRepetitionFactor times as many renders of other
// seeds, and fails if it is below it again. For normally distributed estimates, that is one false
// alarm in 1/kSuspicious² comparisons: with about 3000 of them, one in 30 million runs.
constexpr double kSuspicious = 1e-5;
constexpr int kRepetitionFactor = 4;
/// Maximum fraction of a sum that a single sample may contribute. Beyond it, the tails are not
/// sampled yet, and the comparison is undecided.
constexpr double kMaxContribution = 0.3;
constexpr int kTiles = 3;

const std::string& truth_at(int max_depth) {
  static const std::map<int, std::string> all = [] {
    std::map<int, std::string> truths;
    for (const int depth : {2, 3}) {
      truths[depth] = xml::integrator(
          "groundtruth", xml::integer("light_samples", 200) + xml::integer("max_depth", depth));
    }
    return truths;
  }();
  return all.at(max_depth);
}

Method clustered(const char* name, const std::string& importance, int max_depth) {
  return {
      name,
      xml::integrator("clustered",
                      xml::text("importance", importance) + xml::integer("light_samples", 200) +
                          xml::integer("cut_size", 30) + xml::integer("emitter_samples", 8) +
                          xml::integer("brdf_samples", 8) + xml::integer("max_depth", max_depth)),
      truth_at(max_depth), max_depth};
}

std::string with_depth(const std::string& type, int max_depth) {
  const std::string depth = xml::integer("max_depth", max_depth);
  if (type != "product") return xml::integrator(type, depth);
  return xml::integrator("clustered", xml::text("importance", type) + xml::integer("cut_size", 30) +
                                          xml::number("rays_per_pixel", 12) +
                                          xml::boolean("trial", false) + depth);
}

/// Emitters are hidden, because `ptracer` doesn't show environments, and because its paths find
/// lamps that are too small for camera rays.
std::unique_ptr<Scene> make_scene(const std::string& contents, std::string integrator) {
  integrator.insert(integrator.rfind("</"), xml::boolean("hide_emitters", true));
  LoadOptions options;
  options.threads = 1;
  return load_scene_from_string(xml::scene(integrator + contents), "scene.xml", options,
                                registry());
}

/// The two sides of a comparison and of its repetition use disjoint seeds.
constexpr uint64_t kSeeds[2][2] = {{1, 1'000'001}, {2'000'001, 3'000'001}};

/// Expectation that doesn't depend on the method, computed once for all methods.
struct Expected {
  std::vector<TileEstimate> tiles;
  double largest = 0;
  uint64_t non_finite = 0;
};

/// Returns the expectation of the scene's light.
Expected expected_light(const Trial& trial, const Method& method, const Material& material,
                        int round) {
  const Expectation& e = trial.expectation;
  // With a bounce, paths from the camera and paths from the light are each other's reference. The
  // reference of `product` is paths from the camera: they find the little light that is seen from
  // nearby.
  const int depth = std::max(trial.max_depth, method.max_depth);
  const bool is_by_camera = method.name != std::string("path");
  const std::string integrator =
      depth == 2 ? e.integrator : with_depth(is_by_camera ? "path" : "ptracer", depth);
  static std::map<std::string, Expected> known;
  const std::string key =
      trial.name + "/" + material.name + "/" + std::to_string(round) + "/" + integrator;
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  Expected expected;
  if (e.kind == Expectation::Kind::kIntegral && depth == 2) {
    const std::vector<Estimate> pixels = e.integral(material.xml);
    const int side = static_cast<int>(std::lround(std::sqrt(pixels.size() / 3.)));
    expected.tiles = exact_tiles(pixels, side, side, kTiles);
  } else {
    const auto scene = make_scene((e.scene ? e.scene : trial.scene)(material.xml), integrator);
    const Renders renders =
        render_often(*scene, 2 * trial.renders * (round ? kRepetitionFactor : 1), kSeeds[round][1]);
    expected.tiles = estimate_tiles_of(renders, kTiles);
    expected.largest = renders.tails().largest;
    expected.non_finite = renders.non_finite;
  }
  return known[key] = expected;
}

/// True if the method's expectation is the scene's own light, which is false only for light points.
bool has_own_light(const Trial& trial, const Method& method) {
  if (method.truth.empty()) return true;
  return method.max_depth == trial.max_depth && method.max_depth == 2 && !trial.has_environment;
}

/// Number of renders of a round: 0, or 1 for the repetition with more renders.
int renders_of_round(const Trial& trial, int round) {
  return trial.renders * (round ? kRepetitionFactor : 1);
}

/// Checks that all values are 0.
void check_blackness(const Renders& renders, Cell& cell) {
  cell.verdict = Cell::Verdict::kAgrees;
  for (const auto& pixels : renders.pixels) {
    for (const float value : pixels) {
      if (value == 0) continue;
      cell.verdict = Cell::Verdict::kDiffers;
      cell.text = "a value of " + xml::digits(value) + " where the image must be black";
    }
  }
}

/// Compares renders of the method with those of `groundtruth`. Renders of one seed have the same
/// light points and pixel positions. Returns nullopt if some values aren't finite.
std::optional<Agreement> compare_with_truth(const Trial& trial, const Method& method,
                                            const Material& material, int round,
                                            const Renders& own) {
  const auto scene = make_scene(trial.scene(material.xml), method.truth);
  const Renders truth = render_often(*scene, renders_of_round(trial, round), kSeeds[round][0]);
  if (truth.non_finite > 0) return {};
  const auto difference = estimate_tile_differences(own, truth, kTiles);
  std::vector<double> scale;
  for (const TileEstimate& tile : estimate_tiles_of(truth, kTiles)) {
    scale.push_back(std::abs(tile.estimate.mean));
  }
  return compare(difference, exact_zeros(difference.size()), scale);
}

Cell measure(const Trial& trial, const Method& method, const Material& material, int round) {
  const std::string& integrator = method.truth.empty() && trial.max_depth > method.max_depth
                                      ? with_depth(method.name, trial.max_depth)
                                      : method.integrator;
  Cell cell;
  const auto scene = make_scene(trial.scene(material.xml), integrator);
  const Renders own = render_often(*scene, renders_of_round(trial, round), kSeeds[round][0]);
  const Tails tails = own.tails();
  cell.non_finite = own.non_finite;
  cell.kurtosis = tails.kurtosis;
  cell.largest = tails.largest;
  if (cell.non_finite > 0) {
    cell.verdict = Cell::Verdict::kDiffers;
    cell.text = std::to_string(cell.non_finite) + " values that aren't finite";
    return cell;
  }
  if (trial.expectation.kind == Expectation::Kind::kFinite) {
    cell.verdict = Cell::Verdict::kFinite;
    return cell;
  }
  if (trial.expectation.kind == Expectation::Kind::kBlack) {
    check_blackness(own, cell);
    return cell;
  }
  Agreement agreement;
  double largest = cell.largest;
  if (has_own_light(trial, method)) {
    const Expected expected = expected_light(trial, method, material, round);
    if (expected.non_finite > 0) {
      cell.verdict = Cell::Verdict::kDiffers;
      cell.text = "its reference has values that aren't finite";
      return cell;
    }
    agreement = compare(estimate_tiles_of(own, kTiles), expected.tiles, {}, trial.rounding);
    largest = std::max(largest, expected.largest);
  } else {
    const auto compared = compare_with_truth(trial, method, material, round, own);
    if (!compared) {
      cell.verdict = Cell::Verdict::kDiffers;
      cell.text = "groundtruth has values that aren't finite";
      return cell;
    }
    agreement = *compared;
  }
  cell.worst_z = agreement.worst_z;
  cell.p = agreement.p;
  cell.text = agreement.text;
  cell.verdict = agreement.p >= kSuspicious                        ? Cell::Verdict::kAgrees
                 : agreement.is_open || largest > kMaxContribution ? Cell::Verdict::kUndecided
                                                                   : Cell::Verdict::kDiffers;
  return cell;
}

/// Returns true if `name`, as in Trial::without, names this cell.
bool names_cell(const std::string& name, const Method& method, const Material& material) {
  return name == "*" || name == method.name || name == method.name + ("/" + material.name);
}

/// Tests that the scene is refused with the expected error.
Cell expect_error(const Trial& trial, const Method& method, const Material& material) {
  Cell cell;
  cell.verdict = Cell::Verdict::kDiffers;
  try {
    make_scene(trial.scene(material.xml), method.integrator);
    cell.text = "no error";
  } catch (const Error& error) {
    cell.text = error.what();
    cell.verdict = Cell::Verdict::kRefused;
    for (const std::string& word : trial.expectation.error) {
      if (cell.text.find(word) == std::string::npos) cell.verdict = Cell::Verdict::kDiffers;
    }
    if (cell.text.find('\n') != std::string::npos) cell.verdict = Cell::Verdict::kDiffers;
  }
  return cell;
}

}  // namespace

const std::vector<Method>& methods() {
  static const std::vector<Method> all = {
      {"direct", xml::integrator("direct"), ""},
      {"path", with_depth("path", 2), ""},
      {"ptracer", with_depth("ptracer", 2), ""},
      clustered("joint", "joint", 2),
      clustered("luminance", "luminance", 2),
      clustered("brdf", "brdf", 2),
      {"product", with_depth("product", 2), ""},
      clustered("joint, local", "joint", 3),
      clustered("luminance, local", "luminance", 3),
      clustered("brdf, local", "brdf", 3),
      {"product, local", with_depth("product", 3), "", 3},
  };
  return all;
}

const std::vector<Material>& ordinary_materials() {
  static const std::vector<Material> all = {
      {"diffuse", xml::bsdf("diffuse", xml::color("reflectance", {.2f, .5f, .8f}))},
      {"phong", xml::bsdf("phong", xml::number("exponent", 20) +
                                       xml::color("diffuse_reflectance", {.3f, .2f, .4f}) +
                                       xml::color("specular_reflectance", {.3f, .4f, .2f}))},
      {"ward", xml::bsdf("ward", xml::number("alpha_u", .15) + xml::number("alpha_v", .3) +
                                     xml::color("diffuse_reflectance", {.3f, .2f, .1f}) +
                                     xml::color("specular_reflectance", {.2f, .3f, .4f}))},
      {"roughconductor", xml::bsdf("roughconductor", xml::number("alpha", .25))},
      {"roughplastic",
       xml::bsdf("roughplastic",
                 xml::number("alpha", .2) + xml::color("diffuse_reflectance", {.5f, .3f, .1f}))},
  };
  return all;
}

Trial& trial_named(Case& of, const std::string& name) {
  for (Trial& trial : of.trials) {
    if (trial.name == name) return trial;
  }
  throw std::out_of_range(name);
}

Cell run_cell(const Trial& trial, const Method& method, const Material& material) {
  Cell cell;
  for (const auto& [name, reason] : trial.without) {
    if (!names_cell(name, method, material)) continue;
    const bool is_of_material = name == method.name + ("/" + material.name);
    cell.text = is_of_material ? material.name + ": " + reason : reason;
    return cell;
  }
  if (material.is_sharp && std::string(method.name) == "ptracer") {
    cell.text = "lobes so narrow that hardly any light paths reach the camera: " + material.name;
    return cell;
  }
  if (trial.max_depth == 3 && std::string(method.name) == "direct") {
    cell.text = "renders no bounces";
    return cell;
  }
  if (trial.max_depth == 3 && std::string(method.name) == "product") {
    cell.text = "with a bounce: see `product, local`";
    return cell;
  }
  if (trial.expectation.kind == Expectation::Kind::kError) {
    return expect_error(trial, method, material);
  }
  try {
    cell = measure(trial, method, material, 0);
    const bool is_rarely_lit =
        std::any_of(trial.rarely_lit.begin(), trial.rarely_lit.end(), [&](const std::string& name) {
          return names_cell(name, method, material);
        });
    const bool is_suspicious = cell.verdict == Cell::Verdict::kDiffers ||
                               (cell.verdict == Cell::Verdict::kUndecided && !is_rarely_lit);
    if (is_suspicious && cell.non_finite == 0 &&
        trial.expectation.kind != Expectation::Kind::kBlack) {
      cell = measure(trial, method, material, 1);
    }
    if (cell.verdict == Cell::Verdict::kUndecided && !is_rarely_lit) {
      // A black image would never be noticed if this were accepted as chance.
      cell.verdict = Cell::Verdict::kDiffers;
      cell.text = "undecided: " + cell.text;
    }
  } catch (const std::exception& error) {
    cell.verdict = Cell::Verdict::kDiffers;
    cell.text = error.what();
  }
  return cell;
}

bool passed(const Cell& cell) {
  return cell.verdict != Cell::Verdict::kDiffers;
}

}  // namespace kinome::test
