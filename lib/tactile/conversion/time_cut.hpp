#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/conversion/convert.hpp"
#include "tactile/core/error.hpp"

namespace tactile::conversion {

/// Selects the elements inside the times that the options give.
class TimeCut {
 public:
  explicit TimeCut(const ConvertOptions& options)
      : from_(options.from.value_or(CameraTime::min())),
        to_(options.to),
        from_waits_(options.from && options.from_counts_from_first),
        to_waits_(options.to && options.to_counts_from_first),
        is_limited_(options.from || options.to) {
    if (from_waits_ == to_waits_) check();
  }

  /// Gives the time of the first element, from which `from` and `to` may count. Only the first call counts.
  void begin_at(CameraTime first) {
    if (!from_waits_ && !to_waits_) return;
    if (from_waits_) from_ = after(first, microseconds{us_of(from_)});
    if (to_waits_) to_ = after(first, microseconds{us_of(*to_)});
    from_waits_ = to_waits_ = false;
    check();
  }

  bool holds(CameraTime t) const { return t >= from_ && (!to_ || t < *to_); }
  bool is_limited() const { return is_limited_; }
  std::string text() const {
    return fmt::format("[{}, {})", from_ == CameraTime::min() ? "start" : std::to_string(us_of(from_)),
                       to_ ? std::to_string(us_of(*to_)) : "end");
  }

  /// The elements inside the cut: a view of `elements` if all are inside, otherwise of copies in `kept`.
  template <class Element>
  std::span<const Element> of(std::span<const Element> elements, std::vector<Element>& kept) const {
    const auto is_inside = [this](const Element& element) { return holds(element.t); };
    if (!is_limited_ || std::all_of(elements.begin(), elements.end(), is_inside)) return elements;
    kept.clear();
    std::copy_if(elements.begin(), elements.end(), std::back_inserter(kept), is_inside);
    return kept;
  }

 private:
  void check() const {
    if (to_ && *to_ <= from_)
      throw Error(fmt::format("the cut from {} to {} us is empty; expected an end after the start", us_of(from_), us_of(*to_)));
  }

  CameraTime from_;
  std::optional<CameraTime> to_;
  bool from_waits_, to_waits_;  ///< for the time of the first element
  bool is_limited_;
};

}  // namespace tactile::conversion
