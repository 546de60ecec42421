#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kinome/integrator.h"
#include "kinome/scene.h"

namespace kinome {

class Properties;

/// Groups of emitters whose light is rendered separately. Together, the groups contain all emitters
/// of a scene, each once, so that the colours of all groups add up to the image.
class KINOME_EXPORT LightGroups {
 public:
  static constexpr size_t kMaxGroups = 64;
  /// Group of the emitters that no other group names.
  static constexpr const char* kRest = "rest";
  /// Beginning of the names of the groups' channels: "lights.sun.R".
  static constexpr const char* kPrefix = "lights.";

  /// Creates no groups: light isn't divided.
  LightGroups() = default;
  /// Reads a parameter such as "sun: sky sun1; lamps: lamp1 lamp2": names of groups and the ids of
  /// their emitters. "all" makes a group of each emitter that has an id, with '_' for each '.', '/'
  /// and '=' in its name. Throws Error if the text is malformed.
  LightGroups(const Properties& props, const std::string& parameter);

  /// Finds the groups' emitters among all of the scene's, by their own ids or those of their
  /// shapes. Throws Error, at the parameter, if an id is unknown, if two groups have the same name,
  /// or if there are too many groups.
  /// Must be called before the functions below. Indirect emitters are ignored. Returns false if the
  /// groups are the same as before.
  bool set_emitters(std::span<const Emitter* const> emitters);

  bool is_empty() const { return !is_given_; }
  /// Names in the order of the parameter, then kRest if some emitters are in no other group.
  const std::vector<std::string>& names() const { return names_; }
  /// Names of the channels of all groups: "lights.NAME.R", ".G" and ".B" of each.
  std::vector<std::string> channels() const;
  /// Throws Error at the parameter: `message` follows its name.
  [[noreturn]] void fail(const std::string& message) const;
  /// Returns the index into names() of an emitter's group. The emitter must be one of those of
  /// set_emitters().
  uint32_t group_of(const Emitter& emitter) const;

 private:
  struct Group {
    std::string name;
    std::vector<std::string> ids;
  };
  void parse(const std::string& text);
  std::vector<Group> own_groups(const std::vector<std::string>& ids) const;

  bool is_given_ = false;
  bool is_all_ = false;
  Location where_;
  std::string parameter_;
  std::vector<Group> groups_;  ///< as written; empty for "all"
  std::vector<std::string> names_;
  std::map<std::string, uint32_t> index_of_id_;  ///< indices into names_ of emitters in groups
};

/// Returns the id of an emitter or, if it has none, that of its shape.
KINOME_EXPORT const std::string& emitter_id(const Emitter& emitter);

/// Interface of integrators that refer to emitters by their ids.
class KINOME_EXPORT RefersToEmitters {
 public:
  virtual ~RefersToEmitters();
  /// Called with all emitters of a scene, in any order, before Integrator::layers(). May be called
  /// again after the scene has been edited. Throws Error if an emitter is missing.
  virtual void set_emitters(std::span<const Emitter* const> emitters) = 0;
};

/// Calls set_emitters() if the scene's integrator refers to emitters.
KINOME_EXPORT void set_emitters_of_integrator(const Scene::Contents& contents);

/// Integrator that can divide the light of the film's layer 0 by light group: the layer's values
/// are LightGroups::channels(), whose sum is the colour.
class KINOME_EXPORT GroupingIntegrator : public Integrator {
 public:
  ~GroupingIntegrator() override;
  /// Throws Error, by LightGroups::fail(), if the light of a scene with these emitters can't be
  /// divided. Called with all emitters, as RefersToEmitters::set_emitters().
  virtual void check_light_groups(const LightGroups& /*groups*/,
                                  std::span<const Emitter* const> /*emitters*/) const {}
  /// Sets the groups, after their set_emitters() and check_light_groups().
  virtual void set_light_groups(LightGroups groups) { groups_ = std::move(groups); }
  std::vector<std::vector<std::string>> layers() const override { return {groups_.channels()}; }

 protected:
  const LightGroups& light_groups() const { return groups_; }

 private:
  LightGroups groups_;
};

}  // namespace kinome
