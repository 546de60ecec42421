#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/render.h"

/// Shared code of the tests of `clustered` against `groundtruth`.
namespace kinome::test {

inline const std::string kDiffuse =
    R"(<bsdf type="diffuse"><rgb name="reflectance" value=".7 .5 .3"/></bsdf>)";
inline std::string phong_xml(const std::string& exponent) {
  return R"(<bsdf type="phong"><rgb name="diffuse_reflectance" value=".3 .2 .4"/>
    <rgb name="specular_reflectance" value=".4 .4 .2"/><float name="exponent" value=")" +
         exponent + R"("/></bsdf>)";
}
inline std::string ward_xml(const std::string& alpha_u) {
  return R"(<bsdf type="ward"><rgb name="diffuse_reflectance" value=".3 .2 .1"/>
    <rgb name="specular_reflectance" value=".3 .4 .5"/><float name="alpha_v" value=".3"/>
    <float name="alpha_u" value=")" +
         alpha_u + R"("/></bsdf>)";
}
inline std::string metal_xml(const std::string& alpha) {
  return R"(<bsdf type="roughconductor"><float name="alpha" value=")" + alpha + R"("/></bsdf>)";
}

inline std::string sampler_xml(const std::string& type) {
  return "<sampler type=\"" + type + "\"><integer name=\"sample_count\" value=\"4\"/></sampler>";
}
/// Returns parameters of `clustered`.
inline std::string counts_xml(int cut_size, int emitter_samples) {
  return "<integer name=\"cut_size\" value=\"" + std::to_string(cut_size) +
         "\"/><integer name=\"emitter_samples\" value=\"" + std::to_string(emitter_samples) +
         "\"/>";
}
inline std::string importance_xml(const std::string& importance) {
  return "<string name=\"importance\" value=\"" + importance + "\"/>";
}
inline const std::string kLuminanceCut = R"(<string name="cut_criterion" value="luminance"/>)";

/// Tests that the mean difference of two renders with one seed is 0. They have the same light
/// points and pixel positions, so that only the choices of `clustered` contribute variance.
inline void expect_same_expectation(const Scene& clustered, const Scene& truth, int renders) {
  const auto difference = estimate_differences(clustered, truth, renders, 4);
  const Verdict verdict = z_test(difference, std::vector<Estimate>(difference.size()), 1e-4);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

}  // namespace kinome::test
