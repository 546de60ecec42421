#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kinome/log.h"
#include "kinome/shape.h"
#include "mesh_file.h"

namespace kinome {

/// Reads curves from a text file in the format of Mitsuba 3: x, y, z and radius of one control
/// point per line, with blank lines between curves. A radius of 0 is a pointed tip. As in Mitsuba,
/// to_world transforms positions, but not radii.
class CurveFileReader {
 public:
  /// The first segment of a curve needs four control points if `is_bspline`, otherwise two.
  CurveFileReader(const std::string& file, std::string_view text, bool is_bspline)
      : file_(file), cursor_(file, text), points_of_segment_(is_bspline ? 4 : 2) {
    curves_.is_bspline = is_bspline;
  }

  CurveSet read(const Transform& to_world) {
    for (; !cursor_.at_end(); cursor_.next_line()) {
      if (cursor_.at_line_end()) {
        end_curve();
      } else {
        read_point(to_world);
      }
    }
    end_curve();
    if (curves_.segments.empty()) throw Error(Location{file_, 0, 0}, "the file has no curves");
    open_tips();
    if (has_more_) log_unused(file_, {"text after the fourth number of a line"});
    return std::move(curves_);
  }

 private:
  void read_point(const Transform& to_world) {
    if (curve_size_ == 0) first_line_ = cursor_.line();
    Vec3 position;
    for (int i = 0; i < 3; ++i) position[i] = static_cast<float>(cursor_.number("a coordinate"));
    if (!is_finite(position)) cursor_.fail("a control point has a position that is not finite");
    const auto radius = static_cast<float>(cursor_.number("a radius"));
    if (!(radius >= 0) || !std::isfinite(radius)) {
      cursor_.fail("a radius must be finite and not negative, got " + format_number(radius));
    }
    has_more_ = has_more_ || !cursor_.at_line_end();
    curves_.points.emplace_back(to_world.point(position), radius);
    if (++curve_size_ >= points_of_segment_) {
      curves_.segments.push_back(static_cast<uint32_t>(curves_.points.size() - points_of_segment_));
    }
    // Counts of floats must fit in int32_t.
    if (curves_.points.size() > (size_t{1} << 29))
      cursor_.fail("there are too many control points");
  }
  /// Replaces radii of 0 (pointed tips) by an invisibly small radius, because normals are undefined
  /// on the centre line.
  void open_tips() {
    constexpr float kTip = 1e-4f;  // in units of the largest radius
    float max_radius = 0;
    for (const glm::vec4& point : curves_.points) max_radius = std::max(max_radius, point.w);
    if (!(max_radius > 0)) throw Error(Location{file_, 0, 0}, "the radii of all curves are 0");
    const float tip_radius = std::max(kTip * max_radius, std::numeric_limits<float>::min());
    for (glm::vec4& point : curves_.points) {
      if (point.w == 0) point.w = tip_radius;
    }
  }
  void end_curve() {
    if (curve_size_ > 0 && curve_size_ < points_of_segment_) {
      cursor_.fail_at(first_line_, "a curve has " + std::to_string(curve_size_) +
                                       " control points, expected at least " +
                                       std::to_string(points_of_segment_));
    }
    curve_size_ = 0;
  }

  std::string file_;
  TextCursor cursor_;
  size_t points_of_segment_;
  size_t curve_size_ = 0;
  int first_line_ = 0;
  bool has_more_ = false;
  CurveSet curves_;
};

}  // namespace kinome
