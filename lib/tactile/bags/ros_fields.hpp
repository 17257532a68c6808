#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "tactile/bags/ros_types.hpp"

namespace tactile::bags {

/// A number in a message at `offset`, which the caller has checked.
template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t offset = 0) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// Reads the fields of a message from front to back, in either serialisation. Values after its end read as 0, and `ok` is false
/// from then on. Source: ROS wiki, msg; OMG DDSI-RTPS 2.5, section 10, and DDS-XTypes 1.3, section 7.4.1.
class RosFields {
 public:
  explicit RosFields(SerialisedMessage message) : body_(message.bytes), is_cdr_(message.serialisation != RosSerialisation::ros1) {
    if (!is_cdr_) return;
    constexpr std::size_t encapsulation = 4;  // {0, 1}: CDR, little-endian; then two bytes of options
    ok_ = message.serialisation == RosSerialisation::cdr && body_.size() >= encapsulation && body_[0] == std::byte{0} &&
          body_[1] == std::byte{1};
    body_ = ok_ ? body_.subspan(encapsulation) : std::span<const std::byte>();
  }

  bool ok() const { return ok_; }

  template <class T>
  T number() {
    align(sizeof(T));
    const std::span<const std::byte> bytes = take(sizeof(T));
    return bytes.empty() ? T{} : number_at<T>(bytes);
  }
  std::span<const std::byte> take(std::size_t count) {
    if (!ok_ || count > body_.size() - at_) {
      ok_ = false;
      return {};
    }
    at_ += count;
    return body_.subspan(at_ - count, count);
  }
  /// The number of elements that follow, of at least `least_bytes` each; fails if the message is too short for them.
  std::size_t count(std::size_t least_bytes) {
    const auto elements = number<std::uint32_t>();
    if (elements > (body_.size() - at_) / least_bytes) ok_ = false;
    return ok_ ? elements : 0;
  }
  /// An array of numbers.
  std::span<const std::byte> array(std::size_t number_bytes) {
    const std::size_t elements = count(number_bytes);
    if (elements > 0) align(number_bytes);
    return take(elements * number_bytes);
  }
  std::string_view text() {
    const std::span<const std::byte> bytes = array(1);
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (is_cdr_ && text.ends_with('\0')) text.remove_suffix(1);  // the length includes the end
    return text;
  }
  /// Seconds and nanoseconds, less than 10^9 of them.
  std::int64_t stamp_us() {
    const std::int64_t seconds = is_cdr_ ? std::int64_t{number<std::int32_t>()} : std::int64_t{number<std::uint32_t>()};
    const std::int64_t nanoseconds = number<std::uint32_t>();
    if (nanoseconds >= 1'000'000'000) ok_ = false;
    return seconds * 1'000'000 + nanoseconds / 1'000;
  }
  /// A Header's stamp and frame. That of ROS 1 begins with a number.
  std::pair<std::int64_t, std::string_view> header() {
    if (!is_cdr_) number<std::uint32_t>();
    const std::int64_t stamp = stamp_us();
    return {stamp, text()};
  }

 private:
  void align(std::size_t bytes) {
    if (is_cdr_) take((bytes - at_ % bytes) % bytes);
  }

  std::span<const std::byte> body_;
  std::size_t at_ = 0;
  bool is_cdr_;
  bool ok_ = true;
};

}  // namespace tactile::bags
