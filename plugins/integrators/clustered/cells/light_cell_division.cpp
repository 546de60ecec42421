// Divides the sky into cells: DistantCells::divide().

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

#include "clustered/cells/hilbert_points.h"
#include "clustered/cells/light_cells.h"
#include "clustered/cells/quad_importance.h"

namespace kinome {
namespace {

/// Cells are no wider than a turn divided by this value. The horizon test needs less than half.
constexpr int kMaxWidthShare = 8;
/// Priority of dividing a cell that is too wide.
constexpr double kWideCellPriority = 1e300;

}  // namespace

/// A rectangle of quads that may be divided.
struct DistantCells::Candidate {
  int x0, y0, x1, y1;
  double priority;
  uint32_t age;  ///< breaks ties, so that the result is deterministic

  /// True if the other one is divided first.
  bool operator<(const Candidate& other) const {
    return priority != other.priority ? priority < other.priority : age > other.age;
  }
};

int DistantCells::max_width() const {
  return std::max(1, grid_.columns / kMaxWidthShare);
}

/// Returns the priority of dividing a rectangle; negative if it is a single quad.
double DistantCells::urgency(const Candidate& c) const {
  if (c.x1 - c.x0 <= 1 && c.y1 - c.y0 <= 1) return -1.;
  if (c.x1 - c.x0 > max_width()) return kWideCellPriority;
  double flux = 0, squares = 0;
  for (int y = c.y0; y < c.y1; ++y) {
    const QuadImportance::Sums sums = importance_->sum(y, c.x0, c.x1);
    flux += sums.values * quad_solid_angle(y);
    squares += sums.squares * quad_solid_angle(y);
  }
  const double turn = 2 * std::numbers::pi / grid_.columns;
  const double angle = (row_cosines_[c.y0] - row_cosines_[c.y1]) * turn * (c.x1 - c.x0);
  const double variance = std::max(0., squares - flux * flux / angle);
  return std::sqrt(variance * angle) + 0.02 * flux * std::sqrt(angle);
}

/// Divides a rectangle across its longer side on the sphere.
std::pair<DistantCells::Candidate, DistantCells::Candidate> DistantCells::halves(
    const Candidate& c) const {
  const int width = c.x1 - c.x0, height = c.y1 - c.y0;
  const double turn = 2 * std::numbers::pi / grid_.columns;
  const double middle = (c.y0 + c.y1) * 0.5 * std::numbers::pi / grid_.rows;
  const double wide = width * turn * std::max(0.05, std::sin(middle));
  const double high = height * std::numbers::pi / grid_.rows;
  Candidate a = c, b = c;
  if (height <= 1 || width > max_width() || (width > 1 && wide >= high)) {
    a.x1 = b.x0 = c.x0 + width / 2;
  } else {
    a.y1 = b.y0 = c.y0 + height / 2;
  }
  return {a, b};
}

void DistantCells::divide(uint32_t count) {
  const int columns = grid_.columns, rows = grid_.rows;
  std::priority_queue<Candidate> queue;
  uint32_t age = 0;
  const auto push = [&](Candidate c) {
    c.priority = urgency(c);
    c.age = age++;
    queue.push(c);
  };
  // No cell straddles the map's horizon, so that few straddle that of a floor.
  const int upper = rows / 2, lower = (rows + 1) / 2;
  if (upper > 0) push({0, 0, columns, upper, 0, 0});
  if (lower > upper) push({0, upper, columns, lower, 0, 0});
  if (rows > lower) push({0, lower, columns, rows, 0, 0});
  while (queue.top().priority >= (queue.size() < count ? 0 : kWideCellPriority)) {
    const auto [a, b] = halves(queue.top());
    queue.pop();
    push(a);
    push(b);
  }
  std::vector<std::pair<uint32_t, Rectangle>> cells;
  for (; !queue.empty(); queue.pop()) {
    const Candidate& c = queue.top();
    const auto place = [](double share) { return static_cast<uint32_t>(share * 65535); };
    cells.emplace_back(
        hilbert_index(place((c.x0 + c.x1) * 0.5 / columns), place((c.y0 + c.y1) * 0.25 / rows)),
        Rectangle{c.x0, c.y0, c.x1, c.y1});
  }
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) {
    return a.first != b.first
               ? a.first < b.first
               : std::pair(a.second.y0, a.second.x0) < std::pair(b.second.y0, b.second.x0);
  });
  size_ = static_cast<uint32_t>(cells.size());
  cell_of_quad_ = std::make_unique_for_overwrite<uint16_t[]>(static_cast<size_t>(columns) * rows);
  for (const auto& cell : cells) rectangles_.push_back(cell.second);
}

}  // namespace kinome
