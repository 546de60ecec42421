/// The sun and a cloudless sky averaged over time, as in Mitsuba 3. The time from `shutter_open` to
/// `shutter_close` is mapped to the days from the start to the day before the end, each from
/// `window_start_time` to `window_end_time`. The image shows the mean over the time in which the
/// sensor's shutter is open; by default that is the first moment of the first day.
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
    {"window_start_time", ParameterType::kFloat, "7", "Hour at which each day begins."},
    {"window_end_time", ParameterType::kFloat, "19", "Hour at which each day ends."},
    {"start_year", ParameterType::kInteger, "2025",
     "Year of the first day, in the Gregorian calendar."},
    {"start_month", ParameterType::kInteger, "1", "Month of the first day, from 1 to 12."},
    {"start_day", ParameterType::kInteger, "1", "First day of the month, from 1."},
    {"end_year", ParameterType::kInteger, nullptr,
     "Year of the day after the last one; default: start_year + 1."},
    {"end_month", ParameterType::kInteger, nullptr,
     "Month of the day after the last one, from 1 to 12; default: start_month."},
    {"end_day", ParameterType::kInteger, nullptr,
     "The day after the last one, from 1; default: start_day."},
    {"shutter_open", ParameterType::kFloat, "0", "Sensor time at which the first day begins."},
    {"shutter_close", ParameterType::kFloat, "1", "Sensor time at which the last day ends."},
};

/// Offset in the sun's table. Mitsuba looks the sun up in a texture here, whose texel centres are
/// half a row further.
constexpr double kRows = -0.5;

/// The days, and the part of each day that is used.
struct Days {
  TimeAndPlace start;  ///< start of the first day
  double hours;        ///< from the start to the end of a day
  int count;
  Shutter shutter;  ///< sensor times at which the days begin and end

  /// Direction of the sun at a fraction `share` in [0, 1] of the whole time.
  Vec3 sun_at(double share) const {
    const double days = share * count;
    const int day = std::min(static_cast<int>(days), count - 1);
    TimeAndPlace at = start;
    at.day += day;
    at.hour += (days - day) * hours;
    return sun_direction(at);
  }
};

int read_date(const Properties& props, const std::string& name, int default_value) {
  return props.has(name) ? read_calendar(props, name.c_str()) : default_value;
}

Days read_days(const Properties& props) {
  const float start = props.real("window_start_time", "must be between 0 and 24",
                                 [](float hour) { return hour >= 0 && hour <= 24; });
  const float end = props.real("window_end_time", "must be between window_start_time and 24",
                               [start](float hour) { return hour >= start && hour <= 24; });
  const int year = read_calendar(props, "start_year"), month = read_calendar(props, "start_month"),
            day = read_calendar(props, "start_day");
  Days days;
  days.start = {props.real("latitude"),
                props.real("longitude"),
                props.real("timezone"),
                year,
                month,
                day,
                start,
                0,
                0};
  days.hours = double{end} - start;
  days.count = julian_day(read_date(props, "end_year", year + 1),
                          read_date(props, "end_month", month), read_date(props, "end_day", day)) -
               julian_day(year, month, day);
  if (days.count < 0) {
    const char* const name = props.has("end_year")    ? "end_year"
                             : props.has("end_month") ? "end_month"
                                                      : "end_day";
    throw props.error(name, "must not be before the first day");
  }
  days.count = std::max(1, days.count);  // as in Mitsuba
  const float open = props.real("shutter_open");
  days.shutter = {open,
                  props.real("shutter_close",
                             "must be greater than shutter_open (" + format_number(open) + ")",
                             [open](float close) { return open < close; })};
  read_sun_at(props, days.start);  // checks that it is finite
  return days;
}

class TimedSunSkyEmitter final : public Environment {
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
      log_warn(Error(where_,
                     "the sensor's shutter is open before the emitter's shutter_open or "
                     "after its shutter_close; the sky doesn't change there")
                   .what());
    }
    if (is_new) show(shutter);
  }

  Rgb eval_environment(const Vec3& d) const override { return sky_->eval_environment(d); }
  float pdf_environment(const Vec3& d) const override { return sky_->pdf_environment(d); }
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    return sky_->sample_direct(p, u);
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
  bool eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                              std::span<float> pdf) const override {
    return sky_->eval_environment_batch(d, radiance, pdf);
  }
  void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    sky_->sample_direct_block(p, u, count, out);
  }
  void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                              float* pdf) const override {
    sky_->eval_environment_block(d, count, radiance, pdf);
  }

 private:
  /// Fraction of the whole time that has passed at a sensor time.
  double share_at(float time) const {
    return (double{time} - days_.shutter.open) / (double{days_.shutter.close} - days_.shutter.open);
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

  /// Returns the mean sky between the fractions `open` and `close` of the whole time. The sky is
  /// constant before the first moment and after the last one.
  std::unique_ptr<Environment> mean_over(double open, double close) const {
    const auto suns = [&](int count) {
      std::vector<Vec3> all;
      for (int i = 0; i < count; ++i) {
        const double share = open + (close - open) * (i + 0.5) / count;
        all.push_back(days_.sun_at(std::clamp(share, 0., 1.)));
      }
      return all;
    };
    // Primes, so that over many days, the moments cover all hours.
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
  bool is_known_ = false;  ///< true if a scene has set the shutter
  std::unique_ptr<Environment> sky_;
};

}  // namespace
}  // namespace kinome::sunsky

KINOME_PLUGIN(kinome::sunsky::TimedSunSkyEmitter, kinome::Category::kEmitter, "timed_sunsky",
              "The sun and a cloudless sky averaged over hours and days.", kinome::sunsky::kTable);
