#pragma once

#include <string>
#include <vector>

#include "session/picture.h"

namespace kinome::viewer {

/// Images that are kept beside the live one, each in a tab. For the window's thread only.
class PictureTabs {
 public:
  /// Keeps the live image in a new tab, named by a number. Does nothing if an image of a tab is
  /// displayed, because that one is kept already.
  void keep_displayed(PicturePointer live);
  /// Opens an EXR or PFM file in a new tab. Throws Error if it can't be read.
  void open(const std::string& file);
  /// Draws the tabs in the current ImGui window, if any image is kept.
  void draw();
  /// Returns the image to display: `live`, unless the tab of another image is selected.
  const PicturePointer& shown(const PicturePointer& live) const;
  /// Returns true if the live image is displayed.
  bool is_live() const { return shown_ < 0; }
  /// Selects a tab: 0 is the live image. Does nothing if there is no such tab.
  void select(int index);

 private:
  struct Tab {
    PicturePointer picture;
    std::string name;
    int id = 0;  ///< distinguishes tabs of the same name
  };

  void add(PicturePointer picture, std::string name);

  std::vector<Tab> tabs_;
  int shown_ = -1;   ///< index into tabs_; -1 for the live image
  int wanted_ = -2;  ///< index that select() or open() selects in the next frame; -2 if none
  int num_kept_ = 0, num_tabs_ = 0;
};

}  // namespace kinome::viewer
