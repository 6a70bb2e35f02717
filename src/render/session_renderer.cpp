#include "raven2_trainer/render/session_renderer.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/render/picture_line.h"
#include "raven2_trainer/render/renderer.h"
#include "raven2_trainer/render/video_writer.h"
#include "raven2_trainer/training/session_metrics.h"
#include "render/frame_source.h"
#include "render/frame_timeline.h"
#include "render/gl_context.h"

namespace raven2_trainer::render {

namespace {

constexpr double kInsetShare = 0.3;  // of the picture's width and height

const CameraConfig* findCamera(const RenderConfig& config, const std::string& name) {
  const auto found = std::find_if(config.cameras.begin(), config.cameras.end(),
                                  [&name](const CameraConfig& camera) { return camera.name == name; });
  return found == config.cameras.end() ? nullptr : &*found;
}

const CameraConfig& requireCamera(const RenderConfig& config, const std::string& name) {
  if (const CameraConfig* camera = findCamera(config, name)) return *camera;
  std::string known;
  for (const CameraConfig& camera : config.cameras)
    known += " " + camera.name;
  throw ConfigException("camera " + name + " is not one of:" + known);
}

/** File or pattern for VideoWriter; makes the directory of PNG pictures. */
std::string outputPath(const std::string& output, const session::SessionPaths& paths) {
  if (output.empty()) return paths.video();
  const std::filesystem::path path(output);
  if (path.extension() == ".mp4") return output;
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw RenderException(output + ": " + error.message());
  std::string pattern;
  for (const char c : output)
    pattern += c == '%' ? "%%" : std::string(1, c);
  return pattern + "/frame_%06d.png";
}

/** Where OpenGL was used before, nothing may be forked: its threads do not survive that. */
int processCount(int asked) {
  if (GlContext::isUsed()) return 1;
  return asked > 0 ? asked : std::clamp(static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)), 1, 8);
}

/** The frames as the trainee saw them. */
void passThroughFaults(std::vector<Snapshot>* frames) {
  PictureLine line;
  for (Snapshot& frame : *frames)
    frame = line.pass(frame);
}

/** What the attempts came to, if the session was scored. */
void addVerdicts(const std::string& score, std::vector<Snapshot>* frames) {
  if (!std::filesystem::exists(score)) return;
  const auto verdicts = training::readVerdicts(score);
  for (Snapshot& frame : *frames) {
    const auto found = verdicts.find(frame.model.exercise.attempt);
    if (found != verdicts.end()) frame.verdict = found->second;
  }
}

/** Everything that draws one frame after the other; made once in each process. */
class FrameDrawer {
 public:
  FrameDrawer(const TrainerConfig& config,
              const SceneOptions& options,
              const std::string& camera,
              const std::string& inset,
              const std::vector<Snapshot>& frames)
      : frames_(frames),
        raven_(model::loadRavenModel(config)),
        renderer_(config.render.video_width, config.render.video_height),
        builder_(raven_, model::loadSceneModel(config), options, &renderer_),
        camera_(requireCamera(config.render, camera)),
        inset_(inset != camera ? findCamera(config.render, inset) : nullptr) {}

  const Pixels& draw(std::size_t k) {
    for (; followed_ < k; ++followed_)
      builder_.follow(frames_[followed_]);
    const int w = renderer_.width(), h = renderer_.height();
    const model::Camera camera = cameraOf(camera_, k, w, h);
    if (inset_ == nullptr) return renderer_.draw(builder_.build(frames_[k]), camera);
    const model::Camera inset =
        cameraOf(*inset_, k, static_cast<int>(w * kInsetShare), static_cast<int>(h * kInsetShare));
    return renderer_.draw(builder_.build(frames_[k]), camera, &inset);
  }

 private:
  model::Camera cameraOf(const CameraConfig& camera, std::size_t k, int width, int height) const {
    return cameraSeeing(frames_[k], camera, raven_.X_WB, width, height);
  }

  const std::vector<Snapshot>& frames_;
  model::RavenModel raven_;
  Renderer renderer_;
  SceneBuilder builder_;
  const CameraConfig camera_;
  const CameraConfig* inset_;  // null: none
  std::size_t followed_{0};    // frames that the builder knows
};

}  // namespace

SessionRenderer::SessionRenderer(const TrainerConfig& config, const std::string& directory)
    : config_(config), paths_(session::openSessionDirectory(directory)) {}

void SessionRenderer::checkFiles(const session::LogSummary& summary) {
  if (session::fileHash(config_.robot_urdf) != summary.header.robot_urdf_hash) {
    warnings_.push_back("the robot's description has changed since the session: " + config_.robot_urdf);
  }
  if (session::fileHash(config_.scene_urdf) != summary.header.scene_urdf_hash) {
    warnings_.push_back("the scene's description has changed since the session: " + config_.scene_urdf);
  }
  if (!summary.clean) warnings_.push_back(paths_.log() + " has no end record: the session did not end well");
  if (summary.bad_bytes > 0)
    warnings_.push_back(paths_.log() + ": unreadable bytes: " + std::to_string(summary.bad_bytes));
}

OverlaySet SessionRenderer::overlaysOf(const SessionRenderOptions& options) const {
  return options.overlays.value_or(config_.render.video_overlays);
}

std::vector<Snapshot> SessionRenderer::readFrames(const SessionRenderOptions& options) {
  FrameTimeline timeline(config_.render.video_fps, options.from, options.to);
  session::LogVisitor visitor;
  visitor.tick = [&timeline](const TickRecord& record) { timeline.add(record); };
  visitor.haptic = [&timeline](const HapticRecord& record) { timeline.add(record); };
  visitor.plan = [&timeline](const PlanRecord& record) { timeline.add(record); };
  visitor.execution = [&timeline](const ExecutionRecord& record) { timeline.add(record); };
  const ToolContacts tools(session::readLogHeader(paths_.log()).body_names);
  visitor.contact = [&](const ContactRecord& record) { timeline.add(record, tools); };
  const session::LogSummary summary = session::readLog(paths_.log(), visitor);
  checkFiles(summary);
  tolerance_ = summary.header.tolerance;
  std::vector<Snapshot> frames = timeline.frames(summary.header.scenarios);
  if (timeline.sessionFrames() == 0) throw SessionException(paths_.log() + ": the pedal was never down");
  if (frames.empty()) throw SessionException(paths_.log() + ": no frame between --from and --to");
  try {
    addVerdicts(paths_.score(), &frames);
  } catch (const SessionException& e) {
    warnings_.emplace_back(e.what());
  }
  if (!overlaysOf(options).has(OverlayKind::kHazard)) passThroughFaults(&frames);
  return frames;
}

std::uint64_t SessionRenderer::write(const std::vector<Snapshot>& frames,
                                     const SessionRenderOptions& options,
                                     const Progress& progress) const {
  SceneOptions scene(config_, overlaysOf(options));
  scene.haptics.tolerance = tolerance_;
  const RenderConfig& render = config_.render;
  const std::string camera = options.camera.empty() ? render.video_camera : options.camera;
  requireCamera(render, camera);
  const MakeDrawFrame make = [&]() -> DrawFrame {
    const auto drawer = std::make_shared<FrameDrawer>(config_, scene, camera, options.inset, frames);
    return [drawer](std::size_t k) -> const Pixels& { return drawer->draw(k); };
  };
  const std::size_t frame_bytes =
      static_cast<std::size_t>(render.video_width) * static_cast<std::size_t>(render.video_height) * 3;
  // Forked first, so that the drawing processes do not hold the encoder's input open.
  const auto source = makeFrameSource(frames.size(), frame_bytes, processCount(options.processes), make);
  VideoWriter video(outputPath(options.output, paths_), render);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    video.write(source->next());
    if (progress) progress(k + 1, frames.size());
  }
  video.finish();
  return video.frames();
}

std::uint64_t SessionRenderer::run(const SessionRenderOptions& options, const Progress& progress) {
  warnings_.clear();
  const std::vector<Snapshot> frames = readFrames(options);
  const std::uint64_t written = write(frames, options, progress);
  if (options.output.empty() && std::filesystem::exists(paths_.metrics()))
    training::setFrames(paths_.metrics(), written);
  return written;
}

}  // namespace raven2_trainer::render
