#pragma once

#include <gtest/gtest.h>

#include "kit/scenes/bsdf_blocks.h"

namespace kinome::test {

using check::BsdfQuestion;
using check::BsdfReply;
using check::reply_at;

/// Queries in a block, with memory for the replies. The destructor checks that nothing was written
/// past it.
class BsdfBlock : public check::BsdfBlock {
 public:
  explicit BsdfBlock(const std::vector<BsdfQuestion>& questions) : check::BsdfBlock(questions) {}
  ~BsdfBlock() { EXPECT_FALSE(is_overrun()) << "written past a column's padding"; }
};

}  // namespace kinome::test
