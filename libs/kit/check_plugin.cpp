// Runs the checks of `kinome check` for a plugin's category.

#include <fmt/format.h>

#include "kit/request.h"
#include "kit/subject.h"
#include "kinome/error.h"
#include "kinome/log.h"

namespace kinome::check {

namespace {

void add_checks_of_category(const Subject& subject, Plan& plan) {
  switch (subject.category()) {
    case Category::kBsdf: return add_bsdf_checks(subject, plan);
    case Category::kEmitter: return add_emitter_checks(subject, plan);
    case Category::kFilm: return add_film_checks(subject, plan);
    case Category::kIntegrator: return add_integrator_checks(subject, plan);
    case Category::kMedium: return add_medium_checks(subject, plan);
    case Category::kPhase: return add_phase_checks(subject, plan);
    case Category::kReconstructionFilter: return add_filter_checks(subject, plan);
    case Category::kSampler: return add_sampler_checks(subject, plan);
    case Category::kSensor: return add_sensor_checks(subject, plan);
    case Category::kShape: return add_shape_checks(subject, plan);
    case Category::kTexture: return add_texture_checks(subject, plan);
    case Category::kVolume: return add_volume_checks(subject, plan);
  }
}

}  // namespace

int check_plugin(const Request& request) {
  set_log_level(LogLevel::kQuiet);  // extreme parameters may cause warnings
  const Subject subject(request);
  Request used = request;
  const bool is_made = can_be_created(subject);
  if (!is_made) {  // nothing else can be checked
    used.only = {"defaults"};
    used.except.clear();
  }
  fmt::print("{}: {}\n", subject.title(), subject.plugin().doc);
  Plan plan(used);
  add_parameter_checks(subject, plan);
  if (is_made) add_read_check(subject, plan);
  if (is_made) add_checks_of_category(subject, plan);
  return plan.run() == 0 ? 0 : 1;
}

}  // namespace kinome::check

int kinome_check_plugin(const kinome::check::Request& request) {
  return kinome::check::check_plugin(request);
}
