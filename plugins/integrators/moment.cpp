/// Second moments: the mean of each sample's squared value. The variance of a sample is m2 - mean².
/// Nested integrators render as they do alone. For each, the image gets its colour as CIE XYZ
/// (NAME.X, .Y, .Z), its other channels (NAME.CHANNEL), and the second moments of all of these with
/// the prefix `m2_`. The film's colour is that of the first nested integrator.
///
///     <integrator type="moment">
///       <integrator type="path" name="img"/>
///     </integrator>
///
/// `ptracer` and `clustered` by `product` have no independent samples of a pixel: light paths
/// contribute to all pixels, and neighbours share rays. Use `--variance` to estimate the noise of
/// their images.

#include <algorithm>

#include "ignored_parameters.h"
#include "nesting.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    kIgnoredHideEmitters,
    {"integrator", ParameterType::kObject, nullptr,
     "Integrators whose second moments are computed.", true, Category::kIntegrator, 16},
};

class MomentIntegrator final : public NestingIntegrator {
 public:
  explicit MomentIntegrator(const Properties& props) : NestingIntegrator(props) {
    for (const Nested& nested : this->nested()) {
      if (!nested.integrator->gives_samples()) {
        throw Error(nested.where,
                    "there are no second moments of '" + nested.integrator->plugin() +
                        "', which doesn't sample pixels one by one; use --variance to estimate its "
                        "noise");
      }
    }
    list();
  }

 private:
  void list_channels() override {
    for (const Nested& nested : this->nested()) {
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
              "Nested integrators, with the second moments of their samples as channels.",
              kinome::kTable);
