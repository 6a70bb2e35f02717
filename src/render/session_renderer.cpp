#include "raven2_trainer/render/session_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <regex>
#include <utility>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/render/picture_line.h"
#include "raven2_trainer/render/renderer.h"
#include "raven2_trainer/render/video_file.h"
#include "raven2_trainer/render/video_writer.h"
#include "raven2_trainer/session/recovery.h"
#include "raven2_trainer/training/session_metrics.h"
#include "render/chapters.h"
#include "render/edge_tone.h"
#include "render/frame_timeline.h"
#include "render/gl_context.h"
#include "render/join_video.h"
#include "render/part_pool.h"
#include "render/part_store.h"
#include "render/render_settings.h"

namespace raven2_trainer::render {

/** Frames [first, end) of a part. */
struct PartSpan {
  std::size_t first, end;
};

/** The parts of a log for a video. */
struct VideoContents {
  std::vector<Snapshot> frames;  // `lead` of them before the first that is drawn
  std::size_t lead{0};
  std::vector<Chapter> chapters;
  std::vector<std::int64_t> tones;    // [ms]
  SceneOptions scene{HapticGains{}};  // with the recorded session's tolerance
  std::string camera;
  std::size_t part_frames{0};

  /** Of the video. */
  std::size_t count() const { return frames.size() - std::min(lead, frames.size()); }
  std::size_t parts() const { return (count() + part_frames - 1) / part_frames; }
  PartSpan span(std::size_t part) const { return {part * part_frames, std::min((part + 1) * part_frames, count())}; }
};

namespace {

namespace fs = std::filesystem;

constexpr double kInsetShare = 0.3;  // of the picture's width and height
constexpr double kLead =
    600.0;  // [s] of earlier frames that are kept: for the marks of trails, and for a frozen picture

/** [ms] of so many frames. */
std::int64_t lengthOf(std::size_t frames, int fps) {
  return static_cast<std::int64_t>(frames) * 1000 / fps;
}

bool isVideo(const std::string& output) {
  return output.empty() || fs::path(output).extension() == ".mp4";
}

void checkOutput(const std::string& output) {
  std::error_code error;
  const bool is_directory = fs::is_directory(output, error);
  if (isVideo(output) && is_directory) throw ConfigException("--output " + output + ": is a directory");
  if (!isVideo(output) && !is_directory && fs::path(output).has_extension()) {
    throw ConfigException("--output " + output +
                          ": is neither FILE.mp4 nor a directory; with a / at its end it is one");
  }
}

/** Name of a session: its directory's, in any spelling of the path. */
std::string nameOf(const std::string& directory) {
  std::error_code error;
  const fs::path path = fs::canonical(directory, error);
  return path.filename().string();
}

std::string insetOf(const SessionRenderOptions& options, const std::string& camera) {
  if (!options.inset.empty()) return options.inset;
  return camera == "overview" ? "endoscope" : "overview";
}

/** In words, for a reader of the file. */
std::string describe(const VideoContents& contents, const SessionRenderOptions& options, const RenderConfig& render) {
  const double fps = render.video_fps;
  const double from = static_cast<double>(std::llround(std::max(options.from, 0.0) * fps)) / fps;
  std::array<char, 96> span{};
  std::snprintf(span.data(), span.size(), "; %.2f s to %.2f s of the session", from,
                from + static_cast<double>(contents.count()) / fps);
  const std::string inset = insetOf(options, contents.camera);
  const bool has_inset = inset != contents.camera && model::findCamera(render.cameras, inset) != nullptr;
  return "Camera " + contents.camera + (has_inset ? ", in the corner " + inset : "") + span.data();
}

/** Of an earlier render in this directory: whole ones, and those that a kill has cut. */
std::vector<fs::path> picturesIn(const std::string& directory) {
  static const std::regex names(R"(frame_\d+\.png(\.tmp)?)");
  std::error_code error, none;
  std::vector<fs::path> out;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->is_regular_file(none) && std::regex_match(entry->path().filename().string(), names))
      out.push_back(entry->path());
  }
  return out;
}

/** A shorter render would leave the last pictures of a longer one behind its own. */
void refusePictures(const std::string& directory) {
  const std::vector<fs::path> pictures = picturesIn(directory);
  if (pictures.empty()) return;
  throw RenderException(directory + ": holds pictures of an earlier render (" + pictures[0].filename().string() +
                        ", ...); --again removes them");
}

/** For VideoWriter; makes the directory. */
std::string picturePattern(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw RenderException(directory + ": " + error.message());
  std::string pattern;
  for (const char c : directory)
    pattern += c == '%' ? "%%" : std::string(1, c);
  return pattern + "/frame_%06d.png";
}

/** Where OpenGL was used before, nothing may be forked: its threads do not survive that. */
int processCount(int asked) {
  if (GlContext::isUsed()) return 1;
  return asked > 0 ? asked : std::min(processorsAllowed(), SessionRenderer::kMaxProcesses);
}

/** The frames as the trainee saw them. */
void passThroughFaults(std::vector<Snapshot>* frames) {
  PictureLine line;
  for (Snapshot& frame : *frames)
    frame = line.pass(frame);
}

/** Takes the records of a log, sorted by use. */
struct SortedRecords {
  FrameTimeline timeline;
  ChapterList chapters;
  EdgeTone tone;
};

session::LogSummary sortRecords(const std::string& log, SortedRecords* sorted) {
  const ToolContacts tools(session::readLogHeader(log).body_names);
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) {
    sorted->timeline.add(record);
    sorted->chapters.add(record);
    sorted->tone.add(record);
  };
  visitor.haptic = [&](const HapticRecord& record) { sorted->timeline.add(record); };
  visitor.plan = [&](const PlanRecord& record) { sorted->timeline.add(record); };
  visitor.execution = [&](const ExecutionRecord& record) { sorted->timeline.add(record); };
  visitor.contact = [&](const ContactRecord& record) { sorted->timeline.add(record, tools); };
  visitor.exercise = [&](const ExerciseRecord& record) { sorted->chapters.add(record); };
  return session::readLog(log, visitor);
}

/** The attempts' results, if the session was scored. */
void addVerdicts(const std::string& score, std::vector<Snapshot>* frames) {
  if (!fs::exists(score)) return;
  const auto verdicts = training::readVerdicts(score);
  for (Snapshot& frame : *frames) {
    const auto found = verdicts.find(frame.model.exercise.attempt);
    if (found != verdicts.end()) frame.verdict = found->second;
  }
}

/** Everything that draws one frame after the other; made once in each process. */
class FrameDrawer {
 public:
  FrameDrawer(const PictureConfig& config, const VideoContents& contents, const std::string& inset)
      : frames_(contents.frames),
        lead_(contents.lead),
        raven_(model::loadRavenModel(config.source)),
        renderer_(config.render.video_width, config.render.video_height),
        builder_(raven_, model::loadSceneModel(config.source), contents.scene, &renderer_),
        camera_(model::requireCamera(config.render.cameras, contents.camera)),
        inset_(inset != contents.camera ? model::findCamera(config.render.cameras, inset) : nullptr) {}

  /** @param[in] frame of the video. */
  const std::vector<std::uint8_t>& draw(std::size_t frame) {
    const std::size_t k = lead_ + frame;
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
  const std::size_t lead_;
  model::RavenModel raven_;
  Renderer renderer_;
  SceneBuilder builder_;
  const CameraConfig camera_;
  const CameraConfig* inset_;  // null: none
  std::size_t followed_{0};    // frames that the builder knows
};

/** Draws and codes the frames of a span, one after the other. */
void writeSpan(FrameDrawer* drawer, const PartSpan& span, VideoWriter* video, const FrameDone& done) {
  for (std::size_t k = span.first; k < span.end; ++k) {
    video->write(drawer->draw(k));
    done();
  }
  video->finish();
}

std::vector<std::size_t> upTo(std::size_t count) {
  std::vector<std::size_t> out(count);
  for (std::size_t i = 0; i < count; ++i)
    out[i] = i;
  return out;
}

}  // namespace

void checkOptions(const SessionRenderOptions& options) {
  if (!options.output.empty()) return checkOutput(options.output);
  if (options.from > 0.0 || options.to >= 0.0) {
    throw ConfigException(
        "--from, --to: video.mp4 is of the whole session; give a part of it another file: --output FILE.mp4");
  }
}

SessionRenderer::SessionRenderer(const PictureConfig& config, const std::string& directory, std::string build)
    : config_(config), paths_(session::openSessionDirectory(directory)), build_(std::move(build)) {
  // A video of what there is so far would be taken for the session's.
  if (session::isBeingWritten(paths_)) throw SessionException(directory + ": is still being recorded");
}

void SessionRenderer::checkFiles(const session::LogSummary& summary) {
  if (session::fileHash(config_.source.robot_urdf) != summary.header.robot_urdf_hash) {
    warnings_.push_back("the robot's description has changed since the session: " + config_.source.robot_urdf);
  }
  if (session::fileHash(config_.source.scene_urdf) != summary.header.scene_urdf_hash) {
    warnings_.push_back("the scene's description has changed since the session: " + config_.source.scene_urdf);
  }
  if (!summary.clean) warnings_.push_back(paths_.log() + " has no end record: the session did not end well");
  if (summary.bad_bytes > 0)
    warnings_.push_back(paths_.log() + ": unreadable bytes: " + std::to_string(summary.bad_bytes));
}

OverlaySet SessionRenderer::overlaysOf(const SessionRenderOptions& options) const {
  return options.overlays.value_or(config_.render.video_overlays);
}

void SessionRenderer::addVerdictsTo(std::vector<Snapshot>* frames) {
  try {
    addVerdicts(paths_.score(), frames);
  } catch (const SessionException& e) {
    warnings_.emplace_back(e.what());
  }
}

VideoContents SessionRenderer::read(const SessionRenderOptions& options) {
  const RenderConfig& render = config_.render;
  SortedRecords records{FrameTimeline(render.video_fps, options.from, options.to, kLead), {}, {}};
  const session::LogSummary summary = sortRecords(paths_.log(), &records);
  checkFiles(summary);
  VideoContents out;
  out.frames = records.timeline.frames(summary.header.scenarios);
  out.lead = static_cast<std::size_t>(records.timeline.leadFrames());
  if (records.timeline.sessionFrames() == 0) throw SessionException(paths_.log() + ": the pedal was never down");
  if (out.count() == 0) throw SessionException(paths_.log() + ": no frame between --from and --to");
  addVerdictsTo(&out.frames);
  const bool names_hazards = overlaysOf(options).has(OverlayKind::kHazard);
  if (!names_hazards) passThroughFaults(&out.frames);
  const std::int64_t from = records.timeline.firstFrame() * 1000 / render.video_fps;
  const std::int64_t to = from + lengthOf(out.count(), render.video_fps);
  out.chapters = records.chapters.chapters(summary.header, {from, to, names_hazards});
  out.tones = records.tone.tones(from, to);
  out.scene = SceneOptions(config_, overlaysOf(options));
  out.scene.haptics.tolerance = summary.header.tolerance;
  out.camera = options.camera.empty() ? render.video_camera : options.camera;
  model::requireCamera(render.cameras, out.camera);
  out.part_frames = static_cast<std::size_t>(kPartSeconds) * static_cast<std::size_t>(render.video_fps);
  return out;
}

void SessionRenderer::writePictures(const VideoContents& contents,
                                    const SessionRenderOptions& options,
                                    const Progress& progress) {
  for (const fs::path& picture : picturesIn(options.output))
    fs::remove(picture);
  const std::string pattern = picturePattern(options.output);
  const MakeDrawPart make = [&]() -> DrawPart {
    const auto drawer = std::make_shared<FrameDrawer>(config_, contents, insetOf(options, contents.camera));
    return [&, drawer](std::size_t part, const FrameDone& done) {
      const PartSpan span = contents.span(part);
      VideoWriter pictures(pattern, config_.render, span.first);
      writeSpan(drawer.get(), span, &pictures, done);
    };
  };
  std::uint64_t drawn = 0;
  drawParts(upTo(contents.parts()), processCount(options.processes), make, [&] {
    if (progress) progress(++drawn, contents.count());
  });
}

void SessionRenderer::writeVideo(const VideoContents& contents,
                                 const SessionRenderOptions& options,
                                 const std::string& settings,
                                 const Progress& progress) {
  const std::string video = outputOf(options);
  PartStore store(partFolder(video), settings, contents.parts());
  const MakeDrawPart make = [&]() -> DrawPart {
    const auto drawer = std::make_shared<FrameDrawer>(config_, contents, insetOf(options, contents.camera));
    return [&, drawer](std::size_t part, const FrameDone& done) {
      VideoWriter draft(store.draft(part), config_.render);
      writeSpan(drawer.get(), contents.span(part), &draft, done);
      store.keep(part);
    };
  };
  const std::vector<std::size_t> missing = store.missing();
  reused_ = contents.count();
  for (const std::size_t part : missing)
    reused_ -= contents.span(part).end - contents.span(part).first;
  if (progress && reused_ > 0) progress(reused_, contents.count());
  std::uint64_t drawn = reused_;
  drawParts(missing, processCount(options.processes), make, [&] {
    if (progress) progress(++drawn, contents.count());
  });
  joinVideo({store.folder(), store.names(), contents.chapters, contents.tones,
             lengthOf(contents.count(), config_.render.video_fps), nameOf(paths_.directory),
             describe(contents, options, config_.render), settingsComment(settings)},
            video);
  if (options.output.empty() && fs::exists(paths_.metrics())) training::setFrames(paths_.metrics(), contents.count());
  store.remove();  // last: as long as it is there, another run does the rest
}

std::string SessionRenderer::outputOf(const SessionRenderOptions& options) const {
  return options.output.empty() ? paths_.video() : options.output;
}

std::string SessionRenderer::settingsOf(const SessionRenderOptions& options) const {
  const std::string camera = options.camera.empty() ? config_.render.video_camera : options.camera;
  return settingsHash(config_, options, model::requireCamera(config_.render.cameras, camera).name, paths_, build_);
}

bool SessionRenderer::hasVideo(const SessionRenderOptions& options) const {
  checkOptions(options);
  const std::string video = outputOf(options);
  if (!isVideo(options.output) || isUnfinished(video)) return false;
  const std::string drawn = videoSettings(video);
  return !drawn.empty() && drawn == settingsOf(options);
}

std::uint64_t SessionRenderer::run(const SessionRenderOptions& options, const Progress& progress) {
  warnings_.clear();
  reused_ = 0;
  checkOptions(options);
  if (!isVideo(options.output)) {
    if (!options.replace) refusePictures(options.output);
    const VideoContents contents = read(options);
    writePictures(contents, options, progress);
    return contents.count();
  }
  // Before the log and the score are read: what changes from here on is of other settings.
  const std::string settings = settingsOf(options);
  const VideoContents contents = read(options);
  writeVideo(contents, options, settings, progress);
  return contents.count();
}

}  // namespace raven2_trainer::render
