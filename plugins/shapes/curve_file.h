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

/// Curves as Mitsuba 3 has them in text files: a control point's x, y, z and radius a line, blank
/// lines between curves. A radius of 0 is a pointed tip. Places go through to_world; radii stay as
/// they are, as in Mitsuba.
class CurveFileReader {
 public:
  /// `is_bspline`: four control points make the first segment of a curve; else two do.
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
    if (has_more_) log_unused(file_, {"what follows four numbers in a line"});
    return std::move(curves_);
  }

 private:
  void read_point(const Transform& to_world) {
    if (curve_size_ == 0) first_line_ = cursor_.line();
    Vec3 place;
    for (int i = 0; i < 3; ++i) place[i] = static_cast<float>(cursor_.number("a coordinate"));
    if (!is_finite(place)) cursor_.fail("a control point has a position that is not finite");
    const auto radius = static_cast<float>(cursor_.number("a radius"));
    if (!(radius >= 0) || !std::isfinite(radius)) {
      cursor_.fail("a radius must be finite and not negative, got " + std::to_string(radius));
    }
    has_more_ = has_more_ || !cursor_.at_line_end();
    curves_.points.emplace_back(to_world.point(place), radius);
    if (++curve_size_ >= points_of_segment_) {
      curves_.segments.push_back(static_cast<uint32_t>(curves_.points.size() - points_of_segment_));
    }
    // Numbers of floats are counted in int32_t.
    if (curves_.points.size() > (size_t{1} << 29))
      cursor_.fail("there are too many control points");
  }
  /// Gives pointed tips, whose radius is 0, a radius that can't be seen, since a curve has normals
  /// only at a distance from its centre line.
  void open_tips() {
    constexpr float kTip = 1e-4f;  // in units of the largest radius
    float largest = 0;
    for (const glm::vec4& point : curves_.points) largest = std::max(largest, point.w);
    if (!(largest > 0)) throw Error(Location{file_, 0, 0}, "the radii of all curves are 0");
    const float least = std::max(kTip * largest, std::numeric_limits<float>::min());
    for (glm::vec4& point : curves_.points) {
      if (point.w == 0) point.w = least;
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
