#include "render/edge_tone.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "raven2_trainer/control/reach.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

constexpr std::int64_t kPerMs = EdgeTone::kRate / 1000;
constexpr std::int64_t kSamples = EdgeTone::kLength * kPerMs;  // of a tone
constexpr std::int64_t kRise = 5 * kPerMs;                     // without a rise and a fall it would click
constexpr double kLoudness = 0.25 * 32767.0;

/** Sample `i` of a tone. */
std::int16_t sampleAt(std::int64_t i) {
  const double ramp = std::min(1.0, static_cast<double>(std::min(i, kSamples - 1 - i)) / static_cast<double>(kRise));
  const double phase = 2.0 * kPi * EdgeTone::kPitch * static_cast<double>(i) / static_cast<double>(EdgeTone::kRate);
  return static_cast<std::int16_t>(std::lround(kLoudness * ramp * std::sin(phase)));
}

/** Least significant byte first, whatever the machine. */
void put(std::int64_t value, int bytes, std::string* out) {
  for (int i = 0; i < bytes; ++i)
    out->push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
}

/** RIFF, PCM of 16 bits, mono. Sizes are of 32 bits: 37 hours at this rate. */
std::string header(std::int64_t samples) {
  std::string out = "RIFF";
  put(36 + 2 * samples, 4, &out);
  out += "WAVEfmt ";
  put(16, 4, &out);
  put(1, 2, &out);
  put(1, 2, &out);
  put(EdgeTone::kRate, 4, &out);
  put(2 * EdgeTone::kRate, 4, &out);
  put(2, 2, &out);
  put(16, 2, &out);
  out += "data";
  put(2 * samples, 4, &out);
  return out;
}

}  // namespace

void EdgeTone::add(const TickRecord& record) {
  const Tick now = record.model.session_tick;
  if (now < 0) return;
  if (!control::isAtEdge(record.model, Arm::kGold) && !control::isAtEdge(record.model, Arm::kGreen)) return;
  if (stays_.empty() || now - stays_.back().last > kPause)
    stays_.push_back({now, now});
  else
    stays_.back().last = now;
}

std::vector<std::int64_t> EdgeTone::tones(std::int64_t from, std::int64_t to) const {
  std::vector<std::int64_t> out;
  for (const Stay& stay : stays_) {
    for (Tick at = stay.first; at <= stay.last; at += kRepeat) {
      if (at >= from && at < to) out.push_back(at - from);
    }
  }
  return out;
}

void writeTones(const std::string& path, const std::vector<std::int64_t>& tones, std::int64_t length) {
  std::ofstream file(path, std::ios::binary);
  file << header(length * kPerMs);
  std::string second;
  auto next = tones.begin();
  for (std::int64_t i = 0; i < length * kPerMs; ++i) {
    while (next != tones.end() && i >= *next * kPerMs + kSamples)
      ++next;
    const bool sounds = next != tones.end() && i >= *next * kPerMs;
    put(sounds ? sampleAt(i - *next * kPerMs) : 0, 2, &second);
    if (second.size() < 2 * EdgeTone::kRate) continue;
    file << second;
    second.clear();
  }
  file << second;
  file.close();
  if (!file) throw RenderException(path + ": cannot be written");
}

}  // namespace raven2_trainer::render
