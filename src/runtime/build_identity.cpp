#include "raven2_trainer/runtime/build_identity.h"

#include <link.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::runtime {

extern const char* const kBuildSources;   // written by scripts/write_build_identity.cmake at each build
extern const char* const kBuildCompiler;  // likewise

namespace {

using Identity = std::map<std::string, std::string>;

constexpr const char* kLibraries[] = {"libode", "libm", "libc", "libstdc++"};

std::string hashOrReason(const std::string& path) {
  try {
    return session::fileHash(path);
  } catch (const SessionException&) {
    return "unreadable";
  }
}

int addLibrary(dl_phdr_info* info, std::size_t, void* identity) {
  const std::string name = std::filesystem::path(info->dlpi_name).filename().string();
  for (const char* library : kLibraries) {
    if (name.rfind(std::string(library) + ".so", 0) != 0) continue;
    (*static_cast<Identity*>(identity))[library] = name + " " + hashOrReason(info->dlpi_name);
  }
  return 0;
}

/** glibc picks its sin and cos by these. */
std::string processor() {
#if defined(__x86_64__)
  std::string text = "x86_64";
  if (__builtin_cpu_supports("avx2")) text += " avx2";
  if (__builtin_cpu_supports("fma")) text += " fma";
  if (__builtin_cpu_supports("avx512f")) text += " avx512f";
  return text;
#else
  return "other";
#endif
}

}  // namespace

Identity buildIdentity() {
  Identity identity{{"sources", kBuildSources}, {"compiler", kBuildCompiler}, {"processor", processor()}};
  dl_iterate_phdr(&addLibrary, &identity);
  return identity;
}

}  // namespace raven2_trainer::runtime
