#include "tactile/evaluation/run_prediction.hpp"

#include <fstream>

#include "tactile/core/csv_table.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/model/inference/tick_cells.hpp"

namespace tactile::evaluation {
namespace {

std::string_view truth_name(CameraTime tick, const RunTruth& truth) {
  const Touch touch = touch_at(tick, truth.true_ones);
  return touch == Touch::none && touch_at(tick, truth.unlabelled) != Touch::none ? "unlabelled" : name_of(touch);
}

/// The time of the recording's first event; nothing without events.
std::optional<CameraTime> first_event_of(const std::filesystem::path& recording) {
  const events::RecordingReader reader(recording);
  const int stream = events::event_stream(reader).id;
  for (const events::PacketRecord& packet : reader.packets()) {
    if (packet.stream_id == stream && packet.elements > 0) return packet.first;
  }
  return std::nullopt;
}

}  // namespace

RunPrediction predict_run(const RunFolder& run, const model::Classifier& classifier, const PredictionOptions& options,
                          const std::function<void(std::size_t)>& advance) {
  RunPrediction prediction;
  prediction.run = run.name();
  prediction.simulated = events::is_simulated(run);
  prediction.first_event = first_event_of(run.events());
  prediction.truth = read_run_truth(run, options.include_flagged);
  if (options.by_truth) prediction.truth = with_truth_as_labels(prediction.truth);
  prediction.full =
      classify_full_run(run.events(), classifier, {.threads = options.threads, .advance = advance, .change = options.change});
  prediction.decision = options.decision;
  prediction.verdicts = decided(options.decision, prediction.full);
  const TickRange& ticks = prediction.full.ticks;
  const RunTruth& truth = prediction.truth;
  prediction.detections = detections_of(ticks, prediction.verdicts, truth.used(), options.delay);
  if (truth.has_truth) prediction.true_detections = detections_of(ticks, prediction.verdicts, truth.true_ones, options.delay);
  prediction.judged = RunJudge(ticks, course_of(truth), options.delay).judged(prediction.verdicts);
  prediction.judged.world = truth.world;
  prediction.judged.object = run.object;
  prediction.judged.run = run.run;
  return prediction;
}

nlohmann::json outcome_json(const RunPrediction& prediction) {
  nlohmann::json json{{"run", prediction.run},
                      {"simulated", prediction.simulated},
                      {"tick_ms", in_ms(prediction.full.ticks.tick)},
                      {"first_event_us", nullptr},
                      {"confirm", text_of(prediction.decision.confirmation)},
                      {"thresholds", nullptr},
                      {"intervals", nlohmann::json::array()},
                      {"true_intervals", nullptr},
                      {"whole_run", nullptr}};
  if (prediction.first_event) json["first_event_us"] = us_of(*prediction.first_event);
  if (prediction.decision.thresholds) json["thresholds"] = text_of(*prediction.decision.thresholds);
  std::size_t next = 0;  // detections are of the labels in use, in their order
  for (const windows::SampledInterval& label : prediction.truth.labels) {
    if (label.used && next < prediction.detections.size()) {
      json["intervals"].push_back(prediction.detections[next++]);
      continue;
    }
    json["intervals"].push_back({{"class", name_of(label.interval.touch)},
                                 {"start_us", us_of(label.interval.start)},
                                 {"end_us", us_of(label.interval.end)},
                                 {"outcome", "in doubt"},
                                 {"delay_ms", nullptr}});
  }
  if (prediction.truth.has_truth) json["true_intervals"] = prediction.true_detections;
  if (prediction.truth.is_known()) json["whole_run"] = prediction.judged;
  return json;
}

void write_prediction(const std::filesystem::path& file, const RunPrediction& prediction,
                      const std::map<CameraTime, Touch>& samples) {
  const std::vector<TouchInterval> labels = prediction.truth.all_labelled();
  WholeFile whole(file, IfThere::replace);
  std::ofstream out(whole.path(), std::ios::binary);
  out << model::tick_columns << ",label,truth,events,sample\n";
  for (std::size_t k = 0; k < prediction.verdicts.size(); ++k) {
    const CameraTime t = prediction.full.ticks.at(static_cast<std::int64_t>(k));
    const auto sample = samples.find(t);
    out << csv_row(model::tick_cells(t, prediction.full.probabilities[k], prediction.verdicts[k]),
                   labels.empty() ? "" : name_of(touch_at(t, labels)),
                   prediction.truth.has_truth ? truth_name(t, prediction.truth) : "", prediction.full.events[k],
                   sample == samples.end() ? "" : name_of(sample->second))
        << '\n';
  }
  out.close();
  if (!out) throw Error(file.string() + ": cannot be written; expected a disk with room");
  whole.commit();
}

}  // namespace tactile::evaluation
