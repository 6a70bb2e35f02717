#include "raven2_trainer/recording/build_identity.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::recording {
namespace {

/** Path of a mapped file of this process whose name begins with `start`; empty: no such file is mapped. */
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

/** The identity's line of a library, without the library's name. */
std::string entryOf(const std::string& identity, const std::string& library) {
  std::istringstream lines(identity);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(library + " ", 0) == 0) return line.substr(library.size() + 1);
  }
  return "";
}

/** Whether a file's note of its build ID, as the linker wrote it, holds these hexadecimal digits. */
bool hasBuildId(const std::string& path, const std::string& digits) {
  std::string note{"\x14\0\0\0\x03\0\0\0GNU\0", 12};  // 20 bytes, NT_GNU_BUILD_ID, its owner
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    note += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  std::ifstream file(path, std::ios::binary);
  std::string begin(65536, '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return digits.size() == 40 && begin.find(note) != std::string::npos;
}

TEST(PictureIdentity, NamesTheLibrariesThatDraw) {
  const std::string identity = pictureIdentity();
  const bool has_osmesa = entryOf(identity, "opengl") == "OSMesa";
  ASSERT_NE(mappedFile(has_osmesa ? "libOSMesa.so" : "libEGL_mesa.so"), "") << "the drawing library must be loaded";
  for (const auto& [library, start] : {std::pair{"libOSMesa", "libOSMesa.so"},
                                       {"libEGL_mesa", "libEGL_mesa.so"},
                                       {"libLLVM", "libLLVM-"},
                                       {"libm", "libm.so"}}) {
    const std::string file = mappedFile(start);
    if (file.empty()) continue;  // an OSMesa that draws without LLVM
    const std::string entry = entryOf(identity, library), value = entry.substr(entry.find(' ') + 1);
    EXPECT_EQ(entry.rfind(start, 0), 0U) << library << ": " << entry;
    if (library == std::string("libm"))
      EXPECT_EQ(value, session::fileHash(file)) << entry;
    else
      EXPECT_TRUE(hasBuildId(file, value) || value == session::fileHash(file)) << library << ": " << entry;
  }
}

}  // namespace
}  // namespace raven2_trainer::recording
