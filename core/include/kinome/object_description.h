#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinome/properties.h"

namespace kinome {

/// An object of a scene as a program describes it, in place of XML: what `<bsdf type="…" id="…">` and
/// all that it contains would say. Errors in it name its `where`.
struct ObjectDescription {
  /// "bsdf", "shape", …: the tag; "scene" for a whole one, "ref" for what has the same `id`, and
  /// "spectrum" for a value by wavelengths, whose `type` is its text ("400:0.1, 700:0.9").
  std::string tag = {};
  std::string type = {};  ///< the plugin's name
  std::string name = {};  ///< of the parameter that it is of the object around it, or ""
  std::string id = {};    ///< or ""
  Location where = {};    ///< its file may be any text that says to people where it stands

  struct Value {
    std::string name;
    Properties::Value value;
    Location where;
  };
  std::vector<Value> values = {};
  std::vector<ObjectDescription> parts = {};
};

}  // namespace kinome
