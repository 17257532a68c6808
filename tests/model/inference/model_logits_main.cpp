#include <cstdio>
#include <exception>

#include "tactile/core/whole_file.hpp"
#include "tactile/model/training/open_classifier.hpp"

/// model_logits BUNDLE HEATMAPS LOGITS: reads heatmaps as they lie in memory, uint8 [n, height, width], and writes what the model
/// gives for them, float32 [n, 3] of none, press, slip. For comparison with other software that runs the same model.
int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "model_logits: expected BUNDLE HEATMAPS LOGITS\n");
    return 1;
  }
  try {
    const bool usual = tactile::model::read_description({argv[1]}).settings.network.is_fast();
    const auto classifier = tactile::model::open_classifier(
        argv[1], 0, usual ? tactile::model::EngineKind::fast : tactile::model::EngineKind::libtorch);
    const std::string text = tactile::read_text(argv[2]);
    const auto logits = classifier.classify({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    tactile::write_whole(argv[3], {reinterpret_cast<const char*>(logits.data()), logits.size() * sizeof(tactile::model::Logits)});
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "model_logits: %s\n", e.what());
    return 1;
  }
}
