#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "raven2_trainer/core/types.h"

// Arrays from callers.

namespace raven2_trainer::python {

using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/** As numbers of double precision; an empty handle for texts, booleans, complex numbers and what is no array. */
inline Numbers numbersOf(const pybind11::handle& value) {
  const auto array = pybind11::array::ensure(value);
  const bool is_number = array && std::string("iuf").find(array.dtype().kind()) != std::string::npos;
  return is_number ? Numbers::ensure(array) : pybind11::reinterpret_steal<Numbers>(pybind11::handle());
}

/** @throw std::invalid_argument unless it is `count` finite numbers. */
inline std::vector<double> finiteNumbers(const pybind11::handle& value, std::size_t count, const std::string& what) {
  const auto array = numbersOf(value);
  if (!array || array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != count) {
    PyErr_Clear();
    throw std::invalid_argument(what + ": expected " + std::to_string(count) + " numbers");
  }
  std::vector<double> numbers(array.data(), array.data() + count);
  for (const double number : numbers)
    if (!std::isfinite(number)) throw std::invalid_argument(what + ": not a finite number");
  return numbers;
}

template <typename Array>
Array arrayOf(const pybind11::handle& value, const std::string& what) {
  Array array{};
  const std::vector<double> numbers = finiteNumbers(value, array.size(), what);
  std::copy(numbers.begin(), numbers.end(), array.begin());
  return array;
}

/** "gold" or "green". @throw std::invalid_argument. */
inline Arm armOf(const std::string& name) {
  if (name == "gold") return Arm::kGold;
  if (name == "green") return Arm::kGreen;
  throw std::invalid_argument("arm is \"" + name + "\", expected gold or green");
}

/** Joints with any leading axes. @throw std::invalid_argument. */
inline Numbers jointRows(const pybind11::object& given) {
  auto rows = numbersOf(given);
  PyErr_Clear();
  if (!rows || rows.ndim() < 1 || rows.shape(rows.ndim() - 1) != static_cast<pybind11::ssize_t>(kJointCount))
    throw std::invalid_argument("joints: expected an array whose last axis has 7 numbers");
  return rows;
}

/** The axes before the last `dropped` ones, and `added` ones behind them. */
inline std::vector<pybind11::ssize_t> leading(const pybind11::array& array,
                                              int dropped,
                                              const std::vector<pybind11::ssize_t>& added) {
  std::vector<pybind11::ssize_t> shape(array.shape(), array.shape() + array.ndim() - dropped);
  shape.insert(shape.end(), added.begin(), added.end());
  return shape;
}

inline JointArray rowOf(const double* numbers) {
  JointArray q{};
  std::copy(numbers, numbers + q.size(), q.begin());
  return q;
}

}  // namespace raven2_trainer::python
