#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace raven2_trainer::studies {

/** As short as possible with nine digits; empty for NaN and infinity. */
inline std::string number(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

}  // namespace raven2_trainer::studies
