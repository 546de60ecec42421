#pragma once

#include <string>

#include <fmt/format.h>

#include "kinome/image.h"
#include "kinome/math.h"

/// Parts of scenes. Numbers are written with nine digits, so that parsing restores the exact float,
/// however small or large.
namespace kinome::test::xml {

inline std::string digits(double value) {
  return fmt::format("{:.9g}", value);
}
inline std::string digits(const Vec3& v) {
  return digits(v.x) + " " + digits(v.y) + " " + digits(v.z);
}
inline std::string number(const std::string& name, double value) {
  return "<float name='" + name + "' value='" + digits(value) + "'/>";
}
inline std::string integer(const std::string& name, int64_t value) {
  return "<integer name='" + name + "' value='" + std::to_string(value) + "'/>";
}
inline std::string boolean(const std::string& name, bool value) {
  return "<boolean name='" + name + "' value='" + (value ? "true" : "false") + "'/>";
}
inline std::string text(const std::string& name, const std::string& value) {
  return "<string name='" + name + "' value='" + value + "'/>";
}
inline std::string color(const std::string& name, const Vec3& rgb) {
  return "<rgb name='" + name + "' value='" + digits(rgb) + "'/>";
}
inline std::string point(const std::string& name, const Vec3& p) {
  return "<point name='" + name + "' value='" + digits(p) + "'/>";
}
inline std::string vector(const std::string& name, const Vec3& v) {
  return "<vector name='" + name + "' value='" + digits(v) + "'/>";
}

inline std::string scale(const Vec3& factors) {
  return "<scale value='" + digits(factors) + "'/>";
}
inline std::string scale(double factor) {
  return "<scale value='" + digits(factor) + "'/>";
}
inline std::string translate(const Vec3& by) {
  return "<translate value='" + digits(by) + "'/>";
}
inline std::string rotate(const Vec3& axis, double degrees) {
  return fmt::format("<rotate x='{}' y='{}' z='{}' angle='{}'/>", digits(axis.x), digits(axis.y),
                     digits(axis.z), digits(degrees));
}
inline std::string look_at(const Vec3& origin, const Vec3& target, const Vec3& up) {
  return "<lookat origin='" + digits(origin) + "' target='" + digits(target) + "' up='" +
         digits(up) + "'/>";
}
/// Returns `operations` as to_world, or "" if there are none.
inline std::string to_world(const std::string& operations) {
  return operations.empty() ? "" : "<transform name='to_world'>" + operations + "</transform>";
}

inline std::string object(const std::string& tag, const std::string& type,
                          const std::string& inner = "") {
  return "<" + tag + " type='" + type + "'>" + inner + "</" + tag + ">";
}
inline std::string bsdf(const std::string& type, const std::string& inner = "") {
  return object("bsdf", type, inner);
}
inline std::string shape(const std::string& type, const std::string& inner = "") {
  return object("shape", type, inner);
}
inline std::string emitter(const std::string& type, const std::string& inner = "") {
  return object("emitter", type, inner);
}
inline std::string integrator(const std::string& type, const std::string& inner = "") {
  return object("integrator", type, inner);
}

/// A sensor of width x height pixels with a box filter, which makes pixels independent.
inline std::string sensor(const std::string& type, const std::string& operations, int width,
                          int height, int samples, const std::string& sampler = "independent",
                          const std::string& optics = "") {
  return object(
      "sensor", type,
      to_world(operations) + optics + object("sampler", sampler, integer("sample_count", samples)) +
          object("film", "hdrfilm",
                 integer("width", width) + integer("height", height) + "<rfilter type='box'/>"));
}

inline std::string scene(const std::string& contents) {
  return "<scene version='3.0.0'>" + contents + "</scene>";
}

}  // namespace kinome::test::xml
