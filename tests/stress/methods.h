#pragma once

#include <string>
#include <vector>

/// Methods that render a scene: integrators, and importances of `clustered`.
namespace kinome::test {

struct Method {
  std::string name;
  std::string integrator;
  std::string against;      ///< the method with the same expectation; empty: none
  bool same_seeds = false;  ///< compares renders of the same seed
};

/// Rays per pixel of all methods that use `product`.
inline constexpr double kRaysPerPixel = 12;

const std::vector<Method>& all_methods();

/// Returns the XML of the integrator for `scene`. `ptracer` doesn't show environments: if there is
/// one, all integrators hide it.
std::string integrator_of(const Method& method, const std::string& scene);

}  // namespace kinome::test
