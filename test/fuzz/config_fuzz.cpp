#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/faults/arming.h"

// The packaged configuration with one file edited. Input: a byte that chooses the file, then edits (fuzz_target.h).

namespace raven2_trainer::fuzz {
namespace {

class Folder {
 public:
  Folder() {
    namespace fs = std::filesystem;
    const std::string source = sourceFile("config");
    for (const auto& entry : fs::recursive_directory_iterator(source)) {
      const std::string name = fs::relative(entry.path(), source).string();
      if (entry.is_directory()) {
        fs::create_directories(scratch_.path(name));
        continue;
      }
      names_.push_back(name);
      texts_.push_back(readWhole(entry.path().string()));
      scratch_.write(name, texts_.back());
    }
  }

  void load(Input* input) const {
    const std::size_t which = input->byte() % names_.size();
    scratch_.write(names_[which], edited(texts_[which], input));
    try {
      const TrainerConfig config = config::loadTrainerConfig(scratch_.path("trainer.yaml"));
      for (std::uint32_t id = 0; id <= config.scenarios.size() + 1; ++id)
        faults::planFor(config, id, 1);
    } catch (const ConfigException& e) {
      require(std::string(e.what()).size() < 2000, "a refusal fits a screen");
    }
    scratch_.write(names_[which], texts_[which]);
  }

 private:
  ScratchFolder scratch_;
  std::vector<std::string> names_, texts_;
};

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const fuzz::Folder folder;
  fuzz::Input input(data, size);
  folder.load(&input);
  return 0;
}
