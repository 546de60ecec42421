#pragma once

#include <gtest/gtest.h>

#include "check/bsdf_blocks.h"

namespace kinome::test {

using check::BsdfQuestion;
using check::BsdfReply;
using check::reply_at;

/// Questions in a block, and room for answers, which is looked at in the end.
class BsdfBlock : public check::BsdfBlock {
 public:
  explicit BsdfBlock(const std::vector<BsdfQuestion>& questions) : check::BsdfBlock(questions) {}
  ~BsdfBlock() { EXPECT_FALSE(is_overrun()) << "written behind a column's padding"; }
};

}  // namespace kinome::test
