#pragma once

#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/log_listener.h"
#include "kinome/sensor.h"
#include "kinome/texture.h"
#include "support/render.h"

/// Objects from files of Mitsuba 0.4 to 0.6.
namespace kinome::test::old_formats {

template <class T>
std::shared_ptr<T> object_of(const std::string& xml, const std::string& version) {
  const size_t tag_end = xml.find_first_of(" >");
  const std::string versioned =
      xml.substr(0, tag_end) + " version='" + version + "'" + xml.substr(tag_end);
  return std::dynamic_pointer_cast<T>(
      load_object_from_string(versioned, "old.xml", {}, registry()));
}
template <class T>
std::shared_ptr<T> old(const std::string& xml) {
  return object_of<T>(xml, "0.6.0");
}
inline std::unique_ptr<Scene> old_scene(const std::string& xml, const LoadOptions& options = {},
                                        const std::string& version = "0.6.0") {
  return load_scene_from_string("<scene version='" + version + "'>" + xml + "</scene>", "old.xml",
                                options, registry());
}

inline std::string warnings_of(const std::string& xml) {
  std::string all;
  const LogListener listener([&](const std::string& text) { all += text + "\n"; });
  old<Object>(xml);
  return all;
}

inline void expect_near(const Rgb& a, const Rgb& b, float tolerance = 1e-5f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << c;
}

inline SurfaceInteraction seen_from(const Vec3& wi) {
  SurfaceInteraction si;
  si.wi = glm::normalize(wi);
  return si;
}

}  // namespace kinome::test::old_formats
