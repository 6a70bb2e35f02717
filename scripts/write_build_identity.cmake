# Writes OUTPUT, a C++ source with the hash of all sources of the package below ROOT and the COMPILER as it is used:
# what a session's meta.json says about the build it was made with. Run by the build with cmake -P.
file(GLOB_RECURSE files ${ROOT}/src/*.cpp ${ROOT}/src/*.h ${ROOT}/include/*.h)
list(SORT files)
set(all "")
foreach(name IN LISTS files)
  file(RELATIVE_PATH relative ${ROOT} ${name})
  file(SHA1 ${name} hash)
  string(APPEND all "${relative} ${hash}\n")
endforeach()
string(SHA1 sources "${all}")
file(WRITE ${OUTPUT}
"namespace raven2_trainer::recording {
extern const char* const kBuildSources;
extern const char* const kBuildCompiler;
const char* const kBuildSources = \"${sources}\";
const char* const kBuildCompiler = \"${COMPILER}\";
}  // namespace raven2_trainer::recording
")
