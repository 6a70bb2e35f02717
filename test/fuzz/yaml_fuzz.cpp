#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

// Any text as a configuration file: every key is read as every type.

namespace raven2_trainer::fuzz {
namespace {

using config::Section;

constexpr int kDepth = 4;  // of the files in config/

template <typename Get>
void attempt(const std::string& file, const Get& get) {
  try {
    get();
  } catch (const ConfigException& e) {
    requirePlace(e.what(), file);
  }
}

void visit(Section& section, int depth) {
  const std::string& file = section.file();
  for (const std::string& key : section.keys()) {
    attempt(file, [&] {
      const double value = section.number(key, -10, 10);
      require(value >= -10 && value <= 10, "a number is within its range");
    });
    attempt(file, [&] { require(std::abs(section.integer(key, -7, 7)) <= 7, "an integer is within its range"); });
    attempt(file, [&] { section.boolean(key); });
    attempt(file, [&] { section.text(key, {"gold", "green"}); });
    attempt(file, [&] { section.texts(key); });
    attempt(file, [&] { section.joints(key, -1, 1); });
    attempt(file, [&] { section.vec3(key, -1, 1); });
    if (depth == 0) continue;
    attempt(file, [&] {
      Section inner = section.section(key);
      visit(inner, depth - 1);
    });
    attempt(file, [&] {
      for (Section& inner : section.list(key))
        visit(inner, depth - 1);
    });
  }
  attempt(file, [&] { section.section("absent"); });
  attempt(file, [&] { section.finish(); });
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  const std::string file = "fuzzed.yaml";
  fuzz::attempt(file, [&] {
    auto root = config::Section::fromText(fuzz::Input(data, size).rest(), file);
    fuzz::visit(root, fuzz::kDepth);
  });
  return 0;
}
