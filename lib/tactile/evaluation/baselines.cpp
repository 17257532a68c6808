#include "tactile/evaluation/baselines.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

constexpr Eigen::Index inputs = feature_count + 1;
constexpr Eigen::Index others = touch_count - 1;
constexpr Eigen::Index unknowns = inputs * others;

using Vector = Eigen::Vector<double, unknowns>;
using Matrix = Eigen::Matrix<double, unknowns, unknowns>;
using Inputs = Eigen::Vector<double, inputs>;  // standardised features, and 1
using Weights = Eigen::Matrix<double, others, inputs, Eigen::RowMajor>;
using Probabilities = Eigen::Vector<double, touch_count>;

void check_one_each(std::size_t values, std::size_t samples, const char* baseline) {
  if (samples > 0 && values == samples) return;
  throw Error(std::string(baseline) + ": " + std::to_string(values) + " values for " + std::to_string(samples) +
              " training samples; expected at least one sample, and a value for each");
}

void check_whole(std::span<const std::uint8_t> heatmap, events::SensorSize size) {
  if (size.width > 0 && size.height > 0 &&
      heatmap.size() == static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height)) {
    return;
  }
  throw Error("heatmap: " + std::to_string(heatmap.size()) + " cells; expected " + std::to_string(size.width) + " x " +
              std::to_string(size.height));
}

Eigen::Map<const Weights> weights_of(const LogisticBaseline& model) { return Eigen::Map<const Weights>(model.weights[0].data()); }

Probabilities softmax(const Inputs& x, const Weights& weights) {
  Probabilities p;
  p << 0, weights * x;
  p = (p.array() - p.maxCoeff()).exp();
  return p / p.sum();
}

Inputs standardised(const Features& features, const LogisticBaseline& model) {
  using Row = Eigen::Map<const Eigen::Array<double, feature_count, 1>>;
  Inputs x;
  x << (Row(features.data()) - Row(model.mean.data())) / Row(model.deviation.data()), 1;
  return x;
}

double loss_of(std::span<const Inputs> samples, std::span<const Touch> truth, const Weights& weights, double ridge) {
  double loss = 0;
  for (std::size_t n = 0; n < samples.size(); ++n)
    loss -= std::log(std::max(softmax(samples[n], weights)[static_cast<Eigen::Index>(truth[n])], 1e-300));
  return loss / static_cast<double>(samples.size()) + ridge / 2 * weights.squaredNorm();
}

/// Of the loss by the weights, row by row.
struct Derivatives {
  Vector gradient = Vector::Zero();
  Matrix hessian = Matrix::Zero();
};

Derivatives derivatives_of(std::span<const Inputs> samples, std::span<const Touch> truth, const Weights& weights, double ridge) {
  Derivatives derivatives;
  const double share = 1.0 / static_cast<double>(samples.size());
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const Inputs& x = samples[n];
    const Probabilities p = softmax(x, weights);
    for (Eigen::Index c = 0; c < others; ++c) {
      const double error = p[c + 1] - (static_cast<Eigen::Index>(truth[n]) == c + 1 ? 1.0 : 0.0);
      derivatives.gradient.segment<inputs>(c * inputs) += share * error * x;
      for (Eigen::Index d = 0; d < others; ++d) {
        const double spread = share * p[c + 1] * ((c == d ? 1.0 : 0.0) - p[d + 1]);
        derivatives.hessian.block<inputs, inputs>(c * inputs, d * inputs) += spread * x * x.transpose();
      }
    }
  }
  derivatives.gradient += ridge * Vector::Map(weights.data());
  derivatives.hessian.diagonal().array() += ridge;
  return derivatives;
}

void standardise_by(std::span<const Features> features, LogisticBaseline& model) {
  const auto n = static_cast<double>(features.size());
  for (std::size_t i = 0; i < feature_count; ++i) {
    double sum = 0, squares = 0;
    for (const Features& sample : features) sum += sample[i];
    model.mean[i] = sum / n;
    for (const Features& sample : features) squares += (sample[i] - model.mean[i]) * (sample[i] - model.mean[i]);
    const double deviation = std::sqrt(squares / n);
    model.deviation[i] = deviation > 1e-12 * (1 + std::abs(model.mean[i])) ? deviation : 1.0;
  }
}

}  // namespace

Features moments_of(std::span<const std::uint8_t> heatmap, events::SensorSize size) {
  check_whole(heatmap, size);
  double active = 0, sum = 0, squares = 0, largest = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_yy = 0, sum_xy = 0;
  for (int row = 0; row < size.height; ++row) {
    const double y = (row + 0.5) / size.height;
    for (int column = 0; column < size.width; ++column) {
      const std::uint8_t cell =
          heatmap[static_cast<std::size_t>(row) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(column)];
      if (cell == 0) continue;
      const double value = cell / 255.0, x = (column + 0.5) / size.width;
      active += 1;
      sum += value;
      squares += value * value;
      largest = std::max(largest, value);
      sum_x += value * x;
      sum_y += value * y;
      sum_xx += value * x * x;
      sum_yy += value * y * y;
      sum_xy += value * x * y;
    }
  }
  const auto cells = static_cast<double>(heatmap.size());
  const double mean = sum / cells;
  Features moments{active / cells, mean, std::sqrt(std::max(squares / cells - mean * mean, 0.0)), largest, 0.5, 0.5, 0, 0, 0};
  if (sum > 0) {
    const double x = sum_x / sum, y = sum_y / sum;
    moments[4] = x;
    moments[5] = y;
    moments[6] = std::max(sum_xx / sum - x * x, 0.0);
    moments[7] = std::max(sum_yy / sum - y * y, 0.0);
    moments[8] = sum_xy / sum - x * y;
  }
  return moments;
}

MajorityBaseline fit_majority(std::span<const Touch> truth) {
  check_one_each(truth.size(), truth.size(), "majority");
  std::array<std::size_t, touch_count> counts{};
  for (const Touch touch : truth) ++counts[static_cast<std::size_t>(touch)];
  return {all_touches[static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin())]};
}

Touch EventCountBaseline::verdict(std::uint64_t events) const {
  const auto count = static_cast<double>(events);
  return count < low ? touches[0] : count < high ? touches[1] : touches[2];
}

EventCountBaseline fit_event_count(std::span<const std::uint64_t> events, std::span<const Touch> truth) {
  check_one_each(events.size(), truth.size(), "event_count");
  // Cut c separates the samples with a count below values[c]; before[c][k] of them are of touch k.
  std::vector<std::uint64_t> values(events.begin(), events.end());
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  std::vector<std::array<std::int64_t, touch_count>> before(values.size() + 1);
  for (std::size_t n = 0; n < events.size(); ++n) {
    const auto place = static_cast<std::size_t>(std::lower_bound(values.begin(), values.end(), events[n]) - values.begin());
    ++before[place + 1][static_cast<std::size_t>(truth[n])];
  }
  for (std::size_t c = 1; c < before.size(); ++c) {
    for (std::size_t k = 0; k < touch_count; ++k) before[c][k] += before[c - 1][k];
  }
  const auto threshold_at = [&](std::size_t cut) {
    if (cut == 0) return static_cast<double>(values.front());
    if (cut == values.size()) return static_cast<double>(values.back()) + 1;
    return (static_cast<double>(values[cut - 1]) + static_cast<double>(values[cut])) / 2;
  };

  EventCountBaseline best;
  std::int64_t best_right = -1;
  for (std::size_t a = 0; a < touch_count; ++a) {
    for (std::size_t b = 0; b < touch_count; ++b) {
      for (std::size_t c = 0; c < touch_count; ++c) {
        // right(i, j): a is predicted below i, b from i to j, c beyond; the best i <= j is updated as j grows.
        std::size_t low = 0;
        for (std::size_t high = 0; high < before.size(); ++high) {
          if (before[high][a] - before[high][b] > before[low][a] - before[low][b]) low = high;
          const std::int64_t right = before[low][a] + before[high][b] - before[low][b] + before.back()[c] - before[high][c];
          if (right <= best_right) continue;
          best_right = right;
          best = {threshold_at(low), threshold_at(high), {all_touches[a], all_touches[b], all_touches[c]}};
        }
      }
    }
  }
  return best;
}

std::array<double, touch_count> LogisticBaseline::probabilities(const Features& features) const {
  const Probabilities p = softmax(standardised(features, *this), weights_of(*this));
  return {p[0], p[1], p[2]};
}

Touch LogisticBaseline::verdict(const Features& features) const {
  const auto p = probabilities(features);
  return all_touches[static_cast<std::size_t>(std::max_element(p.begin(), p.end()) - p.begin())];
}

LogisticBaseline fit_logistic(std::span<const Features> features, std::span<const Touch> truth, const LogisticOptions& options) {
  check_one_each(features.size(), truth.size(), "logistic regression");
  LogisticBaseline model;
  standardise_by(features, model);
  std::vector<Inputs> samples;
  samples.reserve(features.size());
  for (const Features& sample : features) samples.push_back(standardised(sample, model));

  Weights weights = Weights::Zero();
  double loss = loss_of(samples, truth, weights, options.ridge);
  for (std::size_t iteration = 0; iteration < options.iterations; ++iteration) {
    const Derivatives derivatives = derivatives_of(samples, truth, weights, options.ridge);
    if (derivatives.gradient.lpNorm<Eigen::Infinity>() < options.tolerance) break;
    const Vector direction = derivatives.hessian.llt().solve(derivatives.gradient);
    // Half the step until the loss falls.
    const Weights from = weights;
    const auto loss_after = [&](double length) {
      weights = from - length * Eigen::Map<const Weights>(direction.data());
      return loss_of(samples, truth, weights, options.ridge);
    };
    double step = 1, stepped = loss_after(step);
    while (!(stepped < loss) && step / 2 > 1e-10) stepped = loss_after(step /= 2);
    if (!(stepped < loss)) {
      weights = from;
      break;
    }
    loss = stepped;
  }
  Eigen::Map<Weights>(model.weights[0].data()) = weights;
  return model;
}

}  // namespace tactile::evaluation
