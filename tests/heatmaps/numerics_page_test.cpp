// The table of docs/numerics/heatmaps.md: the plain equations 2 to 5 in float32, compared with the rendered values, for inputs
// that break the former. Each of its rows is worked out here, so that the page stays true.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <string>

#include "heatmaps/rendered_heatmap.hpp"
#include "support/paths.hpp"

namespace tactile::heatmaps {
namespace {

using Counts = std::vector<std::uint32_t>;
using Naive = std::vector<float>;

float mean_of(const Naive& counts) {
  float sum = 0, active = 0;
  for (const float count : counts) sum += count, active += count > 0 ? 1.0F : 0.0F;
  return sum / active;
}

/// D of each pixel, scaled to its maximum.
Naive scaled(const Naive& counts, const std::function<float(float)>& d) {
  Naive denoised;
  float largest = 0;
  for (const float count : counts) denoised.push_back(d(count)), largest = std::fmax(largest, denoised.back());
  for (float& value : denoised) value = 255.0F * value / largest;
  return denoised;
}

Naive as_printed(const Naive& counts) {
  const float b = mean_of(counts);
  return scaled(counts, [b](float e) { return e / (1.0F + std::exp(e + b)); });
}

Naive as_printed_in_double(const Naive& counts) {
  const double b = mean_of(counts);
  std::vector<double> denoised;
  for (const float e : counts) denoised.push_back(e / (1.0 + std::exp(e + b)));
  const double largest = *std::max_element(denoised.begin(), denoised.end());
  Naive values;
  for (const double d : denoised) values.push_back(static_cast<float>(255.0 * d / largest));
  return values;
}

Naive in_text(const Naive& counts) {
  const float b = mean_of(counts);
  return scaled(counts, [b](float e) { return e / (1.0F + std::exp(e - b)); });
}

Naive in_text_by_the_other_sigmoid(const Naive& counts) {
  const float b = mean_of(counts);
  return scaled(counts, [b](float e) { return e * std::exp(b - e) / (1.0F + std::exp(b - e)); });
}

Naive none(const Naive& counts) {
  return scaled(counts, [](float e) { return e; });
}

std::string text_of(float value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", static_cast<double>(value));
  return std::isnan(value) ? "NaN" : text.data();
}

/// Of a sensor of so many pixels in a row, each a cell of its own.
template <class T>
std::vector<T> heatmap_of(const Counts& counts, Denoise denoise) {
  std::vector<test::Hits> pixels;
  for (std::size_t i = 0; i < counts.size(); ++i) pixels.push_back({.x = static_cast<int>(i), .count = counts[i]});
  const events::SensorSize sensor{static_cast<int>(counts.size()), 1};
  const HeatmapOptions options{.denoise = denoise, .factor = 1};
  EXPECT_TRUE(test::is_true(pixels, sensor, options));
  return test::rendered<T>(pixels, sensor, options);
}

Naive as_floats(const Counts& counts) { return {counts.begin(), counts.end()}; }

struct Row {
  std::string input, naively, naive_result, result;
};

Row row(const std::string& input, const std::string& naively, const Counts& counts, std::size_t shown, Denoise denoise,
        const std::function<Naive(const Naive&)>& naive) {
  return {input, naively, text_of(naive(as_floats(counts))[shown]), text_of(heatmap_of<float>(counts, denoise)[shown])};
}

std::vector<Row> rows() {
  std::vector<Row> rows;
  rows.push_back(row("`literal`; one pixel with 45 events", "`exp(E + b)` is infinite, so every D is 0, and 0 / 0", {45}, 0,
                     Denoise::literal, as_printed));
  rows.push_back(
      row("`literal`; pixels with 60 and 61 events; the second", "the same", {60, 61}, 1, Denoise::literal, as_printed));
  rows.push_back(row("`literal`; pixels with 400 and 401 events; the second", "the same in double", {400, 401}, 1,
                     Denoise::literal, as_printed_in_double));
  rows.push_back(row("`mean`; pixels with 1 and 200 events; the first", "σ(z) written e^z / (1 + e^z) is infinite by infinite",
                     {1, 200}, 0, Denoise::mean, in_text_by_the_other_sigmoid));
  Counts nearly_alike(30, 1'000'000);
  nearly_alike.push_back(1'000'003);
  rows.push_back(row("`mean`; 30 pixels with 1 000 000 events and one with 1 000 003; the last",
                     "the sum is beyond 2²⁴, b at 10⁶ has steps of 1/16: the exponent is off by 0.03", nearly_alike, 30,
                     Denoise::mean, in_text));
  const Counts hot{65'536, 1};
  Naive in_16_bits;
  for (const std::uint32_t count : hot) in_16_bits.push_back(static_cast<float>(static_cast<std::uint16_t>(count)));
  rows.push_back({"`none`; a pixel with 65 536 events beside one with 1; the first", "counted in 16 bits it has none",
                  text_of(none(in_16_bits)[0]), text_of(heatmap_of<float>(hot, Denoise::none)[0])});
  const Counts half{510, 1};
  rows.push_back({"`none`; pixels with 510 and 1 events; the byte of the second, 0.5 before it is rounded",
                  "`cvRound`, `lrint`, `convertTo` round halves to the even number",
                  std::to_string(std::lrint(none(as_floats(half))[1])),
                  std::to_string(heatmap_of<std::uint8_t>(half, Denoise::none)[1])});

  // An event just before a tick near the beginning of the clock.
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min();
  const auto begin = static_cast<std::int64_t>(static_cast<std::uint64_t>(first + 1'000) - 40'000U);  // wraps, as int64 would
  HeatmapRenderer renderer({1, 1}, {.factor = 1});
  renderer.add(std::vector{events::Event{.t = camera_time(first + 999)}});
  renderer.move_to(camera_time(first + 1'000));
  rows.push_back({"an event at −2⁶³ + 999 µs, t_c = −2⁶³ + 1000 µs, t_h = 40 ms; the event's pixel",
                  "t_c − t_h wraps to the clock's other end", begin <= first + 999 ? "255" : "0",
                  text_of(test::rendered<float>(renderer)[0])});
  return rows;
}

TEST(NumericsPage, ShowsWhatIsWorkedOutHere) {
  std::ifstream file(std::string(test::data_folder) + "/../../docs/numerics/heatmaps.md");
  std::stringstream page;
  page << file.rdbuf();
  ASSERT_FALSE(page.str().empty());
  for (const Row& each : rows()) {
    const std::string line = "| " + each.input + " | " + each.naively + " | " + each.naive_result + " | " + each.result + " |\n";
    EXPECT_NE(page.str().find(line), std::string::npos) << "docs/numerics/heatmaps.md lacks the row\n" << line;
    EXPECT_NE(each.naive_result, each.result);
  }
}

}  // namespace
}  // namespace tactile::heatmaps
