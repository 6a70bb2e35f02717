#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <stdexcept>
#include <utility>

namespace raven2_trainer::python {

/**
 * Base of every class of the module. Python can make an object by `__new__` alone, without its constructor. Once a
 * method is called, pybind11 (2.10, type_caster_generic::load_value) would take memory for it from the class's
 * `operator new` and use it as it is. So this operator refuses; values are made by made().
 */
struct Constructed {
  static void* operator new(std::size_t /*size*/) { throw std::runtime_error("__init__ has not been called"); }
  static void operator delete(void* place) noexcept { ::operator delete(place); }
};

template <typename T, typename... Arguments>
std::unique_ptr<T> made(Arguments&&... arguments) {
  return std::unique_ptr<T>(::new T(std::forward<Arguments>(arguments)...));
}

}  // namespace raven2_trainer::python
