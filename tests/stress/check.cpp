#include "check.h"

#include <cstring>
#include <stdexcept>

#include <fmt/format.h>

#include "checked_scene.h"
#include "kinome/error.h"
#include "kinome/plugin_audit.h"
#include "kinome/sensor.h"
#include "method_comparison.h"

namespace kinome::test {
namespace {

/// Samples per image; an invalid scene may have many more.
constexpr double kMaxImageSamples = 4096;

class Checker {
 public:
  Checker(const std::string& text, const std::string& folder, const CheckTask& task)
      : scene_(text, folder, task), comparison_(scene_) {}

  CheckReport run() {
    for (const Method& method : scene_.task().methods) {
      if (scene_.task().only.empty() || method.name == scene_.task().only) left_.push_back(&method);
    }
    const auto while_loading = refusals([&](const Method& method) { scene_.scene_of(method); });
    for (const Refusal& refusal : while_loading) {
      if (refusal.error.find('\n') == std::string::npos) continue;
      findings().push_back({"exception", "load", "an error of many lines"});
      break;
    }
    judge(while_loading);
    check_plugins();
    judge(refusals([&](const Method& method) { check_alone(method); }));
    const auto while_comparing =
        refusals([&](const Method& method) { comparison_.compare_with_other(method); });
    for (const Refusal& refusal : while_comparing) add_finding(refusal);
    return scene_.report();
  }

 private:
  struct Refusal {
    std::string method, error;
  };

  std::vector<Finding>& findings() { return scene_.report().findings; }

  /// Runs a step with each remaining method and returns the errors. Methods with an error are
  /// excluded from later steps, so that one method's error doesn't hide findings of others.
  template <class Step>
  std::vector<Refusal> refusals(const Step& step) {
    std::vector<Refusal> refusals;
    std::vector<const Method*> left;
    for (const Method* method : left_) {
      try {
        step(*method);
        left.push_back(method);
        continue;
      } catch (const Error& error) {
        if (!scene_.is_loaded(*method) || !scene_.has_too_much_flux(*method)) {
          refusals.push_back({method->name, error.what()});
        }
      } catch (const std::exception& error) {
        findings().push_back({"exception", method->name, error.what()});
      }
      scene_.exclude(*method);
    }
    left_ = left;
    return refusals;
  }
  /// A scene must be refused by all methods or by none.
  void judge(const std::vector<Refusal>& refusals) {
    if (refusals.empty()) return;
    if (!left_.empty()) {
      for (const Refusal& refusal : refusals) add_finding(refusal);
      return;
    }
    std::string& refused = scene_.report().refused;
    refused = refusals[0].error;
    // An error message is no excuse: of 1100 valid scenes of random_scene(), including extreme
    // ones, none was refused.
    if (scene_.task().is_valid) add_finding({"load", refused});
  }
  void add_finding(const Refusal& refusal) {
    findings().push_back({"refused", refusal.method, refusal.error});
  }

  /// The project's plugins must pass the audit.
  void check_plugins() {
    constexpr uint32_t kPlaces = 256;
    if (left_.empty()) return;
    const Scene& scene = scene_.scene_of(*left_[0]);
    for (const PluginFault& fault : audit_plugins(scene, *scene.sensors().at(0), 1, kPlaces)) {
      findings().push_back(
          {"fault", fault.plugin,
           fmt::format("{}, at {} of {} places", fault.what, fault.count, fault.looks)});
    }
  }

  void check_alone(const Method& method) {
    const Scene& scene = scene_.scene_of(method);
    if (scene_.samples_of(method) > kMaxImageSamples) {
      throw Error("a picture too large to be rendered many times");
    }
    const Renders one = render_often(scene, 1, 7, 1), two = render_often(scene, 1, 7, 2);
    if (one.pixels[0].size() != two.pixels[0].size() ||
        std::memcmp(one.pixels[0].data(), two.pixels[0].data(),
                    one.pixels[0].size() * sizeof(float)) != 0) {
      findings().push_back({"threads", method.name, "one thread and two give other bits"});
    }
    if (scene_.is_finite(method, one) && scene_.is_finite(method, two)) {
      scene_.is_finite(method, scene_.renders_of(method));
    }
  }

  CheckedScene scene_;
  MethodComparison comparison_;
  std::vector<const Method*> left_;  ///< the remaining methods of the task
};

}  // namespace

CheckReport check_scene(const std::string& text, const std::string& folder, const CheckTask& task) {
  return Checker(text, folder, task).run();
}

std::string reason_of(const std::string& error) {
  // "FOLDER/scene.xml:LINE:COLUMN: "
  const std::string file = "/scene.xml:";
  const size_t at = error.find(file);
  if (at == std::string::npos) return error;
  const size_t end = error.find_first_not_of("0123456789: ", at + file.size());
  return end == std::string::npos ? error : error.substr(end);
}

}  // namespace kinome::test
