#pragma once

#include <map>
#include <string>

namespace raven2_trainer::runtime {

/**
 * What decides over the bits of a simulation beside its inputs, each by name:
 * `sources` (hash of this package's C++), `compiler` (with its flags), `processor` (the instructions that libm chooses
 * its code by), and for each of libode, libm, libc and libstdc++ as loaded, the hash of its file.
 */
std::map<std::string, std::string> buildIdentity();

/** What decides over the pixels of pictures beside what they show: the same, libOSMesa, and libLLVM where that draws
 * with it; in one text, a line each. These two by their build IDs, or by the hash of the file where there is no ID. */
std::string pictureIdentity();

}  // namespace raven2_trainer::runtime
