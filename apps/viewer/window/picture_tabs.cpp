#include "window/picture_tabs.h"

#include <imgui.h>

#include <filesystem>
#include <utility>

namespace kinome::viewer {
namespace {

/// Numbers of images from files, which must differ from those of the session's images.
constexpr uint64_t kFirstFileGeneration = uint64_t{1} << 62;
constexpr int kNoTab = -2;

}  // namespace

void PictureTabs::keep_displayed(PicturePointer live) {
  if (!live || !is_live()) return;
  add(std::move(live), "picture " + std::to_string(++num_kept_));
}

void PictureTabs::add(PicturePointer picture, std::string name) {
  tabs_.push_back({std::move(picture), std::move(name), ++num_tabs_});
}

void PictureTabs::open(const std::string& file) {
  auto picture = std::make_shared<Picture>();
  picture->image = read_picture(file);
  picture->crop = {0, 0, picture->image.width, picture->image.height};
  picture->generation = kFirstFileGeneration + static_cast<uint64_t>(num_tabs_);
  picture->is_final = true;
  add(std::move(picture), std::filesystem::path(file).filename().string());
  wanted_ = static_cast<int>(tabs_.size()) - 1;
}

void PictureTabs::select(int index) {
  if (index <= static_cast<int>(tabs_.size())) wanted_ = index - 1;
}

const PicturePointer& PictureTabs::shown(const PicturePointer& live) const {
  return is_live() ? live : tabs_[shown_].picture;
}

void PictureTabs::draw() {
  if (tabs_.empty()) {
    wanted_ = kNoTab;
    return;
  }
  if (!ImGui::BeginTabBar("tabs", ImGuiTabBarFlags_FittingPolicyScroll)) return;
  const int wanted = std::exchange(wanted_, kNoTab);
  const auto item = [&](int index, const char* name, bool* is_open) {
    const auto flags = wanted == index ? ImGuiTabItemFlags_SetSelected : 0;
    if (!ImGui::BeginTabItem(name, is_open, flags)) return;
    shown_ = index;
    ImGui::EndTabItem();
  };
  item(-1, "live", nullptr);
  int closed = -1;
  for (int i = 0; i < static_cast<int>(tabs_.size()); ++i) {
    bool is_open = true;
    const std::string label = tabs_[i].name + "###" + std::to_string(tabs_[i].id);
    item(i, label.c_str(), &is_open);
    if (!is_open) closed = i;
  }
  ImGui::EndTabBar();
  if (closed < 0) return;
  tabs_.erase(tabs_.begin() + closed);
  if (shown_ == closed) {
    shown_ = wanted_ = -1;
  } else if (shown_ > closed) {
    --shown_;
  }
}

}  // namespace kinome::viewer
