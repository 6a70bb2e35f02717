#include <fstream>

#include "raven2_trainer/console/console.h"

namespace raven2_trainer::console {

Recording loadRecording(const std::string& path) {
  std::ifstream file(path);
  return readRecording(file, path);
}

}  // namespace raven2_trainer::console
