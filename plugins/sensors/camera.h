#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "kinome/bsdf_medium.h"
#include "kinome/properties.h"
#include "kinome/sensor.h"
#include "kinome/wide/vectors.h"

/// Helpers that cameras share. Cameras look along +Z of their own frame, with +X to the left of the
/// image and +Y up.
namespace kinome {

/// Parameters of all sensors.
#define KINOME_SENSOR_PARAMETERS                                                                   \
  {"shutter_open", ParameterType::kFloat, "0",                                                     \
   "start of the exposure; only affects timed_sunsky"},                                            \
      {"shutter_close", ParameterType::kFloat, "0",                                                \
       "end of the exposure; only affects timed_sunsky"},                                          \
      {"film", ParameterType::kObject, nullptr, "film; default: hdrfilm", false, Category::kFilm}, \
      {"sampler", ParameterType::kObject, nullptr, "sampler; default: independent",                \
       false,     Category::kSampler},                                                             \
      {"medium", ParameterType::kObject, nullptr, "medium around the sensor; default: none",       \
       false,    Category::kMedium},                                                               \
  {                                                                                                \
    "bsdf", ParameterType::kObject, nullptr,                                                       \
        "BSDF such as `subsurface`, in whose medium the sensor is; alternative to a medium",       \
        false, Category::kBsdf                                                                     \
  }

/// Parameters of every camera.
#define KINOME_CAMERA_PARAMETERS                                                           \
  {"to_world", ParameterType::kTransform, "identity",                                      \
   "transform from camera to world; the camera looks along +Z"},                           \
      {"near_clip", ParameterType::kFloat, "0.01", "depth of the nearest visible point"},  \
      {"far_clip", ParameterType::kFloat, "10000", "depth of the farthest visible point"}, \
      KINOME_SENSOR_PARAMETERS

inline constexpr const char* kFovAxes[] = {"x", "y", "diagonal", "smaller", "larger"};

/// Parameters of cameras with a field of view.
#define KINOME_FOV_PARAMETERS                                               \
  {"fov", ParameterType::kFloat, nullptr,                                   \
   "field of view in degrees along fov_axis; alternative to focal_length"}, \
      {"focal_length", ParameterType::kString, "50mm",                      \
       "focal length for a film of 36 x 24 mm, such as 50mm"},              \
      choice_of("fov_axis", kFovAxes, "x",                                  \
                "side of the film that fov spans: x, y, diagonal, smaller or larger")

struct ClipRange {
  float near = 0;
  float far = 0;
};

inline float read_positive(const Properties& props, const char* name) {
  return props.real(name, "must be positive", [](float value) { return value > 0; });
}

inline ClipRange read_clip_range(const Properties& props) {
  const float near = read_positive(props, "near_clip");
  const float far =
      props.real("far_clip", "must be greater than near_clip (" + format_number(near) + ")",
                 [near](float depth) { return near < depth; });
  return {near, far};
}

inline Shutter read_shutter(const Properties& props) {
  const float open = props.real("shutter_open");
  return {open, props.real("shutter_close",
                           "must not be before shutter_open (" + format_number(open) + ")",
                           [open](float close) { return !(close < open); })};
}

inline Transform read_camera_transform(const Properties& props, bool scale_allowed) {
  const Transform to_world = props.transform("to_world");
  if (!to_world.is_invertible()) throw props.error("to_world", "must be invertible");
  if (!scale_allowed && to_world.has_scale()) {
    throw props.error("to_world",
                      "must not scale: fov, clip distances and focus distance would change");
  }
  return to_world;
}

/// Reads the camera's film or sampler, which the loader adds if the scene has none.
template <class T>
std::shared_ptr<T> read_part(const Properties& props, const char* name) {
  auto part = props.object<T>();
  if (!part)
    throw props.error(name, std::string("is missing: the sensor needs a nested <") + name + ">");
  return part;
}

/// Returns the nested medium, or that of the nested BSDF. nullptr: none.
inline std::shared_ptr<const Medium> medium_around(const Properties& props) {
  const auto medium = props.object<Medium>();
  const auto bsdf = props.object<Bsdf>();
  const bool is_faulty = bsdf && bsdf->plugin().empty();  // an error was reported
  if (!bsdf || is_faulty) return medium;
  if (medium) throw props.error("bsdf", "can't be combined with a medium: remove one of them");
  std::shared_ptr<const Medium> inside;
  try {
    inside = interior_of(*bsdf);
  } catch (const Error& error) {
    throw Error(props.where(), error.what());
  }
  if (inside) return inside;
  throw props.error("bsdf",
                    "must define a medium, as 'subsurface' does, got '" + bsdf->plugin() + "'");
}

/// Sensor with KINOME_SENSOR_PARAMETERS.
class ParsedSensor : public Sensor {
 protected:
  explicit ParsedSensor(const Properties& props) {
    shutter_ = read_shutter(props);
    film_ = read_part<Film>(props, "film");
    sampler_ = read_part<Sampler>(props, "sampler");
    medium_ = medium_around(props);
  }
};

inline float aspect_ratio(const Film& film) {
  return static_cast<float>(film.width()) / static_cast<float>(film.height());
}

/// Returns half of the image's width at depth 1, from fov and fov_axis or from focal_length.
/// `aspect` is width / height of the full film.
inline float read_half_width(const Properties& props, float aspect) {
  const auto from_diagonal = [aspect](double diagonal) {
    return static_cast<float>(diagonal / std::sqrt(1 + 1 / (double{aspect} * aspect)));
  };
  if (!props.has("fov")) {
    constexpr double kHalfDiagonal = 21.633307652783937;  // of 36 x 24 mm
    std::string text = props.string("focal_length");
    if (text.ends_with("mm")) text.resize(text.size() - 2);
    char* end = nullptr;
    const double focal_length = std::strtod(text.c_str(), &end);
    while (*end == ' ') ++end;
    if (end == text.c_str() || *end != '\0' || !(focal_length > 0) ||
        !std::isfinite(focal_length)) {
      throw props.error("focal_length",
                        "must be a positive number of millimetres such as '50mm', "
                        "got '" +
                            props.string("focal_length") + "'");
    }
    return from_diagonal(kHalfDiagonal / focal_length);
  }
  props.exclude("focal_length", "fov");
  const float fov = props.real("fov", "must be greater than 0 and less than 180 degrees",
                               [](float angle) { return angle > 0 && angle < 180; });
  const double tangent = std::tan(double{fov} * std::numbers::pi / 360);
  const int axis = props.choice("fov_axis");
  if (axis == 2) return from_diagonal(tangent);
  const bool is_wide = aspect > 1;
  const bool along_y = axis == 1 || (axis == 3 && is_wide) || (axis == 4 && !is_wide);
  return static_cast<float>(along_y ? tangent * aspect : tangent);
}

/// Maps film positions to the image plane: at depth 1 for perspective cameras, at depth 0 for
/// orthographic ones.
struct FilmPlane {
  Vec2 origin{0.f};  ///< point of film position (0, 0), the image's upper left corner
  Vec2 step{0.f};    ///< step from pixel to pixel

  FilmPlane() = default;
  /// `half_width` is that of the full film; `offset` moves the image's centre, in units of its
  /// size.
  FilmPlane(const Film& film, float half_width, const Vec2& offset = Vec2(0.f)) {
    const double w = film.width();
    const double h = film.height();
    const double half_height = half_width * h / w;
    origin = Vec2(half_width * (1 - 2.0 * offset.x), half_height * (1 - 2.0 * offset.y));
    step = Vec2(-2 * half_width / w, -2 * half_height / h);
  }
  /// V is Vec2 or wide::Vec2.
  template <class V>
  V at(const V& film_position) const {
    return V(origin) + V(step) * film_position;
  }
  /// The inverse of at().
  template <class V>
  V film_position(const V& p) const {
    return (p - V(origin)) / V(step);
  }
  /// Area of a pixel on the plane.
  float pixel_area() const { return std::abs(step.x * step.y); }
};

/// One ray (F is float) or a vector of rays (F is wide::Float).
template <class F>
struct CameraRay {
  wide::VecOf<F> o, d;
  F tmin, tmax;

  Ray one() const { return {o, d, tmin, tmax}; }
};

/// Transform a vector or a point, or several (wide::Vec3).
inline Vec3 transform_vector(const Transform& to_world, const Vec3& v) {
  return to_world.vector(v);
}
inline Vec3 transform_point(const Transform& to_world, const Vec3& p) {
  return to_world.point(p);
}
inline wide::Vec3 transform_vector(const Transform& to_world, const wide::Vec3& v) {
  const Mat4& m = to_world.matrix();
  return wide::Vec3(Vec3(m[0])) * v.x + wide::Vec3(Vec3(m[1])) * v.y + wide::Vec3(Vec3(m[2])) * v.z;
}
inline wide::Vec3 transform_point(const Transform& to_world, const wide::Vec3& p) {
  return transform_vector(to_world, p) + wide::Vec3(Vec3(to_world.matrix()[3]));
}

/// One SensorConnection (F is float) or a vector of them (F is wide::Float).
template <class F>
struct Connection {
  wide::Vec2Of<F> film_position;
  wide::VecOf<F> d;
  F distance, weight;
  wide::MaskOf<F> is_seen;

  std::optional<SensorConnection> one() const {
    if (!is_seen) return std::nullopt;
    return SensorConnection{film_position, d, distance, weight};
  }
};

template <class V2>
auto contains(const Rect& pixels, const V2& p) {
  return p.x >= static_cast<float>(pixels.x0) && p.x < static_cast<float>(pixels.x1) &&
         p.y >= static_cast<float>(pixels.y0) && p.y < static_cast<float>(pixels.y1);
}

/// Implements Sensor::connect for a point of the lens, at depth 0. `p` and `lens` are in the
/// camera's frame, and `on_plane` is the image of p on the plane at depth 1. A pixel's solid angle
/// is its area on the plane times cos³.
template <class V, class V2>
Connection<wide::NumberOf<V>> connect_to_lens(const V& p, const V& lens, const V2& on_plane,
                                              const FilmPlane& plane, const ClipRange& clip,
                                              const Film& film, const Transform& to_world) {
  using namespace wide::formulas;
  using F = NumberOf<V>;
  const V2 film_position = plane.film_position(on_plane);
  const V to_lens = lens - p;
  const F distance2 = dot(to_lens, to_lens);
  const F distance = sqrt(distance2);
  const F cosine = p.z / distance;
  return {film_position, normalize(transform_vector(to_world, to_lens)),
          distance - clip.near / cosine,
          1.f / (plane.pixel_area() * cosine * cosine * cosine * distance2),
          p.z >= clip.near && p.z <= clip.far && contains(film.sampled(), film_position)};
}

/// Base of cameras that are formulas over a number type F, float or wide::Float. Implements the
/// scalar and the block functions of Sensor. Self must provide
///
///     template <class F>
///     CameraRay<F> ray(const wide::Vec2Of<F>& position, const wide::Vec2Of<F>& aperture) const;
///     template <class F>
///     Connection<F> connection(const wide::VecOf<F>& p, const wide::Vec2Of<F>& aperture) const;
template <class Self>
class FormulaSensor : public ParsedSensor {
 public:
  Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const override {
    return self().template ray<float>(film_position, aperture).one();
  }
  void sample_ray_block(const Columns2& film_position, const Columns2& aperture, size_t count,
                        RayHit16* out) const override {
    wide::for_lanes(count, [&](size_t i) {
      const CameraRay<wide::Float> ray = self().template ray<wide::Float>(
          wide::Vec2::load(film_position, i), wide::Vec2::load(aperture, i));
      Ray16& to = out[i / kBlockLanes].ray;
      const size_t lane = i % kBlockLanes;
      ray.o.store({to.ox, to.oy, to.oz}, lane);
      ray.d.store({to.dx, to.dy, to.dz}, lane);
      ray.tmin.store(to.tmin + lane);
      ray.tmax.store(to.tmax + lane);
    });
  }
  std::optional<SensorConnection> connect(const Vec3& p, const Vec2& aperture) const override {
    return self().template connection<float>(p, aperture).one();
  }
  void connect_block(const Columns3& p, const Columns2& aperture, size_t count,
                     const ConnectionBlock& out) const override {
    wide::for_lanes(count, [&](size_t i) {
      const Connection<wide::Float> c = self().template connection<wide::Float>(
          wide::Vec3::load(p, i), wide::Vec2::load(aperture, i));
      c.film_position.store(out.film_position, i);
      select(c.is_seen, c.d, wide::Vec3(0.f, 0.f, 1.f)).store(out.d, i);
      c.distance.store(out.distance + i);
      select(c.is_seen, c.weight).store(out.weight + i);
    });
  }

 protected:
  FormulaSensor(const Properties& props, bool scale_allowed)
      : ParsedSensor(props),
        to_world_(read_camera_transform(props, scale_allowed)),
        to_camera_(to_world_.inverse()) {}

  Transform to_world_;
  Transform to_camera_;

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }
};

}  // namespace kinome
