#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "session/render_session.h"

namespace kinome::viewer {

/// Returns the path of the object that has the parameter with this path.
std::string object_of(const std::string& path);

/// Returns the paths of objects, followed by those of the objects that are nested in them now, of
/// their textures and their volumes. Leaves out paths of objects that don't exist any more.
std::vector<std::string> with_parts(const SceneInfo& info, const std::vector<std::string>& objects);

/// Returns the files in the folder of `file` with its extension, including `file`, sorted by name.
/// For all but .ply files, also returns images. Paths are relative to the folder of `scene`, the
/// scene file.
std::vector<std::string> files_beside(const std::string& file, const std::string& scene);

/// Returns true if the file's extension is that of an image.
bool is_image(const std::string& file);
/// Returns the images in the scene's folder and in the folders of images that the scene uses, with
/// paths as in the scene file.
std::vector<std::string> image_files(const SceneInfo& info);

/// Widgets for the parameters of a scene, by their types. Entered values are kept until the scene
/// has applied them. For the window's thread only.
class ParameterWidgets {
 public:
  /// Must be called once per frame, before any widget is drawn.
  void begin(const std::shared_ptr<const SceneInfo>& info);
  /// Draws a widget, labelled by the last part of the parameter's path. Sets the value that the
  /// user enters.
  void draw(RenderSession& session, const SceneParameter& parameter);
  /// Draws all parameters of these objects below the objects' names. Returns false if none of the
  /// objects exists.
  bool draw_all(RenderSession& session, const SceneInfo& info,
                const std::vector<std::string>& objects);
  /// Returns the value that was entered last, or else the value in the scene.
  std::optional<EditedValue> value(const SceneParameter& parameter) const;
  /// Sets a parameter of the session, and shows the new value at once.
  void set(RenderSession& session, const std::string& path, EditedValue value, bool is_moving);

 private:
  void draw_name(RenderSession& session, const SceneInfo& info, const std::string& object,
                 const std::string& plugin);
  void draw_textured(RenderSession& session, const SceneInfo& info,
                     const SceneParameter& parameter);
  /// Returns an initial value for a parameter without a value; nullopt if the user can't enter one.
  static std::optional<EditedValue> first_value(const SceneParameter& parameter);
  /// Returns the parameter's name without the path of its object.
  static std::string last_name(const std::string& path);
  /// Edits position, rotation and size.
  bool edit_transform(const SceneParameter& parameter, Transform& transform);
  void draw_menu(RenderSession& session, const SceneParameter& parameter);
  /// Draws a menu of image files. Returns the selected file, if any.
  std::optional<std::string> choose_image(const char* title);
  bool edit(const SceneParameter& parameter, const char* name, EditedValue& value);
  bool edit_file(const char* name, std::string& file);
  bool edit_text(const SceneParameter& parameter, const char* name, std::string& text);

  std::shared_ptr<const SceneInfo> info_;
  std::map<std::string, EditedValue> entered_;
  uint64_t entered_number_ = 0;               ///< number of the last request
  std::map<std::string, std::string> typed_;  ///< unfinished text
  /// Edits of a transform.
  struct Turn {
    Mat4 base{1.f};  ///< at angles of 0 and a size of 1
    Mat4 now{1.f};
    Vec3 degrees{0.f};
    float size = 1;
  };
  std::map<std::string, Turn> turns_;
  std::vector<std::string> images_;  ///< image files in the open menu
  std::string file_;                 ///< unfinished file name in a menu
};

}  // namespace kinome::viewer
