#include "raven2_trainer/runtime/build_identity.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::runtime {
namespace {

/** Path of the file of that name's start that the kernel has mapped into this process; empty: none. */
std::string mappedFile(const std::string& start) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const auto slash = line.rfind('/');
    if (slash != std::string::npos && line.compare(slash + 1, start.size(), start) == 0)
      return line.substr(line.find('/'));
  }
  return "";
}

TEST(BuildIdentity, NamesTheLibrariesThatASimulationComputesWith) {
  const auto identity = buildIdentity();
  for (const char* name : {"sources", "compiler", "processor", "libm", "libc", "libstdc++"})
    EXPECT_EQ(identity.count(name), 1U) << name;
  EXPECT_EQ(identity.count("libOSMesa") + identity.count("libLLVM"), 0U) << "they decide over pixels alone";
}

/** What it says of a library: its line behind the name. */
std::string entryOf(const std::string& identity, const std::string& library) {
  std::istringstream lines(identity);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(library + " ", 0) == 0) return line.substr(library.size() + 1);
  }
  return "";
}

TEST(PictureIdentity, NamesTheLibrariesThatDraw) {
  const std::string identity = pictureIdentity();
  ASSERT_NE(mappedFile("libOSMesa.so"), "") << "the program draws";
  for (const auto& [library, start] :
       {std::pair{"libOSMesa", "libOSMesa.so"}, {"libLLVM", "libLLVM-"}, {"libm", "libm.so"}}) {
    const std::string file = mappedFile(start);
    if (file.empty()) continue;  // an OSMesa that draws without LLVM
    const std::string entry = entryOf(identity, library), hash = session::fileHash(file);
    EXPECT_EQ(entry.rfind(start, 0), 0U) << library << ": " << entry;
    EXPECT_EQ(entry.substr(entry.find(' ') + 1), hash) << library << ": " << entry;
  }
}

}  // namespace
}  // namespace raven2_trainer::runtime
