#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/runtime/impairment_proxy.h"

namespace raven2_trainer::apps {

/** A line for each direction of each link, on stderr. */
void printReports(const std::vector<runtime::ProxyReport>& reports, double seconds);

/** All figures as JSON. @throw SessionException if the file cannot be written. */
void writeReports(const std::string& path,
                  const runtime::ProxyOptions& options,
                  const std::vector<runtime::ProxyReport>& reports);

}  // namespace raven2_trainer::apps
