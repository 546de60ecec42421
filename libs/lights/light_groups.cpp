#include "kinome/light_groups.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "kinome/properties.h"

namespace kinome {
namespace {

/// Splits a text at each of the separators, and drops empty parts.
std::vector<std::string> parts_of(std::string_view text, std::string_view separators) {
  std::vector<std::string> parts;
  for (size_t at = 0; (at = text.find_first_not_of(separators, at)) != std::string_view::npos;) {
    const size_t end = std::min(text.find_first_of(separators, at), text.size());
    parts.emplace_back(text.substr(at, end - at));
    at = end;
  }
  return parts;
}

constexpr std::string_view kSpaces = ", \t\r\n";

/// Characters that names of groups must not contain: '.' separates the layers of an EXR file.
constexpr std::string_view kReservedCharacters = "./=";

/// Returns the name of an emitter's own group.
std::string name_of_own_group(std::string id) {
  for (char& c : id) {
    if (kReservedCharacters.find(c) != std::string_view::npos) c = '_';
  }
  return id;
}

/// Collects the emitters of a shape and of its parts.
void add_emitters_of(const Shape& shape, std::vector<const Emitter*>& emitters) {
  if (shape.emitter()) emitters.push_back(shape.emitter());
  for (const auto& part : shape.parts()) add_emitters_of(*part, emitters);
}

void add_with_children(const Emitter& emitter, std::vector<const Emitter*>& emitters) {
  emitters.push_back(&emitter);
  for (const auto& child : emitter.children()) add_with_children(*child, emitters);
}

}  // namespace

const std::string& emitter_id(const Emitter& emitter) {
  return emitter.id().empty() && emitter.shape() ? emitter.shape()->id() : emitter.id();
}

LightGroups::LightGroups(const Properties& props, const std::string& parameter)
    : parameter_(parameter) {
  if (!props.has(parameter)) return;
  is_given_ = true;
  where_ = props.error(parameter, "").where();
  parse(props.string(parameter));
}

void LightGroups::fail(const std::string& message) const {
  throw Error(where_, "'" + parameter_ + "' " + message);
}

void LightGroups::parse(const std::string& text) {
  if (parts_of(text, kSpaces) == std::vector<std::string>{"all"}) {
    is_all_ = true;
    return;
  }
  for (const std::string& part : parts_of(text, ";")) {
    if (parts_of(part, kSpaces).empty()) continue;
    const size_t colon = part.find(':');
    const std::vector<std::string> names = parts_of(part.substr(0, colon), kSpaces);
    const std::vector<std::string> ids =
        colon == std::string::npos ? names : parts_of(part.substr(colon + 1), kSpaces);
    if (colon == std::string::npos || names.size() != 1 || ids.empty()) {
      fail("must be 'all', or groups such as 'sun: sky sun1; lamps: lamp1 lamp2', got '" + part +
           "'");
    }
    if (names[0].find_first_of(kReservedCharacters) != std::string::npos) {
      fail("has the group '" + names[0] + "': a name must not contain '.', '/' or '='");
    }
    const bool is_taken = std::any_of(groups_.begin(), groups_.end(),
                                      [&](const Group& group) { return group.name == names[0]; });
    if (is_taken) fail("names the group '" + names[0] + "' twice");
    groups_.push_back({names[0], ids});
  }
  if (groups_.empty()) fail("must be 'all', or name at least one group");
}

/// Returns a group for each of these emitters.
std::vector<LightGroups::Group> LightGroups::own_groups(const std::vector<std::string>& ids) const {
  std::vector<Group> groups;
  std::map<std::string, std::string> id_of_name;
  for (const std::string& id : ids) {
    const std::string name = name_of_own_group(id);
    if (const auto [other, is_new] = id_of_name.emplace(name, id); !is_new) {
      fail(fmt::format("has two groups '{}': of the emitter '{}' and of '{}': rename one of them",
                       name, other->second, id));
    }
    groups.push_back({name, {id}});
  }
  return groups;
}

bool LightGroups::set_emitters(std::span<const Emitter* const> emitters) {
  if (is_empty()) return false;
  std::vector<std::string> ids;
  std::set<std::string> known;
  for (const Emitter* const emitter : emitters) {
    const std::string& id = emitter_id(*emitter);
    if (!emitter->is_indirect() && !id.empty() && known.insert(id).second) ids.push_back(id);
  }
  const std::vector<Group> groups = is_all_ ? own_groups(ids) : groups_;
  std::vector<std::string> names;
  std::map<std::string, uint32_t> index_of_id;
  for (const Group& group : groups) {
    for (const std::string& id : group.ids) {
      if (!known.contains(id)) {
        fail("names the unknown emitter '" + id + "'" + did_you_mean(nearest_name(id, ids)));
      }
      if (!index_of_id.emplace(id, static_cast<uint32_t>(names.size())).second) {
        fail("names the emitter '" + id + "' twice");
      }
    }
    names.push_back(group.name);
  }
  const bool has_rest =
      std::any_of(emitters.begin(), emitters.end(), [&](const Emitter* const emitter) {
        return !emitter->is_indirect() && !index_of_id.contains(emitter_id(*emitter));
      });
  if (has_rest && std::find(names.begin(), names.end(), kRest) != names.end()) {
    fail(
        is_all_
            ? "has two groups 'rest': of the emitter 'rest', and of the emitters without an id: "
              "rename the emitter"
            : "has two groups 'rest': the one that it names, and that of the emitters in no group: "
              "rename the group");
  }
  if (names.empty() || has_rest) names.emplace_back(kRest);
  if (names.size() > kMaxGroups) {
    fail("makes " + std::to_string(names.size()) + " groups, but at most " +
         std::to_string(kMaxGroups) + " are supported");
  }
  // Equal names aren't replaced, because a render may read them while its scene is edited.
  if (names == names_) return false;
  names_ = std::move(names);
  index_of_id_ = std::move(index_of_id);
  return true;
}

std::vector<std::string> LightGroups::channels() const {
  std::vector<std::string> channels;
  for (const std::string& name : names_) {
    for (const char* const component : {".R", ".G", ".B"}) {
      channels.push_back(kPrefix + name + component);
    }
  }
  return channels;
}

uint32_t LightGroups::group_of(const Emitter& emitter) const {
  const auto found = index_of_id_.find(emitter_id(emitter));
  if (found != index_of_id_.end()) return found->second;
  const auto rest = std::find(names_.begin(), names_.end(), kRest);
  if (rest == names_.end()) throw std::logic_error("LightGroups::group_of: unknown emitter");
  return static_cast<uint32_t>(rest - names_.begin());
}

RefersToEmitters::~RefersToEmitters() = default;
GroupingIntegrator::~GroupingIntegrator() = default;

void set_emitters_of_integrator(const Scene::Contents& contents) {
  auto* const integrator = dynamic_cast<RefersToEmitters*>(contents.integrator.get());
  if (!integrator) return;
  std::vector<const Emitter*> emitters;
  for (const auto& emitter : contents.emitters) add_with_children(*emitter, emitters);
  for (const auto& shape : contents.shapes) add_emitters_of(*shape, emitters);
  integrator->set_emitters(emitters);
}

}  // namespace kinome
