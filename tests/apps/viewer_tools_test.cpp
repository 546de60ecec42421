// Tests parts of the viewer without its window: outlines, handles and file lists.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "files/file_list.h"
#include "handles/handle_drag.h"
#include "picture/outline.h"

namespace kinome::viewer::viewer_tools_test {
namespace {

namespace fs = std::filesystem;

// ---- outlines

/// Returns the outline of a disk around the origin.
Outline outline_of_disk(const CellGrid& grid, float radius) {
  std::vector<bool> is_inside;
  for (int y = 0; y < grid.rows; ++y) {
    for (int x = 0; x < grid.columns; ++x) {
      is_inside.push_back(glm::length(grid.centre(x, y)) < radius);
    }
  }
  return outline_of(is_inside, grid);
}

TEST(Outline, FollowsTheEdgeOfADisk) {
  const CellGrid grid{Vec2(-30, -25), 0.5f, 120, 100};
  const Outline outline = outline_of_disk(grid, 20);
  ASSERT_GT(outline.points.size(), 100u);
  EXPECT_EQ(outline.points.size(), outline.lines.size()) << "not a single closed line";
  double length = 0;
  for (const Outline::Line& line : outline.lines) {
    length += glm::distance(outline.points[line.from], outline.points[line.to]);
  }
  // Smoothing removes the steps of cells, which would lengthen the line by a few percent.
  EXPECT_NEAR(length, 2 * M_PI * 20, 0.02 * 2 * M_PI * 20);
  for (const Vec2& p : outline.points) EXPECT_NEAR(glm::length(p), 20, 0.5);
}

TEST(Outline, EachPointJoinsTwoLines) {
  // All 16 cases of marching squares, and shapes that touch at corners.
  const CellGrid grid{Vec2(0), 1, 40, 40};
  std::vector<bool> is_inside(1600);
  uint32_t random = 1;
  for (int y = 1; y < 39; ++y) {
    for (int x = 1; x < 39; ++x) {
      random = random * 1664525 + 1013904223;
      is_inside[y * 40 + x] = random >> 31;
    }
  }
  const Outline outline = outline_of(is_inside, grid);
  std::vector<int> count(outline.points.size());
  for (const Outline::Line& line : outline.lines) {
    ++count[line.from];
    ++count[line.to];
  }
  for (const int lines : count) EXPECT_EQ(lines, 2);
}

TEST(Outline, TheEdgeOfTheGridIsNotDrawn) {
  const CellGrid grid{Vec2(0), 1, 8, 6};
  EXPECT_TRUE(outline_of(std::vector<bool>(48, true), grid).lines.empty());
  EXPECT_TRUE(outline_of(std::vector<bool>(48, false), grid).lines.empty());
  // A shape that the image cuts off has an open outline.
  std::vector<bool> left(48);
  for (size_t i = 0; i < left.size(); ++i) left[i] = i % 8 < 3;
  const Outline outline = outline_of(left, grid);
  EXPECT_EQ(outline.lines.size(), 5u);
  for (const Vec2& p : outline.points) EXPECT_FLOAT_EQ(p.x, 3);
}

// ---- handles

/// Returns a camera ray from (3, 2, 10) through a point.
Ray ray_to(const Vec3& point) {
  const Vec3 origin(3, 2, 10);
  return {origin, glm::normalize(point - origin)};
}

const Vec3 kPivot(1, 2, 3), kForward(0, 0, -1);

void expect_point(const std::optional<Mat4>& move, const Vec3& from, const Vec3& to) {
  ASSERT_TRUE(move);
  const Vec3 p(*move * glm::vec4(from, 1.f));
  EXPECT_NEAR(glm::distance(p, to), 0, 1e-4f) << p.x << " " << p.y << " " << p.z;
}

TEST(Handles, MoveAlongAxes) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto handle = static_cast<Handle>(axis);
    EXPECT_EQ(axis_of(handle), axis);
    Vec3 way(0.f);
    way[axis] = 0.75f;
    // The mouse grabs the arrow away from the pivot, and the object moves by the same length.
    const auto move =
        dragged(handle, kPivot, kForward, ray_to(kPivot + way), ray_to(kPivot + 3.f * way));
    expect_point(move, kPivot, kPivot + 2.f * way);
    expect_point(move, Vec3(0), 2.f * way);
  }
  // A mouse beside the axis moves to the nearest point.
  const auto move = dragged(Handle::kMoveY, kPivot, kForward, ray_to(kPivot),
                            ray_to(kPivot + Vec3(0.3f, 0, 0)));
  expect_point(move, kPivot, kPivot);
}

TEST(Handles, MoveInPlanes) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto handle = static_cast<Handle>(static_cast<int>(Handle::kMoveYZ) + axis);
    EXPECT_EQ(axis_of(handle), axis);
    Vec3 way(0.5f, -0.25f, 0.125f);
    way[axis] = 0;
    // The plane of y is seen from its side.
    const Vec3 pivot = axis == 1 ? kPivot - Vec3(0, 1, 0) : kPivot;
    const auto move = dragged(handle, pivot, kForward, ray_to(pivot), ray_to(pivot + way));
    expect_point(move, pivot, pivot + way);
  }
  const Vec3 way(0.5f, -0.25f, 0);
  expect_point(dragged(Handle::kMoveInView, kPivot, kForward, ray_to(kPivot), ray_to(kPivot + way)),
               kPivot, kPivot + way);
}

TEST(Handles, TurnAroundThePivot) {
  const auto at = [](float degrees, float radius) {
    const float angle = glm::radians(degrees);
    return kPivot + radius * Vec3(std::cos(angle), std::sin(angle), 0);
  };
  // The distance of the mouse doesn't matter, and the angle may pass 180 degrees.
  const auto turn =
      dragged(Handle::kTurnZ, kPivot, kForward, ray_to(at(170, 1)), ray_to(at(200, 2)));
  expect_point(turn, kPivot, kPivot);
  expect_point(turn, kPivot + Vec3(1, 0, 0.5f), at(30, 1) + Vec3(0, 0, 0.5f));
  EXPECT_EQ(axis_of(Handle::kTurnZ), 2);
}

TEST(Handles, RaysAlongAPlaneOrAnAxisDoNothing) {
  const Ray along({0, 0, 10}, {0, 0, -1}), other({0.1f, 0, 10}, {0, 0, -1});
  EXPECT_FALSE(dragged(Handle::kMoveZ, Vec3(0), kForward, along, other));
  EXPECT_FALSE(dragged(Handle::kTurnX, Vec3(0), kForward, along, other));
  EXPECT_FALSE(dragged(Handle::kMoveZX, Vec3(0), kForward, along, other));
  // The plane is behind the camera.
  EXPECT_FALSE(dragged(Handle::kMoveXY, Vec3(0, 0, 20), kForward, along, other));
}

// ---- file lists

class FileLists : public testing::Test {
 protected:
  void SetUp() override {
    // Tests run at the same time, in processes of their own.
    folder_ = fs::path(testing::TempDir()) / ("viewer_file_lists-" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "textures");
    fs::create_directory(folder_ / ".hidden");
    for (const char* const name : {"scene.xml", "Alpha.EXR", "beta.exr", ".secret.exr", "x.txt"}) {
      std::ofstream(folder_ / name) << "x";
    }
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(FileLists, HaveFoldersFirstAndOnlyTheExtensions) {
  const FileList list = list_files(folder_, {".exr", ".xml"});
  EXPECT_EQ(list.fault, "");
  const std::vector<FileEntry> expected = {
      {"textures", true}, {"Alpha.EXR", false}, {"beta.exr", false}, {"scene.xml", false}};
  EXPECT_EQ(list.entries, expected);
  EXPECT_EQ(list_files(folder_, {}).entries.size(), 5u);
  const FileList missing = list_files(folder_ / "nowhere", {});
  EXPECT_TRUE(missing.entries.empty());
  EXPECT_NE(missing.fault.find("nowhere"), std::string::npos);
}

TEST_F(FileLists, AreRestrictedByPartsOfNames) {
  const auto all = list_files(folder_, {".exr"}).entries;
  ASSERT_EQ(matching(all, "ALPHA").size(), 1u);
  EXPECT_EQ(matching(all, "ALPHA")[0].name, "Alpha.EXR");
  EXPECT_EQ(matching(all, "").size(), all.size());
  EXPECT_TRUE(matching(all, "gamma").empty());
}

TEST_F(FileLists, TypedPathsAreUnderstood) {
  EXPECT_EQ(path_in("/a/b", ""), "/a/b");
  EXPECT_EQ(path_in("/a/b", ".."), "/a");
  EXPECT_EQ(path_in("/a/b", "c/d.exr"), "/a/b/c/d.exr");
  EXPECT_EQ(path_in("/a/b", "/c/"), "/c");
  EXPECT_EQ(path_in("/", ".."), "/");
  EXPECT_EQ(with_extension("/a/b", {".exr", ".png"}), "/a/b.exr");
  EXPECT_EQ(with_extension("/a/b.PNG", {".exr", ".png"}), "/a/b.PNG");
  EXPECT_EQ(with_extension("/a/b.jpg", {".exr", ".png"}), "/a/b.jpg.exr");
}

}  // namespace
}  // namespace kinome::viewer::viewer_tools_test
