#include "raven2_trainer/session/configuration_copy.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::session {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "configuration";

fs::path normal(const std::string& file) {
  return fs::absolute(file).lexically_normal();
}

/** Absolute, without dots, each once. */
std::vector<fs::path> distinct(const std::vector<std::string>& files) {
  std::vector<fs::path> paths;
  for (const std::string& file : files) {
    const fs::path path = normal(file);
    if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
  }
  return paths;
}

/** The deepest folder that holds all of them. */
fs::path commonFolder(const std::vector<fs::path>& paths) {
  fs::path common = paths.empty() ? fs::path() : paths.front().parent_path();
  for (const fs::path& path : paths) {
    fs::path shared;
    auto a = common.begin();
    for (auto b = path.begin(); a != common.end() && b != path.end() && *a == *b; ++a, ++b)
      shared /= *a;
    common = shared;
  }
  return common;
}

void copyFile(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (!error) fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) throw SessionException(from.string() + ": cannot be copied to " + to.string() + ": " + error.message());
}

void writeText(const std::string& text, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  std::ofstream out(to, std::ios::binary);
  out << text;
  if (!out.flush()) throw SessionException(to.string() + ": cannot be written");
}

/** Empty if the copy is as the header says. */
std::string problemOf(const SessionPaths& paths, const ConfigurationFile& file) {
  const std::string path = paths.directory + "/" + file.path;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return file.path + " (missing)";
  return fileHash(path) == file.fnv1a ? "" : file.path + " (changed)";
}

bool staysInside(const std::string& path) {
  const fs::path relative(path);
  return relative.is_relative() && std::find(relative.begin(), relative.end(), "..") == relative.end();
}

}  // namespace

std::vector<ConfigurationFile> copyConfiguration(const SessionPaths& paths,
                                                 const std::vector<std::string>& files,
                                                 const std::map<std::string, std::string>& overridden,
                                                 const std::map<std::string, std::string>& places) {
  std::map<fs::path, std::string> texts;
  for (const auto& [file, text] : overridden)
    texts[normal(file)] = text;
  const std::vector<fs::path> originals = distinct(files);
  std::vector<fs::path> standing;
  for (const fs::path& original : originals) {
    const auto place = places.find(original.string());
    standing.push_back(place == places.end() ? original : normal(place->second));
  }
  const fs::path common = commonFolder(standing);
  std::vector<ConfigurationFile> copies;
  for (std::size_t i = 0; i < originals.size(); ++i) {
    const fs::path& original = originals[i];
    const fs::path relative = fs::path(kFolder) / standing[i].lexically_relative(common);
    const fs::path copy = fs::path(paths.directory) / relative;
    const auto text = texts.find(original);
    text == texts.end() ? copyFile(original, copy) : writeText(text->second, copy);
    copies.push_back({relative.string(), fileHash(copy.string())});
  }
  return copies;
}

std::string checkConfiguration(const SessionPaths& paths, const LogHeader& header) {
  if (header.configuration.empty()) {
    throw SessionException(paths.directory + ": the session has no copy of its configuration");
  }
  std::string problems;
  for (const ConfigurationFile& file : header.configuration) {
    const std::string problem = staysInside(file.path) ? problemOf(paths, file) : file.path + " (outside the session)";
    if (!problem.empty()) problems += (problems.empty() ? "" : ", ") + problem;
  }
  if (!problems.empty()) {
    throw SessionException(paths.directory + ": its configuration is not what the log was recorded with: " + problems);
  }
  return paths.directory + "/" + header.configuration.front().path;
}

}  // namespace raven2_trainer::session
