#include "raven2_trainer/model/mesh.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::model {
namespace {

constexpr float kSmoothingAngle = 40.0F;  // [deg] edges sharper than this stay sharp
constexpr double kMaxSize = 10.0;         // [m]
constexpr std::size_t kMaxTriangles = 1'000'000;
constexpr std::uintmax_t kMaxMeshBytes = 64U << 20U;  // a million triangles as binary STL, 240,000 as text
// Of the forty formats that assimp reads, those that robot descriptions use.
constexpr std::array<const char*, 3> kFormats{".stl", ".obj", ".dae"};

std::string extensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

/**
 * Lets a mesh read no file but its own: OBJ and DAE may name others, anywhere. For OBJ, assimp 5.2 keeps a line in a
 * buffer as long as the file, and gives its numbers to strtol. strtol reads on if one line fills the buffer. A
 * line end and a zero after the file prevent that.
 */
class OneFileSystem : public Assimp::DefaultIOSystem {
 public:
  explicit OneFileSystem(std::string path) : path_(std::move(path)) {}
  bool Exists(const char* file) const override { return path_ == file && DefaultIOSystem::Exists(file); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (path_ != file) return nullptr;
    return extensionOf(path_) == ".obj" ? openEnded() : DefaultIOSystem::Open(file, mode);
  }

 private:
  Assimp::IOStream* openEnded() {
    std::ifstream file(path_, std::ios::binary);
    if (!file) return nullptr;
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
    bytes_.push_back('\n');
    bytes_.push_back('\0');
    return new Assimp::MemoryIOStream(bytes_.data(), bytes_.size());  // Close() deletes it
  }

  std::string path_;
  std::vector<std::uint8_t> bytes_;
};

const aiScene* import(Assimp::Importer* importer, const std::string& path) {
  importer->SetIOHandler(new OneFileSystem(path));  // the importer deletes it
  importer->SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_COLORS |
                                                           aiComponent_TEXCOORDS | aiComponent_TANGENTS_AND_BITANGENTS);
  importer->SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer->SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kSmoothingAngle);
  return importer->ReadFile(path, aiProcess_RemoveComponent | aiProcess_Triangulate | aiProcess_SortByPType |
                                      aiProcess_PreTransformVertices | aiProcess_GenSmoothNormals |
                                      aiProcess_JoinIdenticalVertices);
}

void checkFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw ModelException(path + ":1: no such mesh file");
  if (std::filesystem::file_size(path, error) > kMaxMeshBytes) throw ModelException(path + ":1: mesh file over 64 MiB");
  const std::string extension = extensionOf(path);
  if (std::find(kFormats.begin(), kFormats.end(), extension) == kFormats.end()) {
    throw ModelException(path + ":1: \"" + extension + "\" is no mesh format of .stl, .obj, .dae");
  }
}

void checkScale(const std::string& path, const std::array<double, 3>& scale) {
  for (const double s : scale) {
    if (!std::isfinite(s) || s == 0.0) throw ModelException(path + ":1: scale " + std::to_string(s));
  }
}

/** A normal is a covector: it scales with the inverse. Degenerate triangles have no normal. */
std::array<float, 3> scaledNormal(const aiVector3D& n, const std::array<double, 3>& scale) {
  const Vector3 v(n.x / scale[0], n.y / scale[1], n.z / scale[2]);
  const double length = v.norm();
  if (!std::isfinite(length) || length < 1e-12) return {0.0F, 0.0F, 1.0F};
  return {static_cast<float>(v.x() / length), static_cast<float>(v.y() / length), static_cast<float>(v.z() / length)};
}

void appendVertices(const aiMesh& part, const std::array<double, 3>& scale, Mesh* mesh, const std::string& path) {
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D& p = part.mVertices[i];
    const std::array<double, 3> scaled{p.x * scale[0], p.y * scale[1], p.z * scale[2]};
    for (const double x : scaled) {
      if (!std::isfinite(x)) throw ModelException(path + ":1: mesh with a coordinate that is not finite");
      if (std::abs(x) > kMaxSize) throw ModelException(path + ":1: mesh larger than 10 m; is it in millimetres?");
    }
    mesh->vertices.push_back(
        {static_cast<float>(scaled[0]), static_cast<float>(scaled[1]), static_cast<float>(scaled[2])});
    mesh->normals.push_back(scaledNormal(part.mNormals != nullptr ? part.mNormals[i] : aiVector3D(), scale));
  }
}

void append(const aiMesh& part, const std::array<double, 3>& scale, Mesh* mesh, const std::string& path) {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  if (mesh->triangles.size() + part.mNumFaces > kMaxTriangles) {
    throw ModelException(path + ":1: mesh with more than 1,000,000 triangles");
  }
  appendVertices(part, scale, mesh, path);
  const bool mirrored = scale[0] * scale[1] * scale[2] < 0.0;
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;
    for (unsigned k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= part.mNumVertices)
        throw ModelException(path + ":1: triangle of a vertex that is not there");
    }
    const unsigned b = mirrored ? 2 : 1;
    mesh->triangles.push_back({first + face.mIndices[0], first + face.mIndices[b], first + face.mIndices[3 - b]});
  }
}

}  // namespace

Mesh loadMesh(const std::string& path, const std::array<double, 3>& scale) {
  checkFile(path);
  checkScale(path, scale);
  Assimp::Importer importer;
  const aiScene* scene = import(&importer, path);
  if (scene == nullptr) throw ModelException(path + ":1: " + importer.GetErrorString());
  Mesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    append(*scene->mMeshes[i], scale, &mesh, path);
  if (mesh.triangles.empty()) throw ModelException(path + ":1: mesh without triangles");
  return mesh;
}

}  // namespace raven2_trainer::model
