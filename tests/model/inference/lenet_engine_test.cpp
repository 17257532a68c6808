#include "tactile/model/inference/lenet_engine.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/model/training/lenet.hpp"

namespace {

std::atomic<std::size_t> allocations{0};

/// Of the process, as the allocator knows them.
std::size_t bytes_held() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

void* counted(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return counted(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(bytes);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) { return counted(bytes, static_cast<std::size_t>(alignment)); }
// Not inlined: GCC would see `free` called on what came from `new`, and warn.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace tactile::model {
namespace {

constexpr events::SensorSize usual{128, 96};
constexpr std::array precisions{Precision::fp32, Precision::bf16, Precision::int8};
/// The smallest, odd ones each way, narrower and wider than a vector, those that leave rows and columns unread.
constexpr std::array<events::SensorSize, 9> sizes{
    {{16, 16}, {17, 16}, {16, 19}, {23, 31}, {36, 16}, {45, 37}, {69, 52}, {128, 96}, {200, 17}}};

std::size_t cells_of(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

using Heatmap = std::vector<std::uint8_t>;

/// Each cell lit with this probability.
Heatmap noise(events::SensorSize size, double density, Random& random) {
  Heatmap heatmap(cells_of(size));
  for (std::uint8_t& cell : heatmap)
    cell = static_cast<double>(random.below(1'000'000)) < density * 1e6 ? static_cast<std::uint8_t>(1 + random.below(255))
                                                                        : std::uint8_t{0};
  return heatmap;
}

/// All densities, then the extremes: nothing lit, all lit, one pixel at each corner and in the middle.
std::vector<Heatmap> heatmaps_of(events::SensorSize size, std::uint64_t seed) {
  Random random(seed);
  std::vector<Heatmap> heatmaps;
  for (const double density : {0.0005, 0.002, 0.01, 0.03, 0.1, 0.3, 0.7, 1.0}) heatmaps.push_back(noise(size, density, random));
  heatmaps.emplace_back(cells_of(size), std::uint8_t{0});
  heatmaps.emplace_back(cells_of(size), std::uint8_t{255});
  const auto width = static_cast<std::size_t>(size.width);
  for (const std::size_t pixel :
       {std::size_t{0}, width - 1, cells_of(size) - width, cells_of(size) - 1, cells_of(size) / 2 + width / 2}) {
    heatmaps.emplace_back(cells_of(size), std::uint8_t{0});
    heatmaps.back()[pixel] = 255;
  }
  return heatmaps;
}

Weights random_weights(events::SensorSize size, std::uint64_t seed) { return LeNet(size, seed).weights(); }

void scale(Weights& weights, const std::string& layer, float by) {
  for (Parameter& parameter : weights) {
    if (parameter.shape.name.starts_with(layer + ".")) {
      for (float& value : parameter.values) value *= by;
    }
  }
}

/// The largest difference, of the largest logit.
double difference(const Logits& ours, const Logits& theirs) {
  double apart = 0, largest = 0;
  for (std::size_t i = 0; i < touch_count; ++i) {
    apart = std::max(apart, std::abs(static_cast<double>(ours[i]) - static_cast<double>(theirs[i])));
    largest = std::max(largest, std::abs(static_cast<double>(theirs[i])));
  }
  return apart / largest;
}

void expect_like_libtorch(events::SensorSize size, const Weights& weights, const std::vector<Heatmap>& heatmaps,
                          const std::string& target, const std::string& what) {
  const LeNet reference(size, weights);
  LeNetEngine engine(size, weights, {}, {.target = target});
  for (std::size_t i = 0; i < heatmaps.size(); ++i) {
    const Logits expected = reference.logits(heatmaps[i], 1).front();
    EXPECT_LE(difference(engine.classify(heatmaps[i]), expected), 1e-5)
        << what << ", " << target << ", " << size.width << " x " << size.height << ", heatmap " << i;
  }
}

std::string error_of(events::SensorSize size, const Weights& weights, const LeNetOptions& layers = {},
                     const EngineOptions& options = {}) {
  try {
    const LeNetEngine engine(size, weights, layers, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(LeNetEngine, PredictsLikeLibtorchWithEveryVectorInstructionAndSize) {
  ASSERT_GE(LeNetEngine::targets().size(), 2U) << "only one set of instructions is tested";
  for (const std::string& target : LeNetEngine::targets()) {
    for (std::size_t i = 0; i < sizes.size(); ++i)
      expect_like_libtorch(sizes[i], random_weights(sizes[i], i), heatmaps_of(sizes[i], i), target, "random weights");
  }
}

TEST(LeNetEngine, PredictsLikeLibtorchWithOtherWeights) {
  for (std::uint64_t seed = 1; seed < 8; ++seed) {
    Weights weights = random_weights(usual, seed);
    scale(weights, "conv1", 3);  // as training spreads them
    scale(weights, "fc1", 4);
    expect_like_libtorch(usual, weights, heatmaps_of(usual, seed), "", "seed " + std::to_string(seed));
  }
}

TEST(LeNetEngine, DistinguishesHeatmaps) {
  LeNetEngine engine(usual, random_weights(usual, 3));
  const auto heatmaps = heatmaps_of(usual, 3);
  for (std::size_t i = 0; i < heatmaps.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(engine.classify(heatmaps[i]), engine.classify(heatmaps[k])) << i << ", " << k;
  }
}

TEST(LeNetEngine, SkipsWhatIsEmptyToTheSameBits) {
  for (const std::string& target : LeNetEngine::targets()) {
    for (const Precision precision : precisions) {
      for (const events::SensorSize size : sizes) {
        const Weights weights = random_weights(size, 5);
        LeNetEngine sparse(size, weights, {}, {precision, true, target}), dense(size, weights, {}, {precision, false, target});
        auto heatmaps = heatmaps_of(size, 6);
        const auto before = heatmaps;
        heatmaps.insert(heatmaps.end(), before.rbegin(), before.rend());  // a heatmap must not affect the next
        for (const Heatmap& heatmap : heatmaps) {
          ASSERT_EQ(sparse.classify(heatmap), dense.classify(heatmap)) << target << ", " << size.width << " x " << size.height;
          LeNetEngine fresh(size, weights, {}, {precision, true, target});
          ASSERT_EQ(sparse.classify(heatmap), fresh.classify(heatmap)) << target << ", " << size.width << " x " << size.height;
        }
      }
    }
  }
}

TEST(LeNetEngine, FollowsAPixelThatWanders) {
  constexpr events::SensorSize size{45, 37};
  const Weights weights = random_weights(size, 2);
  LeNetEngine sparse(size, weights), dense(size, weights, {}, {.skip_empty = false});
  Heatmap heatmap(cells_of(size));
  for (std::size_t i = 0; i < heatmap.size(); ++i) {
    heatmap[i] = 200;
    ASSERT_EQ(sparse.classify(heatmap), dense.classify(heatmap)) << "pixel " << i;
    heatmap[i] = 0;
  }
}

TEST(LeNetEngine, AllocatesNothingToClassify) {
  for (const Precision precision : precisions) {
    LeNetEngine engine(usual, random_weights(usual, 1), {}, {.precision = precision});
    const auto heatmaps = heatmaps_of(usual, 1);
    const std::size_t before = allocations;
    float sum = 0;
    for (const Heatmap& heatmap : heatmaps) sum += engine.classify(heatmap)[0];
    EXPECT_EQ(allocations, before);
    EXPECT_NE(sum, 0.0F);
  }
  const std::size_t before = allocations;
  const Heatmap seen(3);
  EXPECT_EQ(allocations, before + 1) << "allocations are not counted";
}

TEST(LeNetEngine, CopiesAnswerOnThreadsOfTheirOwn) {
  const auto heatmaps = heatmaps_of(usual, 9);
  LeNetEngine engine(usual, random_weights(usual, 9));
  std::vector<Logits> expected;
  expected.reserve(heatmaps.size());
  for (const Heatmap& heatmap : heatmaps) expected.push_back(engine.classify(heatmap));
  std::array<std::size_t, 2> wrong{};
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t) {
      threads.emplace_back([&, t, own = engine]() mutable {
        for (std::size_t i = 0; i < 20 * heatmaps.size(); ++i) {
          const std::size_t k = (i * (t + 3) + t) % heatmaps.size();
          if (own.classify(heatmaps[k]) != expected[k]) ++wrong[t];
        }
      });
    }
  }
  EXPECT_EQ(wrong, (std::array<std::size_t, 2>{}));
  LeNetEngine assigned(usual, random_weights(usual, 1));
  assigned = engine;
  EXPECT_EQ(assigned.classify(heatmaps[4]), expected[4]);
}

TEST(LeNetEngine, KeepsNineTenthsOfItsWeightsInBytesWhereAsked) {
  const auto heatmaps = heatmaps_of(usual, 4);
  const LeNet reference(usual, 4);
  LeNetEngine exact(usual, reference.weights()), bytes(usual, reference.weights(), {}, {.precision = Precision::int8});
  double largest = 0;
  for (const Heatmap& heatmap : heatmaps) {
    const Logits expected = reference.logits(heatmap, 1).front();
    EXPECT_LE(difference(bytes.classify(heatmap), expected), 0.02);
    largest = std::max(largest, difference(bytes.classify(heatmap), expected));
    EXPECT_LE(difference(exact.classify(heatmap), expected), 1e-5);
  }
  EXPECT_GT(largest, 1e-5) << "weights of 8 bits cannot be that exact";
}

TEST(LeNetEngine, RoundsTheBigLayerToTheNearestBfloat16) {
  // 8 bits of each number, by the rounding of double to whole numbers: to the nearest, of two the even one.
  const auto rounded = [](float value) {
    int exponent = 0;
    const double bits = std::nearbyint(std::frexp(static_cast<double>(value), &exponent) * 256);
    return static_cast<float>(std::ldexp(bits, exponent - 8));
  };
  ASSERT_EQ(rounded(1 + 1.0F / 256), 1.0F);
  ASSERT_EQ(rounded(1 + 3.0F / 256), 1 + 4.0F / 256);
  Weights exact = random_weights(usual, 12);
  std::vector<float>& big = exact[4].values;
  ASSERT_EQ(exact[4].shape.name, "fc1.weight");
  big[0] = 1 + 1.0F / 256, big[1] = -1 - 3.0F / 256, big[2] = 0;
  Weights coarse = exact;
  std::transform(big.begin(), big.end(), coarse[4].values.begin(), rounded);
  for (const std::string& target : LeNetEngine::targets()) {
    LeNetEngine halves(usual, exact, {}, {.precision = Precision::bf16, .target = target});
    LeNetEngine floats(usual, coarse, {}, {.target = target}), unrounded(usual, exact, {}, {.target = target});
    double largest = 0;
    for (const Heatmap& heatmap : heatmaps_of(usual, 12)) {
      ASSERT_EQ(halves.classify(heatmap), floats.classify(heatmap)) << target;
      largest = std::max(largest, difference(halves.classify(heatmap), unrounded.classify(heatmap)));
    }
    EXPECT_GT(largest, 1e-5) << "nothing was rounded";
    EXPECT_LT(largest, 0.01);
  }
}

TEST(LeNetEngine, RoundsTheLargestWeightsToFiniteOnes) {
  Weights weights = random_weights(usual, 13);
  scale(weights, "conv2", 1e-4F);
  std::fill(weights[3].values.begin(), weights[3].values.end(), 0.0F);
  weights[4].values[0] = std::numeric_limits<float>::max();
  weights[4].values[1] = -std::numeric_limits<float>::max();
  scale(weights, "fc2", 1e-30F);
  for (const std::string& target : LeNetEngine::targets()) {
    LeNetEngine rounded(usual, weights, {}, {.precision = Precision::bf16, .target = target}), exact(usual, weights);
    for (const Heatmap& heatmap : heatmaps_of(usual, 13))
      EXPECT_LE(difference(rounded.classify(heatmap), exact.classify(heatmap)), 0.01) << target;
  }
}

TEST(LeNetEngine, HoldsOnlyTheWeightsOfItsPrecision) {
  const Weights weights = random_weights(usual, 1);
  std::array<std::size_t, 3> held{};
  for (std::size_t i = 0; i < precisions.size(); ++i) {
    const std::size_t before = bytes_held();
    const LeNetEngine engine(usual, weights, {}, {.precision = precisions[i]});
    held[i] = bytes_held() - before;
  }
  const std::size_t big_layer = std::size_t{9744} * 128;
  EXPECT_NEAR(static_cast<double>(held[0] - held[1]), 2.0 * big_layer, 0.05 * big_layer);
  EXPECT_NEAR(static_cast<double>(held[0] - held[2]), 3.0 * big_layer, 0.05 * big_layer);
}

TEST(LeNetEngine, KnowsWeightsThatAreWholeNumbersOfAByteExactly) {
  Weights weights = random_weights(usual, 8);
  Random random(8);
  for (Parameter& parameter : weights) {
    if (parameter.shape.name != "fc1.weight") continue;
    for (float& value : parameter.values) value = static_cast<float>(static_cast<int>(random.below(255)) - 127) / 1024;
    for (std::size_t i = 0; i < 120; ++i) parameter.values[i * parameter.values.size() / 120] = 127.0F / 1024;
  }
  const LeNet reference(usual, weights);
  LeNetEngine bytes(usual, weights, {}, {.precision = Precision::int8});
  for (const Heatmap& heatmap : heatmaps_of(usual, 8))
    EXPECT_LE(difference(bytes.classify(heatmap), reference.logits(heatmap, 1).front()), 1e-5);
}

TEST(LeNetEngine, TakesWeightsNearFloatsEnds) {
  for (const auto& [large, small] : {std::pair{"conv1", "conv2"}, {"conv2", "fc1"}, {"fc1", "fc2"}, {"fc3", "conv1"}}) {
    for (const float by : {1e30F, 1e-30F}) {
      Weights weights = random_weights(usual, 3);
      scale(weights, large, by);
      scale(weights, small, 1 / by);
      expect_like_libtorch(usual, weights, heatmaps_of(usual, 3), "", std::string(large) + " scaled");
    }
  }
}

TEST(LeNetEngine, TakesOneLayerOfHugeOrTinyWeights) {
  for (const char* layer : {"conv1", "conv2", "fc1", "fc2", "fc3"}) {
    for (const float by : {1e30F, 1e-30F}) {
      Weights weights = random_weights(usual, 5);
      scale(weights, layer, by);
      for (const std::string& target : LeNetEngine::targets())
        expect_like_libtorch(usual, weights, heatmaps_of(usual, 5), target, std::string(layer) + " alone scaled");
      for (const Precision precision : precisions) {
        LeNetEngine engine(usual, weights, {}, {.precision = precision});
        for (const Heatmap& heatmap : heatmaps_of(usual, 5)) {
          for (const float logit : engine.classify(heatmap)) ASSERT_TRUE(std::isfinite(logit)) << layer;
        }
      }
    }
  }
}

TEST(LeNetEngine, TakesTinyWeightsEverywhere) {
  // The outputs of a layer vanish against the next one's bias, so the last bias is the result.
  Weights weights = random_weights(usual, 5);
  for (const char* layer : {"conv1", "conv2", "fc1", "fc2", "fc3"}) scale(weights, layer, 1e-30F);
  expect_like_libtorch(usual, weights, heatmaps_of(usual, 5), "", "all scaled");
  LeNetEngine engine(usual, weights);
  const std::vector<float>& bias = weights.back().values;
  const auto largest = std::max_element(bias.begin(), bias.end()) - bias.begin();
  for (const Heatmap& heatmap : heatmaps_of(usual, 5))
    EXPECT_EQ(verdict_of(engine.classify(heatmap)), all_touches[static_cast<std::size_t>(largest)]);
}

TEST(LeNetEngine, TakesWeightsThatAreAllZero) {
  Weights weights = random_weights(usual, 3);
  for (Parameter& parameter : weights) std::fill(parameter.values.begin(), parameter.values.end(), 0.0F);
  for (const Precision precision : precisions) {
    LeNetEngine engine(usual, weights, {}, {.precision = precision});
    for (const Heatmap& heatmap : heatmaps_of(usual, 3)) EXPECT_EQ(engine.classify(heatmap), Logits{});
  }
}

TEST(LeNetEngine, RefusesSumsThatMayLeaveFloat) {
  Weights weights = random_weights(usual, 3);
  scale(weights, "conv1", 1e30F);
  EXPECT_EQ(error_of(usual, weights), "");
  scale(weights, "fc1", 1e10F);
  EXPECT_NE(error_of(usual, weights).find("up to fc1.weight they are so large"), std::string::npos) << error_of(usual, weights);
}

TEST(LeNetEngine, RefusesWeightsThatAreNotFinite) {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()}) {
    for (std::size_t i = 0; i < 10; ++i) {
      Weights weights = random_weights({16, 16}, 3);
      weights[i].values.back() = value;
      std::string last = "[";
      for (const std::int64_t size : weights[i].shape.sizes) last += (last.size() > 1 ? "," : "") + std::to_string(size - 1);
      EXPECT_EQ(error_of({16, 16}, weights),
                "weights: " + weights[i].shape.name + last + "] is " + std::to_string(value) + "; expected finite weights");
    }
  }
}

TEST(LeNetEngine, RefusesLayersThatItDoesNotKnow) {
  const Weights weights = random_weights(usual, 3);
  for (const LeNetOptions layers : {LeNetOptions{.activation = Activation::tanh}, LeNetOptions{.activation = Activation::sigmoid},
                                    LeNetOptions{.pooling = Pooling::average}}) {
    EXPECT_NE(error_of(usual, weights, layers).find("--engine libtorch"), std::string::npos) << name_of(layers.activation);
  }
}

TEST(LeNetEngine, RefusesWeightsOfAnotherShape) {
  EXPECT_NE(error_of(usual, random_weights({64, 48}, 3)).find("expected fc1.weight [120,9744]"), std::string::npos);
  Weights weights = random_weights(usual, 3);
  weights.pop_back();
  EXPECT_NE(error_of(usual, weights).find("not of this network"), std::string::npos);
  EXPECT_NE(error_of({15, 16}, weights).find("15 x 16"), std::string::npos);
  EXPECT_NE(error_of(usual, random_weights(usual, 3), {}, {.target = "abacus"}).find("expected one of "), std::string::npos);
}

TEST(LeNetEngine, RefusesAHeatmapOfAnotherSize) {
  LeNetEngine engine(usual, random_weights(usual, 3));
  EXPECT_THROW(engine.classify(Heatmap(128 * 96 - 1)), Error);
  EXPECT_THROW(engine.classify({}), Error);
}

TEST(PrecisionNames, AreReadBack) {
  for (const Precision precision : precisions) EXPECT_EQ(precision_named(name_of(precision)), precision);
  EXPECT_THROW(precision_named("int4"), Error);
}

}  // namespace
}  // namespace tactile::model
