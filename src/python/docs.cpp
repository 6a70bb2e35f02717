#include "python/docs.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include "python/docs_table.h"

namespace raven2_trainer::python {

const char* doc(const char* name) {
  const auto found = std::find_if(std::begin(kDocs), std::end(kDocs),
                                  [name](const auto& one) { return std::strcmp(one.first, name) == 0; });
  if (found == std::end(kDocs)) throw std::logic_error(std::string("__init__.pyi says nothing of ") + name);
  return found->second;
}

}  // namespace raven2_trainer::python
