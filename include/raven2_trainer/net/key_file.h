#pragma once

#include <memory>
#include <string>

#include "raven2_trainer/net/network_config.h"
#include "raven2_trainer/wire/itp_key.h"
#include "raven2_trainer/wire/itp_session.h"

namespace raven2_trainer::net {

/**
 * The key of signed ITP: 64 hexadecimal digits in a file of the user's own that nobody else may read. From then on this
 * process leaves no core dump.
 * @throw ConfigException with path, mode or what is wrong, never with what the file holds.
 */
std::unique_ptr<const wire::ItpKey> loadKeyFile(const std::string& path);

/** The key that `network` asks for; none with auth off. @throw ConfigException as loadKeyFile(). */
std::unique_ptr<const wire::ItpKey> loadKey(const NetworkConfig& network);

/** A new random key in a new file, mode 0600. @throw ConfigException if the file exists or cannot be written. */
void writeKeyFile(const std::string& path);

/** 32 random bytes of the system's. Real-time safe: one system call, which waits only in the first seconds of a boot.
 */
wire::Nonce freshNonce() noexcept;

}  // namespace raven2_trainer::net
