#pragma once

#include <string>
#include <vector>

/// What renders a scene: integrators, and importances of `clustered`.
namespace kinome::test {

struct Method {
  std::string name;
  std::string integrator;
  std::string against;      ///< the method whose expectation it has; empty: none
  bool same_seeds = false;  ///< differences of renders of one seed
};

/// Of all methods by `product`.
inline constexpr double kRaysPerPixel = 12;

const std::vector<Method>& all_methods();

/// The integrator's XML as it is to render `scene`. `ptracer` doesn't show environments: where
/// there is one, no integrator is to.
std::string integrator_of(const Method& method, const std::string& scene);

}  // namespace kinome::test
