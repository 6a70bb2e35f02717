#pragma once

#include <map>
#include <string>

namespace raven2_trainer::recording {

/**
 * Everything that decides over the bits of a simulation, apart from its inputs, each by name:
 * `sources` (hash of this package's C++), `compiler` (with its flags), `processor` (the instructions that libm chooses
 * its code by), and for each of libode, libm, libc and libstdc++ as loaded, the hash of its file.
 */
std::map<std::string, std::string> buildIdentity();

/** Everything that decides over the pixels of pictures, apart from their contents: the same, whether OSMesa or EGL
 * draws
 *  (`opengl`; it is loaded), and its libraries: libOSMesa or libEGL_mesa, libgallium, libLLVM; in one text, a line
 *  each. These by their build IDs, or by the hash of the file where there is no ID. @throw RenderException if neither
 * is
 * there. */
std::string pictureIdentity();

}  // namespace raven2_trainer::recording
