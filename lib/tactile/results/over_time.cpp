#include "tactile/results/over_time.hpp"

#include "tactile/core/duration_units.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const ShareOverTime& share) {
  json = {{"first", share.first},
          {"later", share.later},
          {"last", share.last},
          {"before_last", share.before_last},
          {"last_minus_before", share.last_minus_before},
          {"still_predicted", share.still_predicted},
          {"intervals", share.intervals},
          {"short_ones", share.short_ones}};
}

void from_json(const JsonView& json, ShareOverTime& share) {
  share = {.first = json["first"].get<Figure>(),
           .later = json["later"].get<Figure>(),
           .last = json["last"].get<Figure>(),
           .before_last = json["before_last"].get<Figure>(),
           .last_minus_before = json["last_minus_before"].get<Figure>(),
           .still_predicted = json.renamed("still_predicted", "still_said").get<Figure>(),
           .intervals = json["intervals"].count(),
           .short_ones = json["short_ones"].count()};
}

void to_json(nlohmann::json& json, const OverTimeBin& bin) {
  json = {{"from_ms", in_ms(bin.from)},
          {"to_ms", in_ms(bin.to)},
          {"accuracy", bin.accuracy},
          {"ticks", bin.ticks},
          {"intervals", bin.intervals}};
}

void from_json(const JsonView& json, OverTimeBin& bin) {
  bin = {json["from_ms"].milliseconds(), json["to_ms"].milliseconds(), json["accuracy"].get<Figure>(), json["ticks"].count(),
         json["intervals"].count()};
}

void to_json(nlohmann::json& json, const AccuracyOverTime& accuracy) {
  json = accuracy.all;
  json["objects"] = accuracy.objects;
  json["since_onset"] = accuracy.since_onset;
  json["before_end"] = accuracy.before_end;
}

void from_json(const JsonView& json, AccuracyOverTime& accuracy) {
  accuracy = {json.get<ShareOverTime>(), json["objects"].map_of<ShareOverTime>(), json["since_onset"].list_of<OverTimeBin>(),
              json["before_end"].list_of<OverTimeBin>()};
}

void to_json(nlohmann::json& json, const OverTime& over_time) {
  json = {{"bin_ms", in_ms(over_time.options.bin)},
          {"first_ms", in_ms(over_time.options.first)},
          {"last_ms", in_ms(over_time.options.last)},
          {"after_ms", in_ms(over_time.options.after)},
          {"press", over_time.press},
          {"slip", over_time.slip},
          {"both", over_time.both}};
}

void from_json(const JsonView& json, OverTime& over_time) {
  over_time = {{.bin = json["bin_ms"].milliseconds(),
                .first = json["first_ms"].milliseconds(),
                .last = json["last_ms"].milliseconds(),
                .after = json["after_ms"].milliseconds()},
               json["press"].get<AccuracyOverTime>(),
               json["slip"].get<AccuracyOverTime>(),
               json["both"].get<AccuracyOverTime>()};
}

}  // namespace tactile::results
