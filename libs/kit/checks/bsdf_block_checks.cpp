// Checks that the block functions of BSDFs agree with those for single points.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/instruction_set.h"
#include "kit/scenes/bsdf_blocks.h"
#include "kit/scenes/bsdf_points.h"
#include "kit/statistics/random.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

std::vector<BsdfQuestion> random_questions(size_t count, Random& random) {
  std::vector<BsdfQuestion> questions(count);
  for (size_t i = 0; i < count; ++i) {
    BsdfQuestion& q = questions[i];
    q.si = seen_from(random.direction());
    q.si.uv = random.unit2();
    q.si.p_error = 1e-6f;
    q.wo = direction_for(q.si.wi, static_cast<int>(i), random);
    q.u1 = random.unit();
    q.u2 = random.unit2();
  }
  return questions;
}

bool is_near(const Vec3& a, const Vec3& b, float scale) {
  return max_component(glm::abs(a - b)) <=
         2e-3f * std::max(max_component(glm::abs(a)), max_component(glm::abs(b))) + 2e-5f * scale;
}

/// Number of a block's results that differ from those of single points.
struct BsdfDifferences {
  int values = 0, samples = 0;
};

BsdfDifferences differences_of(const Bsdf& bsdf, const std::vector<BsdfQuestion>& questions,
                           Outcome& outcome) {
  BsdfBlock block(questions);
  bsdf.shade_block(block.points, block.query, block.answer);
  if (block.is_overrun()) outcome.fail("shade_block() writes beyond its columns");
  BsdfDifferences differences;
  for (size_t i = 0; i < questions.size(); ++i) {
    const BsdfReply a = block.reply(i), b = reply_at(bsdf, questions[i]);
    const float scale = 1 + b.value.pdf;
    differences.values += !(is_near(a.value.f, b.value.f, scale) &&
                            is_near(Vec3(a.value.pdf), Vec3(b.value.pdf), scale));
    const bool has = b.sample.pdf > 0;
    if ((a.sample.pdf > 0) != has) {
      ++differences.samples;
    } else if (has) {
      differences.samples += !(glm::length(a.sample.wo - b.sample.wo) < 1e-3f &&
                               is_near(a.sample.weight, b.sample.weight, 10) &&
                               any(a.sample.lobe & Lobe::kDelta) == any(b.sample.lobe & Lobe::kDelta));
    }
  }
  return differences;
}

}  // namespace

Outcome bsdf_blocks(const Subject& subject) {
  Outcome outcome;
  Random random(subject.request().seed + 8);
  const auto questions = random_questions(static_cast<size_t>(subject.samples(3001)), random);
  const auto count = static_cast<int>(questions.size());
  std::string sets;
  for (const InstructionSet set :
       subject.registry().instruction_sets(subject.category(), subject.name())) {
    if (set > subject.registry().instruction_set()) continue;
    PluginRegistry registry(subject.folders(), std::max(set, min_instruction_set()));
    const auto bsdf = subject.make<Bsdf>(registry);
    const std::string name = to_string(std::max(set, min_instruction_set()));
    sets += (sets.empty() ? "" : ", ") + name;
    const BsdfDifferences differences = differences_of(*bsdf, questions, outcome);
    const std::string where = " at {} of {} points (" + name + ")";
    outcome.fail_if_many(differences.values, count, 500,
                         "shade_block() differs from eval_pdf()" + where);
    outcome.fail_if_many(differences.samples, count, 100,
                         "shade_block() differs from sample()" + where);
  }
  outcome.measured =
      fmt::format("blocks of {} points compared with single points ({})", count, sets);
  return outcome;
}

}  // namespace kinome::check
