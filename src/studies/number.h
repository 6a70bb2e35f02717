#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace raven2_trainer::studies {

/** As short as it may be and still tell nine digits; nothing for what is not known. */
inline std::string number(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

}  // namespace raven2_trainer::studies
