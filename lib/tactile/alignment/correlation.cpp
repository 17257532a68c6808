#include "tactile/alignment/correlation.hpp"

#include <opencv2/core.hpp>

namespace tactile::alignment {

std::vector<double> correlations(std::span<const double> a, std::span<const double> b) {
  if (a.empty() || b.empty()) return {};
  const std::size_t lags = a.size() + b.size() - 1;
  cv::Mat reversed = cv::Mat::zeros(1, cv::getOptimalDFTSize(static_cast<int>(lags)), CV_64F), other = reversed.clone();
  std::copy(a.rbegin(), a.rend(), reversed.begin<double>());
  std::copy(b.begin(), b.end(), other.begin<double>());
  cv::dft(reversed, reversed);
  cv::dft(other, other);
  cv::mulSpectrums(reversed, other, reversed, 0);
  cv::idft(reversed, reversed, cv::DFT_SCALE);
  return {reversed.begin<double>(), reversed.begin<double>() + static_cast<std::ptrdiff_t>(lags)};
}

}  // namespace tactile::alignment
