#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/console/commanded_source.h"

namespace raven2_trainer::console {

/**
 * Commands as a file (doc/python.md): a recorded Python session has one, and `simulate` repeats it. A line has a number
 * of milliseconds and their command. The first line begins at the console's first tick, so the robot must become ready
 * as soon as it did then. Numbers are written such that they are read as the same bits.
 */
struct CommandRow {
  std::uint32_t ticks{};  ///< [1 ms] with the same command
  HandsCommand command;
};

/** @throw ConfigException with FILE:LINE for other columns, a value that is out of range, or no rows. */
std::vector<CommandRow> loadCommands(const std::string& path);

/** The same from any stream; `path` is for messages. */
std::vector<CommandRow> readCommands(std::istream& stream, const std::string& path);

/** Does what the rows say. Then it is finished, with the pedal up. @param[in] opening [rad] of the jaws before. */
std::unique_ptr<MotionSource> makeCommanded(const ConsoleConfig& config,
                                            const PerArm<double>& opening,
                                            std::vector<CommandRow> rows);

/** Writes such a file, a command a millisecond. */
class CommandWriter {
 public:
  explicit CommandWriter(std::ostream* stream);
  void add(const HandsCommand& command);
  /** Writes the last line, which add() leaves open for further equal commands. */
  void flush();

 private:
  std::ostream& stream_;
  CommandRow row_;
};

}  // namespace raven2_trainer::console
