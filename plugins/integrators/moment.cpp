/// Second moments: the mean of the square of what each sample sees, from which the variance of a
/// sample follows as m2 - mean². Nested integrators render as they do alone; for each, the picture
/// gets its colour as CIE XYZ (NAME.X, .Y, .Z), what else it shows (NAME.CHANNEL), and the second
/// moment of all of it with `m2_` before the name. The film's colour is that of the first.
///
///     <integrator type="moment">
///       <integrator type="path" name="img"/>
///     </integrator>
///
/// `ptracer` and `clustered` by `product` have no samples of a pixel that could be squared one by
/// one: light paths meet all pixels, and rays are shared by neighbours. `--variance` tells how noisy
/// their pictures are.

#include <algorithm>

#include "ignored_parameters.h"
#include "nesting.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    kIgnoredHideEmitters,
    {"integrator", ParameterType::kObject, nullptr,
     "What renders; each one's second moments are computed.", true, Category::kIntegrator, 16},
};

class MomentIntegrator final : public NestingIntegrator {
 public:
  explicit MomentIntegrator(const Properties& props) : NestingIntegrator(props) {
    for (const Nested& nested : this->nested()) {
      if (!nested.integrator->gives_samples()) {
        throw Error(nested.where,
                    "there are no second moments of '" + nested.integrator->plugin() +
                        "', which doesn't sample pixels one by one: --variance tells its noise");
      }
      add_channels_of(nested);
      add_color(nested, {{"X", FilmChannel::kX}, {"Y", FilmChannel::kY}, {"Z", FilmChannel::kZ}});
    }
    for (FilmChannel channel : channels()) {
      channel.name = "m2_" + channel.name;
      channel.power *= 2;
      add_channel(std::move(channel));
    }
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::MomentIntegrator, kinome::Category::kIntegrator, "moment",
              "What nested integrators render, with the second moments of its samples as channels.",
              kinome::kTable);
