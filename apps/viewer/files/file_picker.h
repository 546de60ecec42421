#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "files/file_list.h"

namespace kinome::viewer {

/// A dialog in which the user chooses a file, with the mouse or the keyboard. For the window's
/// thread only.
class FilePicker {
 public:
  enum class Purpose { kOpen, kSave };

  /// Opens the dialog. `title` is a literal, and unique among the dialogs. `start` is a folder, or
  /// a file that is selected at first. `extensions` are as for list_files(); a file to save gets
  /// the first one by default.
  void open(const char* title, Purpose purpose, std::vector<std::string> extensions,
            const std::filesystem::path& start);
  /// Draws the dialog if it is open. Returns the chosen file, once. Must be called once per frame,
  /// always within the same ImGui window.
  std::optional<std::string> draw();

 private:
  void go_to(const std::filesystem::path& folder);
  void set_text(std::string text);
  void draw_path();
  /// Draws the list. Returns true if an entry was double-clicked.
  bool draw_list(float height);
  /// Moves the selection by the arrow keys.
  void move_selection();
  /// Enters the chosen folder, or returns the chosen file.
  std::optional<std::string> accept();

  const char* title_ = "";
  Purpose purpose_ = Purpose::kOpen;
  std::vector<std::string> extensions_;
  std::filesystem::path folder_;
  FileList list_;
  std::vector<FileEntry> shown_;  ///< entries that match the text
  std::string text_;              ///< name that was typed or selected
  int selected_ = -1;             ///< index into shown_; -1 if none
  bool is_typed_ = false;         ///< the text was typed after the last selection
  int text_version_ = 0;          ///< changes if text_ is set; an active ImGui widget keeps its text
  bool is_opening_ = false, wants_focus_ = false, scrolls_ = false;
  bool asks_to_replace_ = false;  ///< the file exists already; accept() again replaces it
};

}  // namespace kinome::viewer
