#include "bag_report.hpp"

#include <fmt/core.h>

#include "quantity_text.hpp"

namespace tactile::cli {
namespace {

nlohmann::json json_of(const bags::TopicContents& topic) {
  nlohmann::json json = {{"name", topic.name},
                         {"type", topic.type},
                         {"messages", topic.messages},
                         {"first_received_us", us_of(topic.first_received)},
                         {"last_received_us", us_of(topic.last_received)}};
  if (!topic.has_events) return json;
  const bool has_any = topic.events > 0;
  json["events"] = {{"encoding", topic.encoding.empty() ? nlohmann::json() : nlohmann::json(topic.encoding)},
                    {"width", topic.size ? nlohmann::json(topic.size->width) : nlohmann::json()},
                    {"height", topic.size ? nlohmann::json(topic.size->height) : nlohmann::json()},
                    {"events", topic.events},
                    {"on_events", topic.on_events},
                    {"triggers", topic.triggers},
                    {"first_us", has_any ? nlohmann::json(us_of(topic.first)) : nlohmann::json()},
                    {"last_us", has_any ? nlohmann::json(us_of(topic.last)) : nlohmann::json()},
                    {"broken_messages", topic.broken_messages},
                    {"outside", topic.outside},
                    {"unplaced", topic.unplaced},
                    {"lost_packets", topic.lost_packets}};
  return json;
}

std::string events_text(const bags::TopicContents& topic) {
  std::string text = counted(topic.events, "event");
  if (topic.size) text += fmt::format(", {}x{}", topic.size->width, topic.size->height);
  if (!topic.encoding.empty()) text += ", " + topic.encoding;
  if (topic.events > 0) text += ", " + duration_text(between(topic.first, topic.last));
  if (topic.triggers > 0) text += ", " + counted(topic.triggers, "trigger");
  return text;
}

}  // namespace

nlohmann::json json_of_bag(const std::string& name, const bags::BagContents& contents) {
  nlohmann::json topics = nlohmann::json::array();
  for (const bags::TopicContents& topic : contents.topics) topics.push_back(json_of(topic));
  const bags::BagProblems& problems = contents.problems;
  return {{"file", name},
          {"format", contents.format},
          {"files", contents.files},
          {"bytes", contents.bytes},
          {"topics", topics},
          {"problems",
           {{"truncated_bytes", problems.truncated_bytes},
            {"broken_chunks", problems.broken_chunks},
            {"broken_records", problems.broken_records},
            {"unknown_messages", problems.unknown_messages}}},
          {"reasons", reasons_of(contents)}};
}

std::string text_of_bag(const std::string& name, const bags::BagContents& contents) {
  const auto line = [](const std::string& label, const std::string& text) { return fmt::format("  {:<10}{}\n", label, text); };
  std::string text = name + "\n";
  text += line("format", fmt::format("{}, {}, {}", contents.format, counted(contents.files, "file"), bytes_text(contents.bytes)));
  for (const bags::TopicContents& topic : contents.topics) {
    text += line(&topic == &contents.topics.front() ? "topics" : "",
                 fmt::format("{}  {}  {}", topic.name, topic.type, counted(topic.messages, "message")));
    if (topic.has_events) text += line("", "  " + events_text(topic));
  }
  const std::vector<std::string> reasons = reasons_of(contents);
  text += line("health", reasons.empty() ? "nothing damaged or lost" : reasons.front());
  for (std::size_t i = 1; i < reasons.size(); ++i) text += line("", reasons[i]);
  return text;
}

std::vector<std::string> reasons_of(const bags::BagContents& contents) {
  std::vector<std::string> reasons;
  const auto say = [&](std::uint64_t count, const char* what, const std::string& happened) {
    if (count > 0) reasons.push_back(counted(count, what) + " " + happened);
  };
  say(contents.problems.truncated_bytes, "byte", "cut off, or after the last whole record");
  say(contents.problems.broken_chunks, "chunk", "cannot be read");
  say(contents.problems.broken_records, "record", "cannot be read");
  say(contents.problems.unknown_messages, "message", "of unknown topics");
  for (const bags::TopicContents& topic : contents.topics) {
    say(topic.broken_messages, "message", "cannot be decoded in " + topic.name);
    say(topic.outside, "event", "outside the sensor in " + topic.name);
    say(topic.unplaced, "event", "before the first time and row in " + topic.name);
    say(topic.lost_packets, "packet", "missing by their sequence numbers in " + topic.name);
  }
  return reasons;
}

}  // namespace tactile::cli
