#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinome/texture.h"

namespace kinome::test {

/// Parameters of the plugin `texture/probe`, each as its getter returned it.
class KINOME_EXPORT Probe : public Texture {
 public:
  bool boolean = false;
  int64_t integer = 0;
  float real = 0;
  std::string string;
  std::string file;  ///< if there is one
  Vec3 vector{0.f};
  Rgb color{0.f};
  Transform transform;
  std::shared_ptr<Texture> texture;
  std::shared_ptr<Texture> unbounded;
  std::shared_ptr<Texture> lamp;
  std::shared_ptr<Texture> optional;
  int choice = -1;
  std::vector<std::shared_ptr<Object>> objects;

  Rgb eval(const Vec2&) const override { return Rgb(0.f); }
  Rgb mean() const override { return Rgb(0.f); }
  float max() const override { return 0; }
  float min() const override { return 0; }
};

}  // namespace kinome::test
