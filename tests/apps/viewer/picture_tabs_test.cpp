// Tests the tabs of kinome-view's images, without a window.

#include <gtest/gtest.h>
#include <imgui.h>

#include <memory>

#include "session/picture.h"
#include "window/picture_tabs.h"

namespace kinome::viewer::picture_tabs_test {
namespace {

class PictureTabsTest : public testing::Test {
 protected:
  PictureTabsTest() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {640, 480};
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  }
  ~PictureTabsTest() override { ImGui::DestroyContext(); }

  static PicturePointer make() { return std::make_shared<Picture>(); }

  /// Draws some frames, which select the requested tab.
  void draw() {
    for (int i = 0; i < 3; ++i) {
      ImGui::NewFrame();
      ImGui::Begin("picture");
      tabs_.draw();
      ImGui::End();
      ImGui::EndFrame();
    }
  }
  /// Returns the image of a tab; that of the tab before if there is no such tab.
  PicturePointer image_of(int tab, const PicturePointer& live) {
    tabs_.select(tab);
    draw();
    return tabs_.shown(live);
  }

  PictureTabs tabs_;
};

TEST_F(PictureTabsTest, KeepTheLiveImage) {
  const PicturePointer first = make(), second = make(), live = make();
  tabs_.keep_displayed(first);
  draw();
  EXPECT_TRUE(tabs_.is_live());
  tabs_.keep_displayed(second);
  EXPECT_EQ(image_of(0, live), live);
  EXPECT_EQ(image_of(1, live), first);
  EXPECT_EQ(image_of(2, live), second);
}

TEST_F(PictureTabsTest, DoNotKeepAKeptImageAgain) {
  const PicturePointer first = make(), live = make();
  tabs_.keep_displayed(first);
  EXPECT_EQ(image_of(1, live), first);
  tabs_.keep_displayed(live);
  EXPECT_EQ(image_of(2, live), first) << "there is a tab with the live image";
  EXPECT_EQ(image_of(0, live), live);
  tabs_.keep_displayed(live);
  EXPECT_EQ(image_of(2, first), live);
}

}  // namespace
}  // namespace kinome::viewer::picture_tabs_test
