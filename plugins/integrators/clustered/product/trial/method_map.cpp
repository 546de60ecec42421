#include "clustered/product/trial/method_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace kinome {
namespace {

/// Standard deviation of the kernel, relative to the sum of the image's width and height.
constexpr float kReach = 0.1f;
/// Weight of tiles that show another material, and of the mean of all trials.
constexpr float kOtherMaterial = 0.1f, kAll = 0.5f;
/// If a tile is left out, tiles at a smaller distance are, too: they are of its group in the trial.
constexpr int kGroupReach = 2;

/// Sum of the values plus its standard error.
double sum_with_error(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(values.size());
  if (n < 2) return sum;
  return sum + std::sqrt(std::max(0., squares - sum * sum / n) * n / (n - 1));
}

/// Returns the square roots of the works, or 0 for negative works, which are due to chance.
std::vector<MethodMap::Trial> roots_of(std::vector<MethodMap::Trial> trials) {
  for (MethodMap::Trial& trial : trials) {
    trial.product = std::sqrt(std::max(0., trial.product));
    trial.path = std::sqrt(std::max(0., trial.path));
  }
  return trials;
}

}  // namespace

MethodMap::MethodMap(const TileGrid& grid, std::vector<Trial> trials)
    : grid_(grid), roots_(roots_of(std::move(trials))) {
  for (const Trial& trial : roots_) {
    product_ += trial.product;
    path_ += trial.path;
  }
}

double MethodMap::work_of(double sum_of_roots) const {
  return sum_of_roots * sum_of_roots / static_cast<double>(std::max<size_t>(1, roots_.size()));
}

bool MethodMap::is_for_path(int tile, const Bsdf* bsdf, int left_out) const {
  if (roots_.empty()) return false;
  const int width = grid_.tiles_x(), x = tile % width, y = tile / width;
  const float reach = kReach * static_cast<float>(width + grid_.tiles_y());
  const float scale = 1 / (reach * reach);
  double product = 0, path = 0, all_product = product_, all_path = path_;
  for (const Trial& trial : roots_) {
    const int dx = trial.tile % width - x, dy = trial.tile / width - y;
    if (left_out >= 0 && std::max(std::abs(dx), std::abs(dy)) < kGroupReach) {
      all_product -= trial.product;
      all_path -= trial.path;
      continue;
    }
    const float distance2 = static_cast<float>(dx * dx + dy * dy) * scale;
    const float falloff = 1 / (1 + distance2);
    const float weight = (trial.bsdf == bsdf ? 1.f : kOtherMaterial) * falloff * falloff;
    product += weight * trial.product;
    path += weight * trial.path;
  }
  const double prior = kAll / static_cast<double>(roots_.size());
  return path + prior * all_path < product + prior * all_product;
}

double MethodMap::mixed_work() const {
  double paths = 0;
  std::vector<double> product;
  for (const Trial& trial : roots_) {
    if (is_for_path(trial.tile, trial.bsdf, trial.tile)) {
      paths += trial.path;
    } else {
      product.push_back(trial.product);
    }
  }
  return work_of(paths + sum_with_error(product));
}

double MethodMap::product_work() const {
  std::vector<double> product;
  for (const Trial& trial : roots_) product.push_back(trial.product);
  return work_of(sum_with_error(product));
}

}  // namespace kinome
