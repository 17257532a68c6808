#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::python {

namespace nb = nanobind;

template <class Number>
using NumpyArray = nb::ndarray<nb::numpy, Number>;

/// Rows that Python gives; contiguous, on the host.
template <class Number, std::size_t dimensions>
using GivenArray = nb::ndarray<const Number, nb::ndim<dimensions>, nb::c_contig, nb::device::cpu>;

/// Events as NumPy sees them: [n, 16] bytes. The Python side views them as a structured array (tactile/_events.py).
using EventBytes = NumpyArray<std::uint8_t>;
using GivenEventBytes = nb::ndarray<const std::uint8_t, nb::shape<-1, sizeof(events::Event)>, nb::c_contig, nb::device::cpu>;

/// An array that keeps `owner` alive, whose memory begins at `data`.
template <class Number, class Owner>
NumpyArray<Number> array_of(Owner owner, Number* data, std::initializer_list<std::size_t> shape) {
  auto* kept = new Owner(std::move(owner));
  const nb::capsule capsule(kept, [](void* pointer) noexcept { delete static_cast<Owner*>(pointer); });
  return {data, shape, capsule};
}

/// @param shape  its product is the number of values
template <class Number>
NumpyArray<Number> array_of(std::vector<Number> values, std::initializer_list<std::size_t> shape) {
  auto* kept = new std::vector<Number>(std::move(values));
  const nb::capsule capsule(kept, [](void* pointer) noexcept { delete static_cast<std::vector<Number>*>(pointer); });
  return {kept->data(), shape, capsule};
}

template <class Number>
NumpyArray<Number> array_of(std::vector<Number> values) {
  const std::size_t size = values.size();
  return array_of(std::move(values), {size});
}

inline EventBytes event_bytes_of(std::vector<events::Event> events) {
  auto* first = reinterpret_cast<std::uint8_t*>(events.data());
  const std::size_t count = events.size();
  return array_of(std::move(events), first, {count, sizeof(events::Event)});
}

/// @throws Error  if the memory is not aligned for events
std::span<const events::Event> events_of(const GivenEventBytes& bytes);

void bind_recording(nb::module_& module);
void bind_heatmaps(nb::module_& module);
void bind_engine(nb::module_& module);
void bind_dataset(nb::module_& module);

}  // namespace tactile::python
