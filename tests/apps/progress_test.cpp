/// Tests the progress text of a render.
#include "render/progress.h"

#include <gtest/gtest.h>

namespace kinome::app::progress_test {
namespace {

TEST(ProgressText, ReportsTheRemainingTime) {
  EXPECT_EQ(progress_text(0.25, 0.25, 10).percent, 25);
  EXPECT_EQ(progress_text(0.25, 0.25, 10).left, ", 30 s left");
  EXPECT_EQ(progress_text(0.1, 0.1, 60).left, ", 9 min 00 s left");
  EXPECT_EQ(progress_text(0.1, 0.1, 6000).left, ", 15 h 00 min left");
}

TEST(ProgressText, LeavesOutTheTimeBeforeTheFirstTile) {
  EXPECT_EQ(progress_text(0.5, 0.1, 10).left, ", 50 s left");
}

TEST(ProgressText, HasNoEstimateFromTheFirstTiles) {
  EXPECT_EQ(progress_text(0.0001, 0, 0).left, "");
  EXPECT_EQ(progress_text(0.0002, 0.0001, 6).left, "");  // 16 hours
  EXPECT_NE(progress_text(0.02, 0.0199, 1).left, "");
  EXPECT_NE(progress_text(0.0002, 0.0001, 11).left, "");
}

TEST(ProgressText, IsNeverDoneWithTimeLeft) {
  for (const double fraction : {0.994, 0.996, 0.99999, 1 - 1e-15}) {
    EXPECT_EQ(progress_text(fraction, fraction, 100).percent, 99) << fraction;
    EXPECT_NE(progress_text(fraction, fraction, 100).left, "") << fraction;
  }
  EXPECT_EQ(progress_text(1, 1, 100).percent, 100);
  EXPECT_EQ(progress_text(1, 1, 100).left, "");
}

}  // namespace
}  // namespace kinome::app::progress_test
