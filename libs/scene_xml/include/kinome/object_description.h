#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinome/properties.h"

namespace kinome {

/// Description of a scene object by a program instead of XML: corresponds to `<bsdf type="…"
/// id="…">` with its contents. Errors in it refer to its `where`.
struct ObjectDescription {
  /// XML tag: "bsdf", "shape", …. "scene" describes a whole scene, "ref" refers to the object with
  /// the same `id`, and "spectrum" is a value by wavelengths whose `type` is its text ("400:0.1,
  /// 700:0.9").
  std::string tag = {};
  std::string type = {};  ///< name of the plugin
  std::string name = {};  ///< name of the parameter that it sets in the enclosing object, or ""
  std::string id = {};    ///< id, or ""
  Location where = {};    ///< origin, for error messages; its file may be any human-readable text

  struct Value {
    std::string name;
    Properties::Value value;
    Location where;
  };
  std::vector<Value> values = {};
  std::vector<ObjectDescription> parts = {};
};

}  // namespace kinome
