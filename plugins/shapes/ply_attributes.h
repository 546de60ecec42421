#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/shape.h"
#include "ply_header.h"

/// Attributes of a PLY file's vertices and faces that aren't part of the mesh itself.
namespace kinome {

/// Properties that make up a MeshAttribute, in order.
struct NamedNumbers {
  std::string name;
  std::vector<int> properties;
};

/// Finds attributes by Mitsuba 3's naming rules. r, g, b (and a), or red, green, blue (and alpha),
/// are PREFIXcolor. Consecutive properties NAME_x, NAME_y … are PREFIXNAME, and so are _0, _1 … and
/// _1, _2 …. NAME_r, NAME_g, NAME_b are PREFIXNAME_color. Such sequences are ignored unless they
/// have one or three properties, and so is a repeated name.
inline std::vector<NamedNumbers> find_attributes(const PlyElement& element,
                                                 const std::string& prefix) {
  std::vector<NamedNumbers> found;
  const auto add_color = [&](std::initializer_list<const char*> names, const char* alpha) {
    NamedNumbers color{prefix + "color", {}};
    for (const char* name : names) color.properties.push_back(element.find_scalar(name));
    if (*std::min_element(color.properties.begin(), color.properties.end()) < 0) return false;
    if (const int a = element.find_scalar(alpha); a >= 0) color.properties.push_back(a);
    found.push_back(std::move(color));
    return true;
  };
  if (!add_color({"r", "g", "b"}, "a")) add_color({"red", "green", "blue"}, "alpha");

  constexpr std::string_view kSequences[] = {"xyzw", "rgba", "0123", "1234"};
  const auto part_at = [&](size_t i) {  // NAME and postfix; '\0' if the property has no postfix
    const std::string_view name = element.properties[i].name;
    const size_t at = element.properties[i].is_list ? std::string_view::npos : name.rfind('_');
    return at == std::string_view::npos || at + 2 != name.size()
               ? std::pair(name, '\0')
               : std::pair(name.substr(0, at), name[at + 1]);
  };
  std::set<std::string_view> known;
  for (size_t i = 0; i < element.properties.size();) {
    const auto [name, postfix] = part_at(i);
    const auto* const sequence = std::find_if(
        std::begin(kSequences), std::end(kSequences),
        [letter = postfix](std::string_view s) { return letter != '\0' && s.front() == letter; });
    size_t end = i + 1;
    if (sequence == std::end(kSequences) || known.count(name)) {
      i = end;
      continue;
    }
    while (end < element.properties.size() && part_at(end).first == name &&
           part_at(end).second != '\0') {
      ++end;
    }
    bool is_sequence = end - i == 1 || end - i == 3;
    NamedNumbers attribute{prefix + std::string(name) + (*sequence == "rgba" ? "_color" : ""), {}};
    for (size_t k = i; k < end; ++k) {
      is_sequence = is_sequence && part_at(k).second == (*sequence)[k - i];
      attribute.properties.push_back(static_cast<int>(k));
    }
    if (is_sequence) {
      found.push_back(std::move(attribute));
      known.insert(name);
    }
    i = end;
  }
  return found;
}

/// Collects the values of the requested attributes.
class AttributeReader {
 public:
  AttributeReader(const PlyElement& element, const std::string& prefix,
                  const std::vector<std::string>& requested)
      : slots_(element.properties.size()) {
    for (const NamedNumbers& found : find_attributes(element, prefix)) {
      if (std::find(requested.begin(), requested.end(), found.name) == requested.end()) continue;
      const auto size = static_cast<uint32_t>(found.properties.size());
      for (uint32_t k = 0; k < size; ++k) {
        slots_[static_cast<size_t>(found.properties[k])] = {static_cast<int>(all_.size()), k};
      }
      all_.push_back({found.name, size, {}});
      all_.back().values.reserve(element.count * size);
    }
  }

  bool is_used(size_t property) const { return slots_[property].attribute >= 0; }
  /// Begins a vertex or face: adds space for its values.
  void begin_item() {
    for (MeshAttribute& a : all_) a.values.resize(a.values.size() + a.size, 0.f);
  }
  /// Sets the value of a property for which is_used() is true.
  void put(size_t property, float value) {
    MeshAttribute& a = all_[static_cast<size_t>(slots_[property].attribute)];
    a.values[a.values.size() - a.size + slots_[property].number] = value;
  }
  /// Ends a face: repeats its values for `copies` triangles, which may be 0.
  void repeat(size_t copies) {
    for (MeshAttribute& a : all_) {
      const std::vector<float> item(a.values.end() - a.size, a.values.end());
      if (copies == 0) a.values.resize(a.values.size() - a.size);
      for (size_t k = 1; k < copies; ++k) {
        a.values.insert(a.values.end(), item.begin(), item.end());
      }
    }
  }
  void move_to(TriangleMesh& mesh) {
    for (MeshAttribute& a : all_) mesh.attributes.push_back(std::move(a));
    all_.clear();
  }

 private:
  struct Slot {
    int attribute = -1;
    uint32_t number = 0;
  };
  std::vector<Slot> slots_;  ///< one per property
  std::vector<MeshAttribute> all_;
};

}  // namespace kinome
