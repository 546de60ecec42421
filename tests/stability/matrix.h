#pragma once

#include <functional>
#include <string>
#include <vector>

#include "floor.h"
#include "measure.h"
#include "support/render.h"

/// What is rendered by what for tests/STABILITY.md: cases of hard numbers, each with some scenes
/// ("trials"), by every integrator and importance, with every material.
namespace kinome::test {

/// One column.
struct Method {
  const char* name;
  std::string integrator;  ///< XML
  /// `groundtruth` of the same light points, where the method has their light as its expectation;
  /// empty: its expectation is the scene's own light.
  std::string truth;
  int max_depth = 2;  ///< 3: with a bounce
};
const std::vector<Method>& methods();

struct Material {
  std::string name;
  std::string xml;
  bool is_sharp = false;  ///< a lobe so narrow that light paths don't meet the camera by it
};
/// diffuse, phong, ward, roughconductor, roughplastic: ordinary ones.
const std::vector<Material>& ordinary_materials();

/// The light that all methods but those of point lights are to have as their expectation.
struct Expectation {
  enum class Kind {
    kBlack,     ///< 0 everywhere, exactly
    kIntegral,  ///< of quadrature: `integral`
    kRendered,  ///< by another integrator or of another scene, which are independent estimates
    kFinite,    ///< none: whether values are finite is all that is asked
    kError,     ///< the scene is refused, in the words of `error`
  };
  Kind kind = Kind::kRendered;
  std::function<std::vector<Estimate>(const std::string& bsdf)> integral;
  std::string integrator;                                     ///< XML, of kRendered
  std::function<std::string(const std::string& bsdf)> scene;  ///< of kRendered, where it differs
  std::vector<std::string> error;                             ///< words that the message must have
};

struct Trial {
  std::string name;
  /// Sensor, shapes, lights; no integrator.
  std::function<std::string(const std::string& bsdf)> scene;
  Expectation expectation;
  std::vector<Material> materials = ordinary_materials();
  bool has_environment = false;
  bool has_lamps = false;
  /// Edges of a path for the first three methods; with 3, `direct` has no part in it.
  int max_depth = 2;
  /// Of values, as a standard deviation relative to them, by directions in single precision.
  double rounding = kRounding;
  /// Methods that have no part in it, by name or name/material, with the reason; "*": all.
  std::vector<std::pair<std::string, std::string>> without;
  /// Methods, named as in `without`, whose pictures may say nothing: hardly any of their renders
  /// find the light in question. Of all others, Verdict::kUndecided is a failure.
  std::vector<std::string> rarely_lit;
  int renders = 48;
  bool is_long = false;  ///< only where there is time
};

struct Case {
  int number;
  const char* title;   ///< what goes wrong elsewhere
  const char* answer;  ///< what Kinome does
  const char* tests;   ///< others that hold it: paths from tests/, separated by blanks
  std::vector<Trial> trials;
};
/// The trial of that name; throws std::out_of_range.
Trial& trial_named(Case& of, const std::string& name);
/// Files that scenes need are written to `folder`.
std::vector<Case> light_cases(const std::string& folder);
std::vector<Case> surface_cases(const std::string& folder);
std::vector<Case> lamp_cases(const std::string& folder);

/// One comparison.
struct Cell {
  enum class Verdict { kAgrees, kDiffers, kUndecided, kFinite, kRefused, kNotMeant };
  Verdict verdict = Verdict::kNotMeant;
  double worst_z = 0;
  double p = 1;
  uint64_t non_finite = 0;
  double kurtosis = 0, largest = 0;
  std::string text;  ///< what went wrong, or why it isn't meant
};

/// Where it fails at first it is done again, longer and with other numbers: see matrix.cpp.
Cell run_cell(const Trial& trial, const Method& method, const Material& material);

struct Row {
  const Case* of = nullptr;
  const Trial* trial = nullptr;
  std::vector<std::vector<Cell>> cells;  ///< [method][material]
};
/// The page that the rows make.
std::string stability_page(const std::vector<Case>& cases, const std::vector<Row>& rows);
bool passed(const Cell& cell);

}  // namespace kinome::test
