#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "session/render_session.h"

namespace kinome::viewer {

/// Path of the object that a parameter with this path is of.
std::string object_of(const std::string& path);

/// Files beside the one of a parameter that end as it does, by name; itself among them. `scene`:
/// the scene's file, by whose folder names are meant.
std::vector<std::string> files_beside(const std::string& file, const std::string& scene);

/// By the ending of its name.
bool is_image(const std::string& file);
/// Images in the scene's folder, and beside those that the scene reads, as it would name them.
std::vector<std::string> image_files(const SceneInfo& info);

/// Widgets of a scene's parameters, each of its type, and what was entered until the scene has it.
/// Of the window's thread.
class ParameterWidgets {
 public:
  /// Once a frame, before any are drawn.
  void begin(const std::shared_ptr<const SceneInfo>& info);
  /// A widget by the name of the parameter without its object's path; sets what is entered.
  void draw(RenderSession& session, const SceneParameter& parameter);
  /// All parameters of the objects with these paths, beneath their names. False: there are none.
  bool draw_all(RenderSession& session, const SceneInfo& info,
                const std::vector<std::string>& objects);
  /// What it is, or what was entered for it.
  std::optional<EditedValue> value(const SceneParameter& parameter) const;
  /// Sets it, and shows it so from now on.
  void set(RenderSession& session, const std::string& path, EditedValue value, bool is_moving);

 private:
  void draw_name(RenderSession& session, const SceneInfo& info, const std::string& object,
                 const std::string& plugin);
  void draw_textured(RenderSession& session, const SceneInfo& info,
                     const SceneParameter& parameter);
  /// What is offered for a parameter that has no value; nullopt: it can't be entered.
  static std::optional<EditedValue> first_value(const SceneParameter& parameter);
  /// Its name, without the object's.
  static std::string last_name(const std::string& path);
  /// Place, turn and size.
  bool edit_transform(const SceneParameter& parameter, Transform& transform);
  void draw_menu(RenderSession& session, const SceneParameter& parameter);
  /// Files to choose from; what is to be made of the one that is chosen, if any.
  std::optional<std::string> choose_image(const char* title);
  bool edit(const SceneParameter& parameter, const char* name, EditedValue& value);
  bool edit_file(const char* name, std::string& file);
  bool edit_text(const SceneParameter& parameter, const char* name, std::string& text);

  std::shared_ptr<const SceneInfo> info_;
  std::map<std::string, EditedValue> entered_;
  uint64_t entered_number_ = 0;               ///< RenderSession::set's, of the last one
  std::map<std::string, std::string> typed_;  ///< texts that are being typed
  /// What an angle of 0 and a size of 1 stand for, of each transform.
  struct Turn {
    Mat4 base{1.f}, now{1.f};
    Vec3 degrees{0.f};
    float size = 1;
  };
  std::map<std::string, Turn> turns_;
  std::vector<std::string> images_;  ///< while a menu shows them
  std::string file_;                 ///< that is being typed into a menu
};

}  // namespace kinome::viewer
