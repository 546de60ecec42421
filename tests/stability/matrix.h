#pragma once

#include <functional>
#include <string>
#include <vector>

#include "floor.h"
#include "measure.h"
#include "support/render.h"

/// The scenes and methods of tests/STABILITY.md: cases of difficult numbers, each with several
/// scenes ("trials"), with every integrator and importance, and with every material.
namespace kinome::test {

/// A column of the matrix.
struct Method {
  const char* name;
  std::string integrator;  ///< XML
  /// `groundtruth` with the same light points, if these determine the method's expectation. Empty
  /// if its expectation is the scene's own light.
  std::string truth;
  int max_depth = 2;  ///< 3: with a bounce
};
const std::vector<Method>& methods();

struct Material {
  std::string name;
  std::string xml;
  bool is_sharp = false;  ///< a lobe so narrow that light paths don't reach the camera by it
};
/// Materials without extreme parameters: diffuse, phong, ward, roughconductor, roughplastic.
const std::vector<Material>& ordinary_materials();

/// Expectation of the methods, except for those with light points.
struct Expectation {
  enum class Kind {
    kBlack,     ///< exactly 0 everywhere
    kIntegral,  ///< computed by quadrature: `integral`
    kRendered,  ///< an independent estimate by another integrator or of another scene
    kFinite,    ///< unknown; only finite values are required
    kError,     ///< the scene must be refused, with the words of `error`
  };
  Kind kind = Kind::kRendered;
  std::function<std::vector<Estimate>(const std::string& bsdf)> integral;
  std::string integrator;                                     ///< XML, for kRendered
  std::function<std::string(const std::string& bsdf)> scene;  ///< for kRendered, if it differs
  std::vector<std::string> error;                             ///< words of the message
};

struct Trial {
  std::string name;
  /// Sensor, shapes, emitters; no integrator.
  std::function<std::string(const std::string& bsdf)> scene;
  Expectation expectation;
  std::vector<Material> materials = ordinary_materials();
  bool has_environment = false;
  bool has_lamps = false;
  /// Edges of a path for the first three methods; with 3, `direct` is skipped.
  int max_depth = 2;
  /// Relative standard deviation of values because of directions in single precision.
  double rounding = kRounding;
  /// Skipped methods by name or name/material, with the reason; "*": all.
  std::vector<std::pair<std::string, std::string>> without;
  /// Methods, named as in `without`, that may be undecided, because hardly any of their renders
  /// find the light in question. For all others, Verdict::kUndecided is a failure.
  std::vector<std::string> rarely_lit;
  int renders = 48;
  bool is_long = false;  ///< skipped by --short
};

struct Case {
  int number;
  const char* title;   ///< typical error of renderers
  const char* answer;  ///< behaviour of Kinome
  const char* tests;   ///< related tests: paths from tests/, separated by blanks
  std::vector<Trial> trials;
};
/// Returns the trial with that name; throws std::out_of_range.
Trial& trial_named(Case& of, const std::string& name);
/// Files that scenes need are written to `folder`.
std::vector<Case> light_cases(const std::string& folder);
std::vector<Case> surface_cases(const std::string& folder);
std::vector<Case> lamp_cases(const std::string& folder);

/// Result of one comparison.
struct Cell {
  enum class Verdict { kAgrees, kDiffers, kUndecided, kFinite, kRefused, kNotApplicable };
  Verdict verdict = Verdict::kNotApplicable;
  double worst_z = 0;
  double p = 1;
  uint64_t non_finite = 0;
  double kurtosis = 0, largest = 0;
  std::string text;  ///< the difference, or the reason for skipping it
};

/// Runs the comparison. If it fails, repeats it with more renders and other seeds, see matrix.cpp.
Cell run_cell(const Trial& trial, const Method& method, const Material& material);

struct Row {
  const Case* of = nullptr;
  const Trial* trial = nullptr;
  std::vector<std::vector<Cell>> cells;  ///< [method][material]
};
/// Returns the page for these rows.
std::string stability_page(const std::vector<Case>& cases, const std::vector<Row>& rows);
bool passed(const Cell& cell);

}  // namespace kinome::test
