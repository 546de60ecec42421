// Renders an image with the scene's integrator.

#include "kinome/render.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/log_once.h"
#include "session/fill_gaps.h"
#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/process_group.h"
#include "kinome/shared_items.h"
#include "kinome/work_source.h"
#include "session/progressive.h"
#include "session/film_render.h"

namespace kinome {
namespace {

/// Adds the traffic of all processes of the group to RenderStats::traffic. Collective.
void add_traffic(ProcessGroup& group, RenderStats& stats) {
  SharedBytes own;
  auto of_this = group.traffic();
  auto kinds = static_cast<uint32_t>(of_this.size());
  own.value(kinds);
  for (auto& [what, traffic] : of_this) {
    std::string name = what;
    own.text(name);
    own.value(traffic);
  }
  for (const std::string& said : group.gather(own.written(), "agreement")) {
    SharedBytes theirs(said);
    for (theirs.value(kinds); kinds > 0; --kinds) {
      std::string name;
      GroupTraffic traffic;
      theirs.text(name);
      theirs.value(traffic);
      GroupTraffic& sum = stats.traffic[name];
      sum.messages += traffic.messages;
      sum.bytes += traffic.bytes;
      sum.seconds += traffic.seconds;
    }
  }
}

}  // namespace

Image render(const Scene& scene, const Sensor& sensor, RenderContext& context) {
  return render(scene, sensor, context, nullptr);
}

Image render(const Scene& scene, const Sensor& sensor, RenderContext& context,
             const PassCallback& on_pass) {
  RenderJob& job = context.job;
  const RenderBudget& budget = job.budget();
  FilmRender how;
  how.lanes = lanes_for(budget, sensor.film());
  how.render = [&] {
    const Integrator& integrator = scene.integrator();
    RenderStats& stats = job.stats();
    Film& film = sensor.film();
    if (budget.any()) {
      const double left =
          budget.seconds > 0 ? agree(job.group(), budget.seconds - job.seconds()) : kInfinity;
      render_passes(*integrator.begin(scene, sensor, context, left), film, job, on_pass);
    } else {
      integrator.render(scene, sensor, context);
      stats.samples = sensor.sampler().sample_count();
      if (on_pass && !job.interrupted()) on_pass(develop(film, budget, stats), stats);
    }
  };
  return run_film_render(how, scene, sensor, context);
}

Image run_film_render(const FilmRender& how, const Scene& scene, const Sensor& sensor,
                      RenderContext& context) {
  const WarningsOnce once;
  RenderJob& job = context.job;
  RenderStats& stats = job.stats();
  Image image;
  bool interrupted = false;
  {
    const StageTimer timer(stats.render_seconds);
    const Integrator& integrator = scene.integrator();
    stats.stages = integrator.stages();
    Film& film = sensor.film();
    const RenderBudget& budget = job.budget();
    film.prepare(integrator.layers(), integrator.channels(), how.lanes);
    WorkSource* const source = job.work_source();
    context.scheduler.set_film(film);
    if (is_root(job.group())) integrator.warn_of_ignored_light(scene, sensor, context);
    const double begun = job.seconds();
    on_all_processes(job.group(), [&] {
      if (source) source->begin(film);
    });
    if (source && source->resumes() && context.scheduler.commit_callback()) {
      context.scheduler.commit_callback()(film, film.crop());
    }
    how.render();
    interrupted = job.interrupted();
    stats.threads = context.scheduler.threads();
    stats.complete = !interrupted;
    if (ProcessGroup* const group = job.group()) add_traffic(*group, stats);
    if (!is_root(job.group())) {
      if (film.commits() == 0) return image;
      throw Error(
          "the integrator adds to the film without Scheduler::commit(), which groups of "
          "processes don't support");
    }
    if (source && interrupted) source->close(film);
    if (interrupted && how.fills_gaps) fill_gaps(scene, sensor, context, begun);
    if (interrupted && !how.fills_gaps) stats.missing = share_of_gaps(integrator, film);
    image = develop(film, budget, stats, &context.scheduler);
    if (interrupted && how.fills_gaps) mark_gaps(film, image);
    stats.non_finite_samples += film.non_finite();
  }
  stats.peak_memory_bytes = peak_memory_bytes();
  return image;
}

void warn_of_missed_budget(const RenderBudget& budget, const RenderStats& stats, double seconds,
                           const BudgetNames& names) {
  if (budget.seconds > 0 && seconds > budget.seconds + std::max(0.05, 0.05 * budget.seconds)) {
    const std::string samples = fmt::format("{:.3g} samples per pixel", stats.samples);
    log_warn(fmt::format("{}{:g}: it took {:.3f} s to {}", names.seconds, budget.seconds, seconds,
                         fmt::format(fmt::runtime(names.work), samples)));
  }
  if (budget.rel_mse > 0 && stats.complete && !(stats.rel_mse <= budget.rel_mse)) {
    log_warn(fmt::format(
        "{}{:g} was not reached: the estimate is {:.3g} {}", names.rel_mse, budget.rel_mse,
        stats.rel_mse,
        budget.seconds > 0
            ? fmt::format("when time was up, after {:.0f} samples per pixel", stats.samples)
            : fmt::format("with {:.0f} samples per pixel, the maximum", stats.samples)));
  }
}

}  // namespace kinome
