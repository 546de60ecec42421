/// The sun and a cloudless sky while days go by, as in Mitsuba 3, for sensors whose shutter stays
/// open for as long. Shutters here don't: they see its first moment, `window_start_time` of the
/// first day, as Mitsuba's sensors do that are given none. Else it is `sunsky`.
///
///     <emitter type="timed_sunsky">
///       <float name="window_start_time" value="9"/>
///     </emitter>

#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "sunsky_environment.h"

namespace kinome::sunsky {
namespace {

constexpr Parameter kTable[] = {
    KINOME_SUNSKY_PARAMETERS,
    {"window_start_time", ParameterType::kFloat, "7", "Hour at which days begin."},
    {"window_end_time", ParameterType::kFloat, "19", "Hour at which days end; it is only checked."},
    {"start_year", ParameterType::kInteger, "2025", "The first day, in the Gregorian calendar."},
    {"start_month", ParameterType::kInteger, "1", "1 to 12."},
    {"start_day", ParameterType::kInteger, "1", "From 1 on."},
    {"end_year", ParameterType::kInteger, nullptr, "The last day; it has no effect."},
    {"end_month", ParameterType::kInteger, nullptr, "It has no effect."},
    {"end_day", ParameterType::kInteger, nullptr, "It has no effect."},
    {"shutter_open", ParameterType::kFloat, "0", "When the sensor's shutter opens."},
    {"shutter_close", ParameterType::kFloat, "1", "It has no effect."},
};

class TimedSunSkyEmitter final : public SunSky {
 public:
  explicit TimedSunSkyEmitter(const Properties& props)
      // Mitsuba looks the sun up in a texture here, whose texels are centred half a row on.
      : SunSky(props, read_sky_frame(props), read_sun(props), -0.5) {}

 private:
  static Vec3 read_sun(const Properties& props) {
    const float start = props.real("window_start_time"), end = props.real("window_end_time");
    if (!(start >= 0 && start <= 24)) {
      throw props.error("window_start_time", "must be from 0 to 24, got " + std::to_string(start));
    }
    if (!(end >= start && end <= 24)) {
      throw props.error("window_end_time", "must be from window_start_time to 24, got " +
                                               std::to_string(end));
    }
    return read_sun_at(props, {props.real("latitude"), props.real("longitude"), props.real("timezone"),
                          read_calendar(props, "start_year"), read_calendar(props, "start_month"),
                          read_calendar(props, "start_day"), start, 0, 0});
  }
};

}  // namespace
}  // namespace kinome::sunsky

KINOME_PLUGIN(kinome::sunsky::TimedSunSkyEmitter, kinome::Category::kEmitter, "timed_sunsky",
              "The sun and a cloudless sky, at the first moment of a span of days.",
              kinome::sunsky::kTable);
