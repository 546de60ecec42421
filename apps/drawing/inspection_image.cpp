#include "drawing/inspection_image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace kinome::drawing {
namespace {

constexpr int kMinSceneSide = 768;  ///< minimum length of the longer side
constexpr uint32_t kNone = ~0u;

const Rgb kOutline(0.9f, 0.8f, 0.1f);
const Rgb kLit(1, 0.05f, 0.02f);
const Rgb kShadowed(0.1f, 0.3f, 1);
const Rgb kPoint(0.1f, 1, 0.2f);

/// Returns the radius of a sample's disk. Its area is proportional to the weight, within limits.
float sample_radius(const Inspection& report, double weight) {
  const double unit = report.is_learned ? 4 : 1.5;
  return static_cast<float>(std::clamp(unit * std::sqrt(weight), 1.5, 6.));
}

Rgb hidden_color(const Rgb& color) {
  return 0.15f * color + Rgb(0, 0.01f, 0.08f);
}

/// Returns the index of the smallest box that contains a position, with tolerance `slack`; kNone if
/// none does.
uint32_t cluster_at(const std::vector<InspectedCluster>& clusters, const Vec3& p, float slack) {
  uint32_t found = kNone;
  float smallest = kInfinity;
  for (uint32_t c = 0; c < clusters.size(); ++c) {
    const Aabb& box = clusters[c].box;
    if (glm::any(glm::lessThan(p, box.lo - slack)) ||
        glm::any(glm::greaterThan(p, box.hi + slack))) {
      continue;
    }
    const float size = glm::length(box.extent());
    if (size < smallest) {
      smallest = size;
      found = c;
    }
  }
  return found;
}

void outline_clusters(const Inspection& report, InspectionView& view) {
  const int width = view.canvas.image.width, height = view.canvas.image.height;
  std::vector<uint32_t> cluster(view.positions.size(), kNone);
  for (size_t i = 0; i < cluster.size(); ++i) {
    if (!view.valid[i]) continue;
    cluster[i] = report.cluster_at ? report.cluster_at(view.positions[i])
                                   : cluster_at(report.clusters, view.positions[i], view.slack);
  }
  if (report.is_learned) {  // hidden clusters become dark blue
    for (size_t i = 0; i < cluster.size(); ++i) {
      if (cluster[i] == kNone) continue;
      const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
      const auto visibility = static_cast<float>(report.clusters[cluster[i]].visibility);
      Rgb color;
      for (int c = 0; c < 3; ++c) color[c] = view.canvas.image.at(x, y, c);
      view.canvas.set(x, y, glm::mix(hidden_color(color), color, visibility));
    }
  }
  for (int y = 0; y + 1 < height; ++y) {
    for (int x = 0; x + 1 < width; ++x) {
      const size_t i = static_cast<size_t>(y) * width + x;
      if (cluster[i] != cluster[i + 1] || cluster[i] != cluster[i + width]) {
        view.canvas.set(x, y, kOutline);
      }
    }
  }
}

/// Legend below the image. Each line has a symbol and its meaning.
class Legend {
 public:
  Legend(Canvas& canvas, int lines)
      : canvas_(canvas), scale_(canvas.image.width >= 700 ? 2 : 1), top_(canvas.image.height) {
    canvas.extend(lines * height() + height());
    canvas.fill({0, top_, canvas.image.width, canvas.image.height}, Rgb(0.012f));
    top_ += height() / 2;
  }
  int height() const { return 11 * scale_ + 2; }
  void title(const std::string& text) {
    canvas_.text(kLeft, top_, scale_, text, Rgb(0.9f));
    top_ += height();
  }
  /// Adds a line. `draw_symbol` draws into a box.
  template <class DrawSymbol>
  void line(const DrawSymbol& draw_symbol, const std::string& text) {
    draw_symbol(Rect{kLeft, top_, kLeft + symbol_width(), top_ + 7 * scale_});
    canvas_.text(kLeft + symbol_width() + 8 * scale_, top_, scale_, text, Rgb(0.55f));
    top_ += height();
  }

 private:
  static constexpr int kLeft = 12;
  int symbol_width() const { return 40 * scale_; }
  Canvas& canvas_;
  int scale_;
  int top_;
};

Vec2 centre_of(const Rect& box) {
  return 0.5f * Vec2(box.x0 + box.x1, box.y0 + box.y1);
}

/// Draws a bar of the tone-mapped radiance L / (1 + L), with marks at L = 1/4, 1 and 4.
void draw_radiance_bar(const Rect& box, Canvas& canvas) {
  const auto position = [&](float share) {
    return box.x0 + static_cast<int>(share * static_cast<float>(box.width()));
  };
  for (int x = box.x0; x < box.x1; ++x) {
    const float share = (static_cast<float>(x - box.x0) + 0.5f) / static_cast<float>(box.width());
    canvas.fill({x, box.y0, x + 1, box.y1}, Rgb(share));
  }
  for (const float radiance : {0.25f, 1.f, 4.f}) {
    const int x = position(radiance / (1 + radiance));
    canvas.fill({x, box.y0 - 3, x + 2, box.y1 + 3}, Rgb(0.9f, 0.4f, 0.1f));
  }
  canvas.frame({box.x0 - 1, box.y0 - 1, box.x1 + 1, box.y1 + 1}, Rgb(0.3f));
}

/// Returns the direction at a position of the map: the inverse of map_position().
Vec3 map_direction(float x, float y) {
  const float phi = 2 * kPi * x / kMapWidth;
  const float theta = kPi * y / kMapHeight;
  return {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)};
}

InspectionView environment_view(const Scene& scene) {
  InspectionView view{Canvas(kMapWidth, kMapHeight), {}, {}};
  for (int y = 0; y < kMapHeight; ++y) {
    for (int x = 0; x < kMapWidth; ++x) {
      const Vec3 d = map_direction(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      view.positions.push_back(d);
      view.valid.push_back(1);
      Rgb light(0.f);
      if (scene.environment()) light = glm::max(scene.environment()->eval_environment(d), 0.f);
      view.canvas.set(x, y, light / (1.f + light));
    }
  }
  return view;
}

InspectionView scene_view(const Scene& scene, const Sensor& sensor) {
  const Vec2 film(sensor.film().width(), sensor.film().height());
  const float factor = std::max(1.f, kMinSceneSide / std::max(film.x, film.y));
  const int width = std::max(1, static_cast<int>(std::lround(factor * film.x)));
  const int height = std::max(1, static_cast<int>(std::lround(factor * film.y)));
  InspectionView view{Canvas(width, height),
                      {},
                      {},
                      Vec2(width, height) / film,
                      1e-4f * glm::length(scene.bounds().extent())};
  std::vector<RayHit> rays;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec2 position = film_position(x, y, Vec2(0.5f)) / view.scale;
      rays.push_back({sensor.sample_ray(position, Vec2(0.5f)), {}});
    }
  }
  RenderCounters counters;
  scene.intersect(rays, Coherence::kCoherent, counters);
  for (size_t i = 0; i < rays.size(); ++i) {
    Vec3 p(0.f);
    const bool hit = rays[i].hit.valid();
    if (hit) {
      const SurfaceInteraction si = scene.interaction(rays[i]);
      p = si.p;
      const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
      view.canvas.set(x, y, Rgb(0.05f + 0.35f * std::abs(glm::dot(si.frame.n, rays[i].ray.d))));
    }
    view.positions.push_back(p);
    view.valid.push_back(hit);
  }
  return view;
}

}  // namespace

Vec2 map_position(const Vec3& d) {
  float phi = std::atan2(d.x, -d.z) / (2 * kPi);
  if (phi < 0) phi += 1;
  return {phi * kMapWidth, std::acos(std::clamp(d.y, -1.f, 1.f)) * kInvPi * kMapHeight};
}

std::optional<Vec2> InspectionView::find(const Sensor& sensor, const Vec3& position) const {
  const auto connection = sensor.connect(position, Vec2(0.5f));
  if (!connection) return std::nullopt;
  return connection->film_position * scale;
}

InspectionView inspection_view(const Inspection& report, const Scene& scene, const Sensor& sensor) {
  const bool distant = report.is_distant;
  InspectionView view = distant ? environment_view(scene) : scene_view(scene, sensor);
  outline_clusters(report, view);
  for (const InspectedSample& sample : report.samples) {
    const auto at = distant ? map_position(sample.position) : view.find(sensor, sample.position);
    if (!at) continue;
    view.canvas.disk(*at, sample_radius(report, sample.weight), sample.visible ? kLit : kShadowed);
  }
  const auto at = distant ? std::nullopt : view.find(sensor, report.position);
  if (at) view.canvas.disk(*at, 4, kPoint);
  return view;
}

void add_legend(const Inspection& report, const Vec2& pixel, Canvas& canvas) {
  const bool distant = report.is_distant;
  Legend legend(canvas, 5 + (report.is_learned ? 1 : 0) + (distant ? 0 : 1));
  legend.title(fmt::format("pixel {},{}: {} samples among {} clusters of {}", pixel.x, pixel.y,
                           report.samples.size(), report.clusters.size(),
                           distant ? "the sky" : "surfaces"));
  if (distant) {
    legend.line([&](const Rect& box) { draw_radiance_bar(box, canvas); },
                "the sky, +y up: marks at radiance 1/4, 1 and 4");
  } else {
    legend.line([&](const Rect& box) { canvas.fill(box, Rgb(0.25f)); },
                "the scene, lit from the camera");
    legend.line([&](const Rect& box) { canvas.disk(centre_of(box), 4, kPoint); },
                "the shading point");
  }
  legend.line(
      [&](const Rect& box) {
        canvas.frame(box, kOutline);
        canvas.fill({(box.x0 + box.x1) / 2, box.y0, (box.x0 + box.x1) / 2 + 1, box.y1}, kOutline);
      },
      "borders of clusters (each sample chooses one)");
  if (report.is_learned) {
    legend.line([&](const Rect& box) { canvas.fill(box, hidden_color(Rgb(0.4f))); },
                "bluer clusters are less visible, as learned");
  }
  // Weights within the limits of sample_radius().
  const auto weights = report.is_learned ? std::array{0.25, 1., 2.} : std::array{1., 4., 16.};
  const auto samples = [&](const Rgb& color) {
    return [&, color](const Rect& box) {
      for (int i = 0; i < 3; ++i) {
        const float x = static_cast<float>(box.x0) +
                        static_cast<float>(box.width()) * (static_cast<float>(i) + 0.5f) / 3;
        canvas.disk({x, centre_of(box).y}, sample_radius(report, weights[i]), color);
      }
    };
  };
  legend.line(samples(kLit), fmt::format("visible: weights of {} times the mean",
                                         report.is_learned ? "1/4, 1 and 2" : "1, 4 and 16"));
  legend.line(samples(kShadowed), "shadowed");
}

}  // namespace kinome::drawing
