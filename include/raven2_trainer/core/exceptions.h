#pragma once

#include <stdexcept>
#include <string>

// Set-up throws one of these, with the value, the allowed range and the place. `main` catches it and prints one line.
// Loops never throw: they return enums and count.

namespace raven2_trainer {

/** Base of every exception of this package. The message starts with "raven2_trainer: ". */
class Exception : public std::runtime_error {
 public:
  explicit Exception(const std::string& what) : std::runtime_error("raven2_trainer: " + what) {}
};

/** A configuration or scenario file, or an option, is wrong. Message: FILE:LINE: key, value, allowed range. */
class ConfigException : public Exception {
  using Exception::Exception;
};

/** A URDF or mesh is missing or cannot be used. Message: FILE:LINE: element, reason. */
class ModelException : public Exception {
  using Exception::Exception;
};

/** A socket cannot be opened. Message: address, port, system error. */
class NetworkException : public Exception {
  using Exception::Exception;
};

/** A session log cannot be opened, or the file is not a session log. Message: file, reason. */
class SessionException : public Exception {
  using Exception::Exception;
};

/** `--strict` requires real-time scheduling, but the system refused it. Message: refused call, reason. */
class RealtimeException : public Exception {
  using Exception::Exception;
};

/** OpenGL (OSMesa, EGL) or the video encoder cannot be started. Message: call, reason. */
class RenderException : public Exception {
  using Exception::Exception;
};

}  // namespace raven2_trainer
