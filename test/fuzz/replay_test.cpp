#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/core/random.h"
#include "support/effort.h"

// Runs a fuzz target without libFuzzer: its seeds, then seeded mutations of them. So the targets are built, and known
// crashes are tested, also without clang.

namespace raven2_trainer::fuzz {
namespace {

std::vector<Bytes> seeds() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFile("test/fuzz/seeds/" RAVEN2_FUZZ_TARGET)))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Bytes> all;
  for (const auto& file : files) {
    const std::string text = readWhole(file.string());
    all.emplace_back(text.begin(), text.end());
  }
  return all;
}

void run(const Bytes& input) {
  Bytes copy = input;  // of exact capacity, so that a sanitizer detects a read behind its end
  copy.shrink_to_fit();
  LLVMFuzzerTestOneInput(copy.data(), copy.size());
}

std::size_t below(Random* random, std::size_t limit) {
  return limit == 0 ? 0 : random->next() % limit;
}

void mutate(const std::vector<Bytes>& others, Random* random, Bytes* input) {
  const std::size_t at = below(random, input->size());
  switch (input->empty() ? 2U : random->next() % 5U) {
    case 0:
      (*input)[at] ^= static_cast<std::uint8_t>(1U << random->next() % 8U);
      break;
    case 1:
      (*input)[at] = static_cast<std::uint8_t>(random->next());
      break;
    case 2:
      input->insert(input->begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random->next()));
      break;
    case 3:
      input->erase(input->begin() + static_cast<std::ptrdiff_t>(at),
                   input->begin() + static_cast<std::ptrdiff_t>(
                                        std::min(input->size(), at + 1 + below(random, input->size() / 4 + 1))));
      break;
    default: {
      const Bytes& other = others[below(random, others.size())];
      const std::size_t from = below(random, other.size());
      input->insert(input->begin() + static_cast<std::ptrdiff_t>(at), other.begin() + static_cast<std::ptrdiff_t>(from),
                    other.end());
    }
  }
}

TEST(Fuzz, SeedsAreTaken) {
  const std::vector<Bytes> all = seeds();
  ASSERT_FALSE(all.empty());
  for (const Bytes& seed : all)
    run(seed);
}

TEST(Fuzz, MutationsOfTheSeedsAreTaken) {
  constexpr std::size_t kMost = 4096;  // [bytes] as scripts/fuzz
  const std::vector<Bytes> all = seeds();
  Random random(1);
  const std::int64_t rounds = testing::effort(RAVEN2_FUZZ_ROUNDS, 20 * RAVEN2_FUZZ_ROUNDS);
  for (std::int64_t i = 0; i < rounds; ++i) {
    Bytes input = all[below(&random, all.size())];
    for (std::size_t n = 1 + below(&random, 6); n > 0; --n)
      mutate(all, &random, &input);
    if (input.size() > kMost) input.resize(kMost);
    run(input);
  }
}

}  // namespace
}  // namespace raven2_trainer::fuzz
