#include "tactile/labels/exchange/elan.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

namespace fs = std::filesystem;

constexpr const char* touch_tier = "touch";
constexpr const char* undetermined_language = "und";

/// An annotation in ELAN's whole milliseconds.
struct Annotation {
  std::string id, value;
  std::int64_t start_ms = 0, end_ms = 0;
};

std::int64_t floor_ms(std::int64_t us) { return us / 1000 - (us % 1000 < 0 ? 1 : 0); }
std::int64_t nearest_ms(std::int64_t us) { return floor_ms(saturating_add(us, 500)); }

pugi::xml_node append(pugi::xml_node& parent, const char* name,
                      std::initializer_list<std::pair<const char*, std::string>> attributes) {
  pugi::xml_node node = parent.append_child(name);
  for (const auto& [key, value] : attributes) node.append_attribute(key) = value.c_str();
  return node;
}

void append_property(pugi::xml_node& header, const char* name, const std::string& value) {
  append(header, "PROPERTY", {{"NAME", name}}).text() = value.c_str();
}

std::string date_text(std::int64_t unix_s) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}+00:00", fmt::gmtime(static_cast<std::time_t>(unix_s)));
}

/// Rounds so that every annotation has a length. None may begin before 0 or overlap the one before it.
std::vector<Annotation> touches_of(const LabelsToExport& labels) {
  const ClockRelation clock = labels.times.to_camera(labels.first_event);
  std::vector<Annotation> annotations;
  for (const LabelledInterval& interval : labels.labels.intervals) {
    const std::int64_t start_us = clock.clock_us_from(interval.start.at), end_us = clock.clock_us_from(interval.end.at);
    Annotation annotation{.id = interval.id,
                          .value = std::string(name_of(interval.touch)) + (interval.confirmed ? " ok" : ""),
                          .start_ms = nearest_ms(start_us),
                          .end_ms = nearest_ms(end_us)};
    if (annotation.end_ms <= annotation.start_ms) {
      annotation.start_ms = floor_ms(start_us);
      annotation.end_ms = std::max(floor_ms(saturating_add(end_us, 999)), saturating_add(annotation.start_ms, 1));
    }
    if (annotation.start_ms < 0) {
      throw Error(fmt::format("{}: {} begins {} s before {}, which ELAN cannot represent; expected another --origin", labels.run,
                              interval.id, seconds_text(saturating_subtract(0, start_us)),
                              labels.times.origin == TimeOrigin::video ? "the film" : "time 0"));
    }
    if (!annotations.empty() && annotation.start_ms < annotations.back().end_ms) {
      throw Error(
          fmt::format("{}: {} and {} meet within one millisecond, which ELAN cannot distinguish; expected another --format",
                      labels.run, annotations.back().id, interval.id));
    }
    annotations.push_back(std::move(annotation));
  }
  return annotations;
}

/// The 95 % interval of each onset, if it can be shown without overlap.
std::vector<Annotation> onsets_of(const LabelsToExport& labels) {
  const ClockRelation clock = labels.times.to_camera(labels.first_event);
  std::vector<Annotation> annotations;
  std::int64_t free_from_ms = 0;
  for (const LabelledInterval& interval : labels.labels.intervals) {
    const double half_ms = static_cast<double>(between(interval.start.low, interval.start.high).count()) / 2000.0;
    const std::int64_t low_ms = std::max(floor_ms(clock.clock_us_from(interval.start.low)), free_from_ms);
    const std::int64_t high_ms = floor_ms(saturating_add(clock.clock_us_from(interval.start.high), 999));
    if (high_ms <= low_ms) continue;
    annotations.push_back({interval.id + "-onset", fmt::format("±{:.1f} ms", half_ms), low_ms, high_ms});
    free_from_ms = high_ms;
  }
  return annotations;
}

std::vector<Annotation> doubts_of_all(const LabelsToExport& labels, const std::vector<Annotation>& touches) {
  std::vector<Annotation> annotations;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const std::string doubts = doubts_of(labels.labels, i);
    if (!doubts.empty()) annotations.push_back({touches[i].id + "-doubt", doubts, touches[i].start_ms, touches[i].end_ms});
  }
  return annotations;
}

struct Tier {
  const char* id;
  const char* type;
  std::vector<Annotation> annotations;
};

/// The time slots of all tiers, in order of time, before the tiers. Each annotation has two.
void append_tiers(pugi::xml_node& document, const std::vector<Tier>& tiers) {
  std::multimap<std::int64_t, std::string*> ends;
  std::vector<std::vector<std::pair<std::string, std::string>>> slots(tiers.size());
  for (std::size_t i = 0; i < tiers.size(); ++i) {
    slots[i].resize(tiers[i].annotations.size());
    for (std::size_t k = 0; k < slots[i].size(); ++k) {
      ends.emplace(tiers[i].annotations[k].start_ms, &slots[i][k].first);
      ends.emplace(tiers[i].annotations[k].end_ms, &slots[i][k].second);
    }
  }
  pugi::xml_node time_order = document.append_child("TIME_ORDER");
  for (std::size_t number = 1; const auto& [ms, slot] : ends) {
    *slot = fmt::format("ts{}", number++);
    append(time_order, "TIME_SLOT", {{"TIME_SLOT_ID", *slot}, {"TIME_VALUE", std::to_string(ms)}});
  }
  for (std::size_t i = 0; i < tiers.size(); ++i) {
    pugi::xml_node tier = append(document, "TIER", {{"LINGUISTIC_TYPE_REF", tiers[i].type}, {"TIER_ID", tiers[i].id}});
    for (std::size_t k = 0; k < slots[i].size(); ++k) {
      pugi::xml_node node = tier.append_child("ANNOTATION");
      pugi::xml_node alignable = append(node, "ALIGNABLE_ANNOTATION",
                                        {{"ANNOTATION_ID", tiers[i].annotations[k].id},
                                         {"TIME_SLOT_REF1", slots[i][k].first},
                                         {"TIME_SLOT_REF2", slots[i][k].second}});
      alignable.append_child("ANNOTATION_VALUE").text() = tiers[i].annotations[k].value.c_str();
    }
  }
}

/// ELAN plays a film from `TIME_ORIGIN` on at its time 0. It cannot synchronise a film that begins later.
void append_film(pugi::xml_node& header, const LabelsToExport& labels, const fs::path& file) {
  if (labels.film.empty() || !labels.film_begins_us || *labels.film_begins_us > 500) return;
  const fs::path film = fs::absolute(labels.film).lexically_normal();
  const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  const std::string relative = film.lexically_relative(folder).generic_string();
  pugi::xml_node media = append(header, "MEDIA_DESCRIPTOR",
                                {{"MEDIA_URL", "file://" + film.generic_string()},
                                 {"MIME_TYPE", "video/mp4"},
                                 {"RELATIVE_MEDIA_URL", relative.starts_with("../") ? relative : "./" + relative}});
  const std::int64_t origin_ms = nearest_ms(saturating_subtract(0, *labels.film_begins_us));
  if (origin_ms > 0) media.append_attribute("TIME_ORIGIN") = std::to_string(origin_ms).c_str();
}

void append_vocabulary(pugi::xml_node& document) {
  pugi::xml_node vocabulary = append(document, "CONTROLLED_VOCABULARY", {{"CV_ID", touch_tier}});
  append(vocabulary, "DESCRIPTION", {{"LANG_REF", undetermined_language}});
  for (const char* value : {"press", "slip", "press ok", "slip ok"}) {
    std::string id = std::string("cve-") + value;
    std::replace(id.begin(), id.end(), ' ', '-');
    pugi::xml_node entry = append(vocabulary, "CV_ENTRY_ML", {{"CVE_ID", id}});
    append(
        entry, "CVE_VALUE",
        {{"DESCRIPTION", std::string(value).ends_with("ok") ? "looked at by a person" : ""}, {"LANG_REF", undetermined_language}})
        .text() = value;
  }
}

std::string property(const pugi::xml_node& header, std::string_view name) {
  for (const pugi::xml_node node : header.children("PROPERTY")) {
    if (node.attribute("NAME").value() == name) return node.text().get();
  }
  return {};
}

std::optional<FileTimes> times_in(const pugi::xml_node& header, const std::string& where) {
  const std::string name = property(header, "tactile-origin");
  if (name.empty()) return std::nullopt;
  const std::optional<TimeOrigin> origin = time_origin_named(name);
  const std::string zero_text = property(header, "tactile-zero-s"), drift_text = property(header, "tactile-drift-ppm");
  const std::optional<ReadSeconds> zero = seconds_in(zero_text.empty() ? "0" : zero_text);
  const std::optional<double> drift = number_in(drift_text.empty() ? "0" : drift_text);
  if (!origin || !zero || !drift || !(std::abs(*drift) < 1e5)) {
    throw Error(
        fmt::format("{}: its properties do not give the origin of its times ({}, {}, {}); expected tactile-origin, "
                    "tactile-zero-s and tactile-drift-ppm as they were exported",
                    where, shown_text(name), shown_text(zero_text), shown_text(drift_text)));
  }
  return FileTimes{.origin = *origin, .zero_us = zero->us, .drift_ppm = *drift};
}

std::map<std::string, std::int64_t> slots_in(const pugi::xml_node& document, const std::string& where) {
  std::map<std::string, std::int64_t> slots;
  for (const pugi::xml_node slot : document.child("TIME_ORDER").children("TIME_SLOT")) {
    const std::string value = slot.attribute("TIME_VALUE").value();
    if (value.empty()) continue;  // a time that ELAN has not determined yet
    const std::optional<std::int64_t> ms = whole_number_in(value);
    constexpr std::int64_t most_ms = std::int64_t{1} << 52;
    if (!ms || *ms < 0 || *ms > most_ms) {
      throw Error(fmt::format("{}: time slot {} holds {}; expected whole milliseconds from 0", where,
                              shown_text(slot.attribute("TIME_SLOT_ID").value()), shown_text(value)));
    }
    slots[slot.attribute("TIME_SLOT_ID").value()] = *ms;
    check_count(slots.size(), 2 * most_imported_intervals, "time slots", where);
  }
  return slots;
}

}  // namespace

std::string elan_text(const LabelsToExport& labels, const fs::path& file) {
  check_ids(labels);
  const std::vector<Annotation> touches = touches_of(labels);
  pugi::xml_document xml;
  pugi::xml_node declaration = xml.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node document = append(xml, "ANNOTATION_DOCUMENT",
                                   {{"AUTHOR", "tactile"},
                                    {"DATE", date_text(labels.written_s)},
                                    {"FORMAT", "3.0"},
                                    {"VERSION", "3.0"},
                                    {"xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"},
                                    {"xsi:noNamespaceSchemaLocation", "http://www.mpi.nl/tools/elan/EAFv3.0.xsd"}});
  pugi::xml_node header = append(document, "HEADER", {{"MEDIA_FILE", ""}, {"TIME_UNITS", "milliseconds"}});
  append_film(header, labels, file);
  append_property(header, "lastUsedAnnotationId", "0");
  append_property(header, "tactile-run", labels.run);
  append_property(header, "tactile-origin", std::string(name_of(labels.times.origin)));
  append_property(header, "tactile-zero-s", seconds_text(labels.times.zero_us));
  append_property(header, "tactile-drift-ppm", fmt::format("{}", labels.times.drift_ppm));
  if (const std::string doubts = doubts_of(labels.labels, std::nullopt); !doubts.empty())
    append_property(header, "tactile-flags", doubts);

  append_tiers(document, {{touch_tier, touch_tier, touches},
                          {"onset 95 %", "remark", onsets_of(labels)},
                          {"doubts", "remark", doubts_of_all(labels, touches)}});
  append(document, "LINGUISTIC_TYPE",
         {{"CONTROLLED_VOCABULARY_REF", touch_tier},
          {"GRAPHIC_REFERENCES", "false"},
          {"LINGUISTIC_TYPE_ID", touch_tier},
          {"TIME_ALIGNABLE", "true"}});
  append(document, "LINGUISTIC_TYPE",
         {{"GRAPHIC_REFERENCES", "false"}, {"LINGUISTIC_TYPE_ID", "remark"}, {"TIME_ALIGNABLE", "true"}});
  append(document, "LANGUAGE", {{"LANG_ID", undetermined_language}, {"LANG_LABEL", "undetermined (und)"}});
  append_vocabulary(document);
  std::ostringstream text;
  xml.save(text, "  ", pugi::format_indent, pugi::encoding_utf8);
  return text.str();
}

ImportedLabels read_elan(const fs::path& path) {
  const std::string file = path.string();
  const std::string text = read_text(path, std::size_t{8} << 20);
  if (text.find("<!DOCTYPE") != std::string::npos || text.find("<!ENTITY") != std::string::npos)
    throw Error(file + ": declares a document type or entities; expected an annotation document as ELAN saves it");
  pugi::xml_document xml;
  if (const auto parsed = xml.load_buffer(text.data(), text.size()); !parsed)
    throw Error(fmt::format("{}: is not XML ({}); expected an annotation document of ELAN", file, parsed.description()));
  const pugi::xml_node document = xml.child("ANNOTATION_DOCUMENT");
  const pugi::xml_node header = document.child("HEADER");
  if (!document) throw Error(file + ": is not an annotation document; expected ELAN's <ANNOTATION_DOCUMENT>");
  if (const std::string units = header.attribute("TIME_UNITS").as_string("milliseconds"); units != "milliseconds")
    throw Error(fmt::format("{}: its times are in {}; expected milliseconds", file, shown_text(units)));
  ImportedLabels labels{.where = file, .times = times_in(header, file), .earliest_us = 0, .shortest_us = 1'000};
  if (const std::string run = property(header, "tactile-run"); !run.empty()) labels.run = run;

  const std::map<std::string, std::int64_t> slots = slots_in(document, file);
  const pugi::xml_node tier = document.find_child_by_attribute("TIER", "TIER_ID", touch_tier);
  if (!tier) throw Error(fmt::format("{}: has no tier '{}'; expected one with press and slip", file, touch_tier));
  constexpr std::int64_t us_per_ms = 1000;
  for (const pugi::xml_node node : tier.children("ANNOTATION")) {
    const pugi::xml_node annotation = node.child("ALIGNABLE_ANNOTATION");
    if (!annotation) continue;
    const std::string id = annotation.attribute("ANNOTATION_ID").value();
    ImportedInterval interval{.start_rounding_us = us_per_ms,
                              .end_rounding_us = us_per_ms,
                              .where = fmt::format("{}, annotation {}", file, shown_text(id))};
    const auto time_of = [&](const char* reference) {
      const auto slot = slots.find(annotation.attribute(reference).value());
      if (slot == slots.end()) {
        throw Error(fmt::format("{} has no time ({}); expected an annotation with its own start and end", interval.where,
                                shown_text(annotation.attribute(reference).value())));
      }
      return slot->second * us_per_ms;
    };
    interval.start_us = time_of("TIME_SLOT_REF1");
    interval.end_us = time_of("TIME_SLOT_REF2");
    read_words(annotation.child_value("ANNOTATION_VALUE"), interval.where, interval);
    interval.id = id;
    labels.intervals.push_back(std::move(interval));
    check_count(labels.intervals.size(), most_imported_intervals, "annotations", path);
  }
  return labels;
}

}  // namespace tactile::labels
