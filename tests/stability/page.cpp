// Writes STABILITY.md: what each method made of each case.

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "matrix.h"

namespace kinome::test {
namespace {

using Answer = Cell::Verdict;

/// What the cells of one method say together.
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

/// In pictures that are compared by z, the worst of some number.
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
      if (cell.verdict == Answer::kNotMeant) continue;
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

/// Cells of one verdict, those with the same text together.
void add_list(std::string& page, const std::vector<Row>& rows, Answer verdict) {
  for (const Row& row : rows) {
    for (size_t m = 0; m < methods().size(); ++m) {
      std::set<std::string> said;
      for (size_t k = 0; k < row.cells[m].size(); ++k) {
        const Cell& cell = row.cells[m][k];
        if (cell.verdict != verdict || !said.insert(cell.text).second) continue;
        page +=
            fmt::format("- case {}, {}, `{}`", row.of->number, row.trial->name, methods()[m].name);
        if (verdict != Answer::kNotMeant) page += ", " + row.trial->materials[k].name;
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

What breaks renderers of this kind, and what it does to Kinome, as

```sh
sh tests/run.sh --stability
```

wrote it. Every case has some scenes; every scene is rendered by every integrator and importance,
with `diffuse`, `phong`, `ward`, `roughconductor` and `roughplastic`, or with the materials that the
case is about.

A number is the worst |z| of all these pictures against their expectation: 9 tiles, their sum, three
channels each. `direct`, `path`, `ptracer` and `product` (and all others where there are only lamps)
are held against quadrature in double precision of what the scene documents, written apart from the
renderer, or against another estimate of the same light: BSDF samples alone, emitter samples alone,
paths from the light against paths from the camera, the same scene elsewhere. `joint`, `luminance`
and `brdf` estimate the light of a set of points: they are held against `groundtruth` of the same
points, seed by seed; `local` means one bounce (`max_depth` 3; `product` is then held against paths
of the same depth). A comparison that is as
suspicious as 1e-5 is done again with other seeds and four times as long, and counts as different if
it is so again: once in 30 million runs by chance.

`exact`: not a bit differs, or all is black. `finite`: nothing more is known of the picture. `error`:
refused, in words that are tested. `–`: not meant for it, see the end.

Values that are no numbers (NaN or infinite) are counted before anything drops them, where a sample
comes to the film; a single one fails the run. (A `point` or `spot` at no distance from what it lights
gives it nothing: there the light is infinite.)

)";

constexpr const char* kBeside = R"(## Beside the matrix

- The world in other units, elsewhere, turned, mirrored; its triangles in another order, its meshes
  split and joined; its light multiplied, and its lamps divided:
  [invariance_test.cpp](stability/invariance_test.cpp).
- Distributions and trees of four million lights of 1e-30 to 1e30 against exact sums, no index of zero
  probability at any step, warps and BSDFs against double precision in units of the last place:
  [precision_test.cpp](stability/precision_test.cpp). Kernels of every instruction set against plain
  code: [product_kernels_test.cpp](unit/product_kernels_test.cpp),
  [lobe_kernels_test.cpp](unit/lobe_kernels_test.cpp),
  [local_parts_test.cpp](unit/local_parts_test.cpp).
- Pilots that lie: `product` with visibilities that are all 1, all 0, the opposite of what was learned,
  shuffled, another surface's; and learned from the rays that they weigh, which must be caught:
  [product_learning_test.cpp](render/product_learning_test.cpp). No pilot, and pilots of a ray or two:
  [product_test.cpp](render/product_test.cpp), [product_local_test.cpp](render/product_local_test.cpp).
- What single samples may weigh: light points have no bound by 1 / d²; what bounds them is the share of
  eye rays, `EyeRaysBoundWhatNearPointsWeigh` of [local_parts_test.cpp](unit/local_parts_test.cpp).

)";

constexpr const char* kTails =
    R"(Tails are of single contributions (one sample a pixel): `kurtosis` of
what pixels differ by from their means (3 for a normal distribution), and the largest contribution as
a share of the sum of all. Nothing is clamped.

)";

constexpr const char* kNotHeld = R"(
## What is not held

- Light whose products leave single precision: radiance is at most 1e36, and a scene that is at the
  same time 1e6 times as large and 1e30 times as bright overflows where areas are multiplied by it.
- Scenes of less than 1e-9 units or more than 1e11: the ray tracer's single precision begins to lose
  surfaces, without a word, long before 1e18, where shapes are refused.
- Light fainter than 1e-35: its products are lost below the least numbers of single precision.
- A scene moved 1e5 away is the same picture only as far as single precision holds its vertices: one
  part in 10^7 of 1e5, a hundredth. The trial's scene is a hundred units wide.
- Light nearer to a surface than rays start from it, two to five millionths of its distance from the
  origin, and what stands nearer than that to its lamp.
- `ptracer` with light from infinitely far over a floor of 1e6 and more: unbiased, and so noisy that
  nothing is learned from it.
- The light of lamps without extent that a nearly mirroring surface (alpha of a hundredth and less)
  sends on to others is in single, very bright samples by every integrator but `ptracer` and
  `product`: no ray by a BSDF meets such a lamp.
- `ptracer` sends nothing from an environment without any positive texel, whose light is negative.
- Points of light (`joint`, `luminance`, `brdf`) stand for an environment as finely as `light_samples`
  says. What they are compared with is their own points, not the map.
- Two renders at the same time with one `--checkpoint` file replace each other's; each is whole, and
  `--resume` refuses one of another scene or other options.
- In half floats (`component_format` of `float16`, as in Mitsuba the default) a picture ends at 65504:
  of brighter light that is what is written, and -65504 where `product` is negative by noise.
- Embree's robust mode loses some of the rays that are aimed at a vertex to the last bit
  (unit/self_intersection_test.cpp).
)";

}  // namespace

std::string stability_page(const std::vector<Case>& cases, const std::vector<Row>& rows) {
  size_t cells = 0;
  uint64_t non_finite = 0;
  for (const Row& row : rows) {
    for (const auto& method : row.cells) {
      for (const Cell& cell : method) {
        cells += cell.verdict != Answer::kNotMeant;
        non_finite += cell.non_finite;
      }
    }
  }
  std::string page = kHead;
  page += fmt::format("{} cases, {} scenes, {} pictures; {} values that were no numbers.\n\n",
                      cases.size(), rows.size(), cells, non_finite);
  add_matrix(page, cases, rows);
  page += kBeside;
  page += "## Case by case\n\n";
  page += kTails;
  for (const Case& c : cases) {
    page += fmt::format("### Case {}\n\n{}. *{}* Held by {}.\n\n", c.number, c.title, c.answer,
                        links_to(c.tests));
    page += "| scene | pictures | worst z | no numbers | kurtosis | largest contribution |\n";
    page += "|---|---|---|---|---|---|\n";
    for (const Row& row : rows) {
      if (row.of->number == c.number) add_trial(page, row);
    }
    page += "\n";
  }
  if (has(rows, Answer::kDiffers)) {
    page += "## What differs\n\n";
    add_list(page, rows, Answer::kDiffers);
  }
  page += kNotHeld;
  if (has(rows, Answer::kUndecided)) {
    page +=
        "- Open: pictures that say nothing, as hardly any of the renders on one side found the "
        "light in question, or as a single sample is more than 30 % of the sum. Each is named "
        "where its scene is made; of any other, that is a failure:\n\n";
    add_list(page, rows, Answer::kUndecided);
  }
  page += "\nNot meant for it:\n\n";
  add_list(page, rows, Answer::kNotMeant);
  return page;
}

}  // namespace kinome::test
