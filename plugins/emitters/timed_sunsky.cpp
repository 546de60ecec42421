/// The sun and a cloudless sky while days go by, as in Mitsuba 3. The time from `shutter_open` to
/// `shutter_close` stands for all days from the start to the day before the end, one after the
/// other, each from `window_start_time` to `window_end_time`. The image shows the mean over the time
/// in which the sensor's shutter is open; by default that is the first moment of the first day.
///
///     <sensor type="perspective">
///       <float name="shutter_close" value="1"/>
///     </sensor>
///     <emitter type="timed_sunsky">
///       <float name="window_start_time" value="9"/>
///       <integer name="end_year" value="2025"/>
///       <integer name="end_month" value="2"/>
///     </emitter>

#include <memory>

#include "kinome/emitter.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/sensor.h"
#include "map_environment.h"
#include "mean_sky.h"
#include "sunsky_environment.h"

namespace kinome::sunsky {
namespace {

constexpr Parameter kTable[] = {
    KINOME_SUNSKY_PARAMETERS,
    {"window_start_time", ParameterType::kFloat, "7", "Hour at which days begin."},
    {"window_end_time", ParameterType::kFloat, "19", "Hour at which days end."},
    {"start_year", ParameterType::kInteger, "2025", "The first day, in the Gregorian calendar."},
    {"start_month", ParameterType::kInteger, "1", "1 to 12."},
    {"start_day", ParameterType::kInteger, "1", "From 1 on."},
    {"end_year", ParameterType::kInteger, nullptr,
     "The day after the last one; by default a year after the first."},
    {"end_month", ParameterType::kInteger, nullptr, "1 to 12; start_month by default."},
    {"end_day", ParameterType::kInteger, nullptr, "From 1 on; start_day by default."},
    {"shutter_open", ParameterType::kFloat, "0", "The sensor's time at which the first day begins."},
    {"shutter_close", ParameterType::kFloat, "1", "The sensor's time at which the last day ends."},
};

/// Mitsuba looks the sun up in a texture here, whose texels are centred half a row on.
constexpr double kRows = -0.5;

/// The days, and the part of each that is shown.
struct Days {
  TimeAndPlace start;  ///< of the first day
  double hours;        ///< from the start to the end of a day
  int count;
  Shutter shutter;  ///< the times at which they begin and end

  /// The sun at a share from 0 to 1 of the whole time.
  Vec3 sun_at(double share) const {
    const double days = share * count;
    const int day = std::min(static_cast<int>(days), count - 1);
    TimeAndPlace at = start;
    at.day += day;
    at.hour += (days - day) * hours;
    return sun_direction(at);
  }
};

int read_date(const Properties& props, const std::string& name, int otherwise) {
  return props.has(name) ? read_calendar(props, name.c_str()) : otherwise;
}

Days read_days(const Properties& props) {
  const float start = props.real("window_start_time"), end = props.real("window_end_time");
  if (!(start >= 0 && start <= 24)) {
    throw props.error("window_start_time", "must be from 0 to 24, got " + std::to_string(start));
  }
  if (!(end >= start && end <= 24)) {
    throw props.error("window_end_time",
                      "must be from window_start_time to 24, got " + std::to_string(end));
  }
  const int year = read_calendar(props, "start_year"), month = read_calendar(props, "start_month"),
            day = read_calendar(props, "start_day");
  Days days;
  days.start = {props.real("latitude"), props.real("longitude"), props.real("timezone"), year,
                month, day, start, 0, 0};
  days.hours = double{end} - start;
  days.count = julian_day(read_date(props, "end_year", year + 1), read_date(props, "end_month", month),
                          read_date(props, "end_day", day)) -
               julian_day(year, month, day);
  if (days.count < 0) {
    const char* const name = props.has("end_year")    ? "end_year"
                             : props.has("end_month") ? "end_month"
                                                      : "end_day";
    throw props.error(name, "makes the last day come before the first one");
  }
  days.count = std::max(1, days.count);  // as in Mitsuba
  days.shutter = {props.real("shutter_open"), props.real("shutter_close")};
  if (!(days.shutter.open < days.shutter.close)) {
    throw props.error("shutter_close", "must be greater than shutter_open (" +
                                           std::to_string(days.shutter.open) + "), got " +
                                           std::to_string(days.shutter.close));
  }
  read_sun_at(props, days.start);  // checks that it is finite
  return days;
}

class TimedSunSkyEmitter final : public Emitter {
 public:
  explicit TimedSunSkyEmitter(const Properties& props)
      : settings_(props), days_(read_days(props)), where_(props.where()) {
    show(Shutter());
  }

  void set_shutter(const Shutter& shutter) override {
    const bool is_new = !(shutter == shutter_);
    if (is_known_ && !is_new) return;
    is_known_ = true;
    if (share_at(shutter.open) < 0 || share_at(shutter.close) > 1) {
      log_warn(Error(where_, "the sensor's shutter is open beyond the emitter's shutter_open and "
                             "shutter_close, where the sky stands still")
                   .what());
    }
    if (is_new) show(shutter);
  }

  bool is_environment() const override { return true; }
  void prepare(const Aabb& bounds) override { sky_->prepare(bounds); }
  Rgb eval_environment(const Vec3& d) const override { return sky_->eval_environment(d); }
  float pdf_environment(const Vec3& d) const override { return sky_->pdf_environment(d); }
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    return sky_->sample_direct(p, u);
  }
  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const override {
    return sky_->sample_emission(position, direction);
  }
  std::optional<EmissionDensity> emission_density(const Vec3& d) const override {
    return sky_->emission_density(d);
  }
  std::optional<LightPoints> light_points(const Scene& scene, RenderContext& context,
                                          uint32_t count) const override {
    return sky_->light_points(scene, context, count);
  }
  std::optional<EnvironmentGrid> cell_grid() const override { return sky_->cell_grid(); }
  bool eval_grid_batch(std::span<const Vec2> places, std::span<Rgb> radiance) const override {
    return sky_->eval_grid_batch(places, radiance);
  }
  bool eval_grid_corners(int row, int first, std::span<Rgb> radiance) const override {
    return sky_->eval_grid_corners(row, first, radiance);
  }
  void eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                              std::span<float> pdf) const override {
    sky_->eval_environment_batch(d, radiance, pdf);
  }
  void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    sky_->sample_direct_block(p, u, count, out);
  }
  void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                              float* pdf) const override {
    sky_->eval_environment_block(d, count, radiance, pdf);
  }
  void sample_emission_block(const Columns2& position, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    sky_->sample_emission_block(position, direction, count, out);
  }

 private:
  /// Share of the whole time that has passed at a time of the sensor.
  double share_at(float time) const {
    return (double{time} - days_.shutter.open) /
           (double{days_.shutter.close} - days_.shutter.open);
  }

  void show(const Shutter& shutter) {
    shutter_ = shutter;
    const double open = share_at(shutter.open), close = share_at(shutter.close);
    if (open < close) {
      sky_ = mean_over(open, close);
    } else {
      sky_ = std::make_unique<SunSky>(settings_, days_.sun_at(std::clamp(open, 0., 1.)), kRows);
    }
  }

  /// Returns the mean sky from a share `open` to a share `close` of the whole time. Before the first
  /// moment and after the last one, the sky is that of this moment.
  std::unique_ptr<Emitter> mean_over(double open, double close) const {
    const auto suns = [&](int count) {
      std::vector<Vec3> all;
      for (int i = 0; i < count; ++i) {
        const double share = open + (close - open) * (i + 0.5) / count;
        all.push_back(days_.sun_at(std::clamp(share, 0., 1.)));
      }
      return all;
    };
    // Primes, so that moments of many days fall on all hours.
    constexpr int kSkies = 251, kSuns = 32749;
    MeanSky mean(settings_, kRows);
    mean.add_skies(suns(kSkies));
    mean.add_suns(suns(kSuns));
    return std::make_unique<MapEnvironment>(settings_.frame.axes * mean_sky_axes(),
                                            SphericalMap(mean.image(), 1, false));
  }

  SkySettings settings_;
  Days days_;
  Location where_;
  Shutter shutter_;
  bool is_known_ = false;  ///< a scene has set the shutter
  std::unique_ptr<Emitter> sky_;
};

}  // namespace
}  // namespace kinome::sunsky

KINOME_PLUGIN(kinome::sunsky::TimedSunSkyEmitter, kinome::Category::kEmitter, "timed_sunsky",
              "The sun and a cloudless sky while days go by.", kinome::sunsky::kTable);
