#include "physics/contact_set.h"

#include <algorithm>
#include <limits>

#include "physics/ode_maths.h"

namespace raven2_trainer::physics {
namespace {

constexpr double kSamePoint = 2.0e-4;  // [m]

bool isShallower(const dContactGeom& a, const dContactGeom& b) noexcept {
  return a.depth < b.depth;
}

/** Neighbouring shapes of one body often touch at one place. */
bool isSame(const dContactGeom& a, const dContactGeom& b) noexcept {
  return (vectorFromOde(a.pos) - vectorFromOde(b.pos)).squaredNorm() < kSamePoint * kSamePoint;
}

/** Squared distance from a point to the nearest of points[0, kept). */
double distanceToKept(const ContactSet::Pair& pair, std::size_t kept, std::size_t candidate) noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  const Vector3 p = vectorFromOde(pair.points[candidate].pos);
  for (std::size_t i = 0; i < kept; ++i) {
    nearest = std::min(nearest, (vectorFromOde(pair.points[i].pos) - p).squaredNorm());
  }
  return nearest;
}

std::size_t farthest(const ContactSet::Pair& pair, std::size_t kept) noexcept {
  std::size_t best = kept;
  double best_distance = -1.0;
  for (std::size_t i = kept; i < pair.count; ++i) {
    const double distance = distanceToKept(pair, kept, i);
    if (distance > best_distance) {
      best = i;
      best_distance = distance;
    }
  }
  return best;
}

void reducePair(ContactSet::Pair* pair) noexcept {
  if (pair->count <= ContactSet::kMaxKept) return;
  dContactGeom* points = pair->points.data();
  std::iter_swap(points, std::max_element(points, points + pair->count, isShallower));
  for (std::size_t kept = 1; kept < ContactSet::kMaxKept; ++kept) {
    std::swap(points[kept], points[farthest(*pair, kept)]);
  }
  pair->count = ContactSet::kMaxKept;
}

}  // namespace

ContactSet::Pair* ContactSet::findPair(int first, int second) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (pairs_[i].first == first && pairs_[i].second == second) return &pairs_[i];
  }
  if (count_ == kMaxPairs) return nullptr;
  Pair* pair = &pairs_[count_++];
  pair->first = first;
  pair->second = second;
  pair->count = 0;
  return pair;
}

void ContactSet::add(int a, int b, const dContactGeom& point) noexcept {
  Pair* pair = findPair(std::min(a, b), std::max(a, b));
  if (pair == nullptr) {
    ++unseen_;
    return;
  }
  for (std::size_t i = 0; i < pair->count; ++i) {
    if (!isSame(pair->points[i], point)) continue;
    if (isShallower(pair->points[i], point)) pair->points[i] = point;
    return;
  }
  if (pair->count < kMaxCandidates) {
    pair->points[pair->count++] = point;
    return;
  }
  dContactGeom* shallowest = std::min_element(pair->points.begin(), pair->points.end(), isShallower);
  if (isShallower(*shallowest, point)) *shallowest = point;
}

void ContactSet::reduce() noexcept {
  for (std::size_t i = 0; i < count_; ++i)
    reducePair(&pairs_[i]);
}

}  // namespace raven2_trainer::physics
