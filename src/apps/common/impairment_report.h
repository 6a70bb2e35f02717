#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/proxy/impairment_proxy.h"

namespace raven2_trainer::apps {

/** A line for each direction of each link, on stderr. */
void printReports(const std::vector<proxy::ProxyReport>& reports, double seconds);

/** All figures as JSON. @throw SessionException if the file cannot be written. */
void writeReports(const std::string& path,
                  const proxy::ProxyOptions& options,
                  const std::vector<proxy::ProxyReport>& reports);

}  // namespace raven2_trainer::apps
