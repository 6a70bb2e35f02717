#pragma once

#include <memory>
#include <string>

namespace raven2_trainer::session {

/** Reads a text file line by line; recognizes gzip by the content, not by the name. */
class LineReader {
 public:
  /** @throw SessionException if the file cannot be opened. */
  explicit LineReader(const std::string& path);
  ~LineReader();

  /** Next line without its LF or CR LF. @return false at the end of the file.
   *  @throw SessionException with FILE:LINE for a broken file or a line of more than 64 KiB. */
  bool next(std::string* line);

  /** "FILE:LINE" of the last line read. */
  std::string where() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Writes a text file, gzipped if its name ends in .gz. */
class TextWriter {
 public:
  /** @throw SessionException if the file cannot be created. */
  explicit TextWriter(const std::string& path);
  ~TextWriter();
  /** @throw SessionException if the disk is full. */
  void write(const std::string& text);
  /** Flushes and closes. @throw SessionException. */
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::session
