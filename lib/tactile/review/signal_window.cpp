#include "tactile/review/signal_window.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile::review {
namespace {

nlohmann::json numbers_json(const std::vector<double>& values) {
  nlohmann::json list = nlohmann::json::array();
  for (const double value : values) list.push_back(std::isfinite(value) ? nlohmann::json(value) : nlohmann::json());
  return list;
}

/// The values of one bucket, without gaps; NaN where there are none.
struct Bucket {
  double least = std::numeric_limits<double>::infinity(), most = -least, sum = 0;
  std::size_t count = 0;

  void add(double value) {
    if (std::isnan(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
    sum += value;
    ++count;
  }
};

}  // namespace

void SignalWindow::add(std::int64_t t, double low, double middle, double high) {
  t_us.push_back(t);
  least.push_back(low);
  mean.push_back(middle);
  most.push_back(high);
}

nlohmann::json json_of(const SignalWindow& window) {
  return {{"bucket_us", window.bucket_us},     {"over_us", window.over_us},         {"t_us", window.t_us},
          {"min", numbers_json(window.least)}, {"mean", numbers_json(window.mean)}, {"max", numbers_json(window.most)}};
}

std::int64_t WindowRequest::bucket_us(std::int64_t unit_us) const {
  const std::int64_t length = to_us - from_us;
  const std::int64_t needed = (length + points - 1) / points;
  return std::max<std::int64_t>(1, (needed + unit_us - 1) / unit_us) * unit_us;
}

SignalWindow window_of(const SampledSignal& signal, const WindowRequest& request) {
  const auto begin_of = [&](std::int64_t t) {
    return static_cast<std::size_t>(std::lower_bound(signal.t_us.begin(), signal.t_us.end(), t) - signal.t_us.begin());
  };
  std::size_t begin = begin_of(request.from_us), end = begin_of(request.to_us);
  SignalWindow window;
  if (static_cast<std::int64_t>(end - begin) <= request.points) {
    begin -= begin > 0 ? 1 : 0;
    end += end < signal.t_us.size() ? 1 : 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto value = static_cast<double>(signal.values[i]);
      window.add(signal.t_us[i], value, value, value);
    }
    return window;
  }
  window.bucket_us = request.bucket_us(1);
  const auto bucket_of = [&](std::int64_t t) {
    const std::int64_t whole = t / window.bucket_us;
    return whole - (t % window.bucket_us < 0 ? 1 : 0);
  };
  for (std::size_t i = begin; i < end;) {
    const std::int64_t bucket = bucket_of(signal.t_us[i]);
    Bucket values;
    for (; i < end && bucket_of(signal.t_us[i]) == bucket; ++i) values.add(static_cast<double>(signal.values[i]));
    const std::int64_t middle = bucket * window.bucket_us + window.bucket_us / 2;
    if (values.count > 0) {
      window.add(middle, values.least, values.sum / static_cast<double>(values.count), values.most);
    } else {
      const double gap = std::numeric_limits<double>::quiet_NaN();
      window.add(middle, gap, gap, gap);
    }
  }
  return window;
}

}  // namespace tactile::review
