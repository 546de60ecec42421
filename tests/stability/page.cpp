// Writes STABILITY.md: the results of each method for each case.

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "matrix.h"

namespace kinome::test {
namespace {

using Answer = Cell::Verdict;

/// Summary of all cells of a method in a case.
struct Summary {
  int agree = 0, differ = 0, undecided = 0, finite = 0, refused = 0;
  double worst_z = 0;

  void add(const Cell& cell) {
    agree += cell.verdict == Answer::kAgrees;
    differ += cell.verdict == Answer::kDiffers;
    undecided += cell.verdict == Answer::kUndecided;
    finite += cell.verdict == Answer::kFinite;
    refused += cell.verdict == Answer::kRefused;
    if (cell.verdict == Answer::kAgrees) worst_z = std::max(worst_z, cell.worst_z);
  }
  std::string text() const {
    std::string s;
    if (agree > 0) s = worst_z > 0 ? fmt::format("{:.1f}", worst_z) : "exact";
    if (finite > 0) s += s.empty() ? "finite" : ", finite";
    if (refused > 0) s += s.empty() ? "error" : ", error";
    if (undecided > 0) s += fmt::format(" ({} open)", undecided);
    if (differ > 0) s = fmt::format("**{} differ**", differ);
    return s.empty() ? "–" : s;
  }
};

/// Maximum of a value over images, and where it occurs.
struct Worst {
  double value = 0;
  std::string where;
  void offer(double v, const std::string& at) {
    if (v > value) {
      value = v;
      where = at;
    }
  }
};

std::string links_to(const char* tests) {
  std::istringstream words(tests);
  std::string word, links;
  while (words >> word) {
    links += fmt::format("{}[{}]({})", links.empty() ? "" : ", ", word, word);
  }
  return links;
}

void add_matrix(std::string& page, const std::vector<Case>& cases, const std::vector<Row>& rows) {
  page += "|   | case |";
  std::string line = "|---|---|";
  for (const Method& method : methods()) {
    page += fmt::format(" {} |", method.name);
    line += "---|";
  }
  page += "\n" + line + "\n";
  for (const Case& c : cases) {
    page += fmt::format("| [{0}](#case-{0}) | {1} |", c.number, c.title);
    for (size_t m = 0; m < methods().size(); ++m) {
      Summary summary;
      for (const Row& row : rows) {
        if (row.of->number != c.number) continue;
        for (const Cell& cell : row.cells[m]) summary.add(cell);
      }
      page += " " + summary.text() + " |";
    }
    page += "\n";
  }
  page += "\n";
}

void add_trial(std::string& page, const Row& row) {
  Worst z, kurtosis, largest;
  uint64_t non_finite = 0;
  int cells = 0;
  for (size_t m = 0; m < methods().size(); ++m) {
    for (size_t k = 0; k < row.cells[m].size(); ++k) {
      const Cell& cell = row.cells[m][k];
      if (cell.verdict == Answer::kNotApplicable) continue;
      ++cells;
      const std::string where =
          fmt::format("{}, {}", methods()[m].name, row.trial->materials[k].name);
      if (cell.verdict == Answer::kAgrees) z.offer(cell.worst_z, where);
      kurtosis.offer(cell.kurtosis, where);
      largest.offer(cell.largest, where);
      non_finite += cell.non_finite;
    }
  }
  const auto shown = [](const Worst& worst, const std::string& value) {
    return worst.value > 0 ? fmt::format("{} ({})", value, worst.where) : std::string("–");
  };
  page += fmt::format("| {} | {} | {} | {} | {} | {} |\n", row.trial->name, cells,
                      shown(z, fmt::format("{:.2f}", z.value)), non_finite,
                      shown(kurtosis, fmt::format("{:.3g}", kurtosis.value)),
                      shown(largest, fmt::format("{:.2g} %", 100 * largest.value)));
}

/// Lists cells with this verdict; cells with the same text are combined.
void add_list(std::string& page, const std::vector<Row>& rows, Answer verdict) {
  for (const Row& row : rows) {
    for (size_t m = 0; m < methods().size(); ++m) {
      std::set<std::string> listed;
      for (size_t k = 0; k < row.cells[m].size(); ++k) {
        const Cell& cell = row.cells[m][k];
        if (cell.verdict != verdict || !listed.insert(cell.text).second) continue;
        page +=
            fmt::format("- case {}, {}, `{}`", row.of->number, row.trial->name, methods()[m].name);
        if (verdict != Answer::kNotApplicable) page += ", " + row.trial->materials[k].name;
        page += ": " + cell.text;
        page += "\n";
      }
    }
  }
}

bool has(const std::vector<Row>& rows, Answer verdict) {
  for (const Row& row : rows) {
    for (const auto& cells : row.cells) {
      for (const Cell& cell : cells) {
        if (cell.verdict == verdict) return true;
      }
    }
  }
  return false;
}

constexpr const char* kHead = R"(# Numerical stability

This page lists cases that are known to break renderers of this kind, and Kinome's results for them.
This command writes it:

```sh
sh tests/run.sh --stability
```

Every case has several scenes. Every scene is rendered by every integrator and importance, with
`diffuse`, `phong`, `ward`, `roughconductor` and `roughplastic`, or with the materials that the case
tests.

A number in the table is the largest |z| of these images compared with their expectation, over 9 tiles
and their sum, with three channels each. The expectation depends on the method:

- `direct`, `path`, `ptracer` and `product` (and all others if there are only lamps) are compared
  with quadrature in double precision. It is independent of the renderer and follows the scene's
  documentation. Other scenes are compared with another estimate of the same light: BSDF samples
  alone, emitter samples alone, paths from the light or from the camera, or the same scene in another
  position.
- `joint`, `luminance` and `brdf` estimate the light of a set of points. They are compared with
  `groundtruth` for the same points, seed by seed.
- `local` means one bounce (`max_depth` 3). `product` is then compared with paths of the same depth.

A comparison whose p-value is below 1e-5 is repeated with other seeds and four times as many renders.
The images differ if the p-value is below 1e-5 again, which happens by chance once in 30 million runs.

`exact` means that all bits are equal, or all images are black; `finite`, that only finite values are
required; `error`, that the scene is refused, with a message that is tested; `–`, that the method isn't
applicable (see the end).

Values that aren't finite (NaN or infinite) are counted before they are dropped, where a sample
reaches the film. A single one fails the run. (A `point` or `spot` gives no light to a surface at a
distance of 0, where the light would be infinite.)

)";

constexpr const char* kRelatedTests = R"(## Related tests

- [invariance_test.cpp](stability/invariance_test.cpp) changes units, position, orientation and
  handedness of the world, the order of its triangles, the number of its meshes, the brightness of
  its light, and the number of its lamps.
- [precision_test.cpp](stability/precision_test.cpp) compares distributions and trees of four million
  lights of 1e-30 to 1e30 with exact sums, and tests that no index of zero probability is drawn. It
  compares warps and BSDFs with double precision, in ulps.
- [product_kernels_test.cpp](plugins/integrators/kernels/product_kernels_test.cpp),
  [lobe_kernels_test.cpp](plugins/integrators/kernels/lobe_kernels_test.cpp) and
  [local_parts_test.cpp](plugins/integrators/kernels/local_parts_test.cpp) compare the kernels of every instruction set with
  scalar code.
- [product_learning_test.cpp](render/product/product_learning_test.cpp) runs `product` with falsified
  visibilities: all 1, all 0, the opposite of the learned ones, shuffled, or another surface's. It
  also tests that a bias is detected if visibilities are learned from the same rays that they weight.
- [product_test.cpp](render/product/product_test.cpp) and
  [product_near_mirrors_test.cpp](render/product/product_near_mirrors_test.cpp) render without a pilot, and with pilots of
  a ray or two.
- `EyeRaysBoundTheWeightOfNearPoints` of [local_parts_test.cpp](plugins/integrators/kernels/local_parts_test.cpp) tests the
  maximum weight of single samples. The 1 / d² of light points has no bound of its own; the fraction of
  eye rays bounds their weights.

)";

constexpr const char* kTails =
    R"(Tails are measured for single contributions (one sample per pixel). `kurtosis` is that of their
deviations from pixel means (3 for a normal distribution). The largest contribution is given as a fraction
of the sum of all. Nothing is clamped.

)";

constexpr const char* kLimits = R"(
## Limits

- Light whose products exceed single precision. Radiance is at most 1e36. A scene that is both 1e6
  times as large and 1e30 times as bright overflows where areas are multiplied by radiance.
- Scenes of less than 1e-9 units or more than 1e11. There, the ray tracer begins to lose surfaces
  silently because of its single precision. Shapes are refused only beyond 1e18.
- Light fainter than 1e-35. Its products are below the smallest numbers of single precision.
- A scene that is translated by 1e5 has the same image only as far as single precision represents
  its vertices: one part in 10^7 of 1e5, a hundredth. The scene of this test is a hundred units wide.
- Light closer to a surface than the offset of rays from it, which is two to five millionths of the
  distance from the origin. The same holds for surfaces that are this close to a lamp.
- `ptracer` with light from infinitely far over a floor of 1e6 and more: unbiased, but too noisy to
  be useful.
- Light of lamps without area that a nearly mirroring surface (alpha of a hundredth and less)
  reflects to others. All integrators except `ptracer` and `product` find it only in rare, very bright
  samples, because no BSDF ray hits such a lamp.
- `ptracer` emits no light from an environment that has negative texels but no positive one.
- Light points (`joint`, `luminance`, `brdf`) represent an environment with a resolution that
  `light_samples` determines. They are compared with their own points, not with the map.
- Two concurrent renders with the same `--checkpoint` file overwrite each other's checkpoints. Each file
  is complete, and `--resume` refuses a checkpoint of another scene or other options.
- In half floats (`component_format` of `float16`, the default as in Mitsuba) the largest value of an
  image is 65504. It replaces brighter light, and -65504 replaces large negative noise of `product`.
- Embree's robust mode loses some of the rays that are aimed exactly at a vertex
  (plugins/shapes/self_intersection_test.cpp).
)";

}  // namespace

std::string stability_page(const std::vector<Case>& cases, const std::vector<Row>& rows) {
  size_t cells = 0;
  uint64_t non_finite = 0;
  for (const Row& row : rows) {
    for (const auto& method : row.cells) {
      for (const Cell& cell : method) {
        cells += cell.verdict != Answer::kNotApplicable;
        non_finite += cell.non_finite;
      }
    }
  }
  std::string page = kHead;
  page += fmt::format("{} cases, {} scenes, {} images; {} values that weren't finite.\n\n",
                      cases.size(), rows.size(), cells, non_finite);
  add_matrix(page, cases, rows);
  page += kRelatedTests;
  page += "## Case by case\n\n";
  page += kTails;
  for (const Case& c : cases) {
    page += fmt::format("### Case {}\n\n{}. *{}* Tested by {}.\n\n", c.number, c.title, c.answer,
                        links_to(c.tests));
    page += "| scene | images | largest z | not finite | kurtosis | largest contribution |\n";
    page += "|---|---|---|---|---|---|\n";
    for (const Row& row : rows) {
      if (row.of->number == c.number) add_trial(page, row);
    }
    page += "\n";
  }
  if (has(rows, Answer::kDiffers)) {
    page += "## Differences\n\n";
    add_list(page, rows, Answer::kDiffers);
  }
  page += kLimits;
  if (has(rows, Answer::kUndecided)) {
    page +=
        "- Open: comparisons that are undecided, because hardly any of the renders on one side "
        "found the light in question, or because a single sample is more than 30 % of the sum. Each "
        "of these is listed in the code of its scene; any other is a failure:\n\n";
    add_list(page, rows, Answer::kUndecided);
  }
  page += "\nNot applicable:\n\n";
  add_list(page, rows, Answer::kNotApplicable);
  return page;
}

}  // namespace kinome::test
