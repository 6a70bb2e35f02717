#include "raven2_trainer/core/nearest_name.h"

#include <algorithm>
#include <cstddef>

namespace raven2_trainer {
namespace {

constexpr std::size_t kMostNames = 20;  // of a list that somebody reads
constexpr std::size_t kLongestTyped = 64;

/** Letters to change, to add, to leave out or to swap with the next one (optimal string alignment). */
std::size_t distanceOf(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t changed = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, changed});
      const bool is_swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearestName(const std::string& name, const std::vector<std::string>& known, std::size_t most_mistakes) {
  std::string nearest;
  std::size_t least = most_mistakes + 1;
  if (name.size() > kLongestTyped) return nearest;
  for (const std::string& each : known) {
    if (each.size() > kLongestTyped) continue;
    const std::size_t distance = distanceOf(name, each);
    if (distance > least || distance > most_mistakes || 2 * distance >= std::min(name.size(), each.size())) continue;
    nearest = (distance == least ? nearest + "\" or \"" : "") + each;
    least = distance;
  }
  return nearest;
}

std::string didYouMean(const std::string& name, const std::vector<std::string>& known, std::size_t most_mistakes) {
  const std::string nearest = nearestName(name, known, most_mistakes);
  return nearest.empty() ? "" : ": did you mean \"" + nearest + "\"?";
}

std::string expectedOneOf(const std::string& name, const std::vector<std::string>& known) {
  const std::string hint = didYouMean(name, known);
  if (!hint.empty()) return hint;
  std::string list;
  for (const std::string& each : known)
    list += (list.empty() ? "" : ", ") + each;
  return ", expected one of: " + list;
}

std::string unknownName(const std::string& what, const std::string& name, const std::vector<std::string>& known) {
  const std::string said = "no " + what + " is called \"" + name + "\"";
  const std::string hint = didYouMean(name, known);
  if (!hint.empty()) return said + hint;
  std::string list;
  for (std::size_t i = 0; i < std::min(known.size(), kMostNames); ++i)
    list += (list.empty() ? "" : ", ") + known[i];
  if (known.size() > kMostNames) list += " and " + std::to_string(known.size() - kMostNames) + " more";
  return said + "; known: " + (list.empty() ? "none" : list);
}

}  // namespace raven2_trainer
