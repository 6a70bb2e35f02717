#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::model {

inline std::string sourceFile(const std::string& name) {
  return std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/" + name;
}

inline TrainerConfig shippedConfig() {
  return config::loadTrainerConfig(sourceFile("config/trainer.yaml"));
}

/** A separate folder for each test, removed afterwards. */
class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "raven2_model_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
    folder_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

inline std::string readFile(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("'" + from + "' is not in the text");
  return text.replace(at, from.size(), to);
}

}  // namespace raven2_trainer::model
