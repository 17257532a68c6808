// Compiled once for each set of vector instructions: foreach_target.h reads this file again for each.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_limits.cpp"
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include "engine_limits.hpp"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tactile::bench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

HWY_ATTR float multiply_adds_here(std::size_t count) {
  constexpr hn::CappedTag<float, 16> floats;
  const auto factor = hn::Set(floats, 0.999F), summand = hn::Set(floats, 1e-3F);
  const auto first = [&](float value)
                         HWY_ATTR { return hn::Set(floats, value); };  // different values, else the compiler keeps one sum
  auto a = first(1), b = first(2), c = first(3), d = first(4), e = first(5), f = first(6), g = first(7), h = first(8);
  for (std::size_t done = 0; done < count; done += 8 * hn::Lanes(floats)) {
    a = hn::MulAdd(a, factor, summand), b = hn::MulAdd(b, factor, summand);
    c = hn::MulAdd(c, factor, summand), d = hn::MulAdd(d, factor, summand);
    e = hn::MulAdd(e, factor, summand), f = hn::MulAdd(f, factor, summand);
    g = hn::MulAdd(g, factor, summand), h = hn::MulAdd(h, factor, summand);
  }
  const auto sum = hn::Add(hn::Add(hn::Add(a, b), hn::Add(c, d)), hn::Add(hn::Add(e, f), hn::Add(g, h)));
  return hn::GetLane(hn::SumOfLanes(floats, sum));
}

HWY_ATTR float sum_of_here(const float* values, std::size_t count) {
  constexpr hn::CappedTag<float, 16> floats;
  const std::size_t lanes = hn::Lanes(floats);
  auto a = hn::Zero(floats), b = a, c = a, d = a;
  for (std::size_t i = 0; i + 4 * lanes <= count; i += 4 * lanes) {
    a = hn::Add(a, hn::LoadU(floats, values + i)), b = hn::Add(b, hn::LoadU(floats, values + i + lanes));
    c = hn::Add(c, hn::LoadU(floats, values + i + 2 * lanes)), d = hn::Add(d, hn::LoadU(floats, values + i + 3 * lanes));
  }
  return hn::GetLane(hn::SumOfLanes(floats, hn::Add(hn::Add(a, b), hn::Add(c, d))));
}

}  // namespace tactile::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile::bench {

HWY_EXPORT(multiply_adds_here);
HWY_EXPORT(sum_of_here);

float multiply_adds(std::size_t count) { return HWY_DYNAMIC_DISPATCH(multiply_adds_here)(count); }
float sum_of(const float* values, std::size_t count) { return HWY_DYNAMIC_DISPATCH(sum_of_here)(values, count); }

}  // namespace tactile::bench
#endif
