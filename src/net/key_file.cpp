#include "raven2_trainer/net/key_file.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {
namespace {

constexpr std::size_t kDigits = 2 * wire::ItpKey::kSize;

/** A buffer that holds a secret, wiped at its end. */
template <std::size_t N>
struct Wiped {
  ~Wiped() { sodium_memzero(bytes.data(), bytes.size()); }
  std::array<std::uint8_t, N> bytes{};
};

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw ConfigException("key_file " + path + ": " + why);
}

std::string octal(mode_t mode) {
  char text[8];
  std::snprintf(text, sizeof(text), "%04o", static_cast<unsigned>(mode & 07777U));
  return text;
}

/** On the open file, so that what was judged is what is read. */
void checkOwner(const std::string& path, int fd) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) refuse(path, std::strerror(errno));
  if (!S_ISREG(info.st_mode)) refuse(path, "is no regular file");
  if (info.st_uid != ::geteuid()) {
    refuse(path, "belongs to user " + std::to_string(info.st_uid) + ", expected " + std::to_string(::geteuid()));
  }
  const mode_t mode = info.st_mode & 07777U;
  if (mode != 0600 && mode != 0400) refuse(path, "mode is " + octal(mode) + ", expected 0600 or 0400");
}

}  // namespace

std::unique_ptr<const wire::ItpKey> loadKeyFile(const std::string& path) {
  const net::FileDescriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!fd.isOpen()) refuse(path, std::string("cannot be opened: ") + std::strerror(errno));
  checkOwner(path, fd.get());
  ::prctl(PR_SET_DUMPABLE, 0);
  Wiped<kDigits + 2> text;
  const ssize_t size = ::read(fd.get(), text.bytes.data(), text.bytes.size());
  const bool ends_well = size == static_cast<ssize_t>(kDigits) ||
                         (size == static_cast<ssize_t>(kDigits + 1) && text.bytes[kDigits] == '\n');
  Wiped<wire::ItpKey::kSize> key;
  std::size_t length = 0;
  const int parsed =
      sodium_hex2bin(key.bytes.data(), key.bytes.size(), reinterpret_cast<const char*>(text.bytes.data()), kDigits,
                     nullptr, &length, nullptr);
  if (!ends_well || parsed != 0 || length != key.bytes.size())
    refuse(path, "expected one line of 64 hexadecimal digits");
  return std::make_unique<const wire::ItpKey>(key.bytes);
}

std::unique_ptr<const wire::ItpKey> loadKey(const NetworkConfig& network) {
  return network.itp.auth == ItpAuth::kOff ? nullptr : loadKeyFile(network.key_file);
}

void writeKeyFile(const std::string& path) {
  if (sodium_init() < 0) refuse(path, "the system gives no random numbers");
  const net::FileDescriptor fd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!fd.isOpen()) refuse(path, std::string("cannot be made: ") + std::strerror(errno));
  Wiped<wire::ItpKey::kSize> key;
  Wiped<kDigits + 1> text;
  randombytes_buf(key.bytes.data(), key.bytes.size());
  sodium_bin2hex(reinterpret_cast<char*>(text.bytes.data()), text.bytes.size(), key.bytes.data(), key.bytes.size());
  text.bytes[kDigits] = '\n';
  const ssize_t size = ::write(fd.get(), text.bytes.data(), text.bytes.size());
  const bool is_whole = size == static_cast<ssize_t>(text.bytes.size());
  if (is_whole && ::fsync(fd.get()) == 0) return;
  const std::string why = size >= 0 && !is_whole ? "no room for all of it" : std::strerror(errno);
  ::unlink(path.c_str());  // else the next attempt would find it
  refuse(path, "cannot be written: " + why);
}

wire::Nonce freshNonce() noexcept {
  wire::Nonce nonce{};
  while (::getrandom(nonce.data(), nonce.size(), 0) != static_cast<ssize_t>(nonce.size())) {
  }
  return nonce;
}

}  // namespace raven2_trainer::net
