#include "raven2_trainer/recording/build_identity.h"

#include <link.h>

#include <cstring>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/render/renderer.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::recording {

extern const char* const kBuildSources;   // written by scripts/write_build_identity.cmake at each build
extern const char* const kBuildCompiler;  // likewise

namespace {

using Identity = std::map<std::string, std::string>;

constexpr const char* kLibraries[] = {"libode", "libm", "libc", "libstdc++"};
// They decide over pixels, and over no bit of a simulation: OSMesa or EGL of Mesa, and what makes the code that they
// draw with.
constexpr const char* kDrawingLibraries[] = {"libOSMesa", "libEGL_mesa", "libgallium", "libLLVM"};

std::string hashOrReason(const std::string& path) {
  try {
    return session::fileHash(path);
  } catch (const SessionException&) {
    return "unreadable";
  }
}

/** Whether a file is libNAME.so of any version, or has one in its name, as libLLVM-15.so.1. */
bool isLibrary(const std::string& file, const std::string& library) {
  if (file.rfind(library, 0) != 0) return false;
  const std::string rest = file.substr(library.size());
  const bool has_version = rest.size() > 1 && rest[0] == '-' && rest[1] >= '0' && rest[1] <= '9';
  return rest.rfind(".so", 0) == 0 || (has_version && rest.find(".so") != std::string::npos);
}

void addIfNamed(const char* library, const std::string& path, Identity* identity) {
  const std::string name = std::filesystem::path(path).filename().string();
  if (isLibrary(name, library)) (*identity)[library] = name + " " + hashOrReason(path);
}

int addLibrary(dl_phdr_info* info, std::size_t, void* identity) {
  for (const char* library : kLibraries)
    addIfNamed(library, info->dlpi_name, static_cast<Identity*>(identity));
  return 0;
}

std::string hexadecimal(const unsigned char* bytes, std::size_t count) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += {kDigits[bytes[i] >> 4], kDigits[bytes[i] & 15]};
  return text;
}

/** The linker's hash of a loaded library (ld --build-id); empty without one. */
std::string buildId(const dl_phdr_info& info) {
  const auto align = [](std::size_t size) { return (size + 3) & ~std::size_t{3}; };
  for (int k = 0; k < info.dlpi_phnum; ++k) {
    const ElfW(Phdr)& segment = info.dlpi_phdr[k];
    if (segment.p_type != PT_NOTE || segment.p_align > 4) continue;
    const auto* note = reinterpret_cast<const unsigned char*>(info.dlpi_addr + segment.p_vaddr);
    const unsigned char* const end = note + segment.p_memsz;
    while (note + sizeof(ElfW(Nhdr)) <= end) {
      ElfW(Nhdr) head;
      std::memcpy(&head, note, sizeof head);
      const unsigned char* const name = note + sizeof head;
      const unsigned char* const content = name + align(head.n_namesz);
      if (content + head.n_descsz > end) break;
      if (head.n_type == NT_GNU_BUILD_ID && head.n_namesz == 4 && std::memcmp(name, "GNU", 4) == 0)
        return hexadecimal(content, head.n_descsz);
      note = content + align(head.n_descsz);
    }
  }
  return "";
}

/** By its build ID: libLLVM has 120 MB, of which the hash takes a quarter of a second. */
int addDrawingLibrary(dl_phdr_info* info, std::size_t, void* identity) {
  const std::string path = info->dlpi_name, name = std::filesystem::path(path).filename().string();
  for (const char* library : kDrawingLibraries) {
    if (!isLibrary(name, library)) continue;
    const std::string id = buildId(*info);
    (*static_cast<Identity*>(identity))[library] = name + " " + (id.empty() ? hashOrReason(path) : id);
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

std::string pictureIdentity() {
  Identity identity = buildIdentity();
  identity["opengl"] = render::loadOpenGl();
  dl_iterate_phdr(&addDrawingLibrary, &identity);
  std::string text;
  for (const auto& [name, value] : identity)
    text += name + " " + value + "\n";
  return text;
}

}  // namespace raven2_trainer::recording
