#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>

#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/net/event_fd.h"
#include "raven2_trainer/net/udp_receiver.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/raven/raven_report.h"
#include "raven2_trainer/robot/raven_automove.h"
#include "raven2_trainer/robot/state_server.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "raven2_trainer/threads/runtime_config.h"

namespace raven2_trainer {
struct TrainerConfig;
}

namespace raven2_trainer::robot {

/** The virtual Raven's threads: control loop with plant (1 kHz), UDP receiver, state server. */
class RavenServer {
 public:
  /** @throw NetworkException, ModelException, ConfigException (the key). */
  explicit RavenServer(const TrainerConfig& config);
  ~RavenServer();
  void start();
  void stop();

  // Any thread.
  /** State after the last control cycle. */
  RobotState state() const noexcept { return state_.load(); }
  /** Cycles in which the detector replaced a command or stopped the robot; 0 without one. */
  std::uint64_t detectorCycles() const noexcept { return detector_cycles_.load(std::memory_order_relaxed); }
  /** The start button of the emulated PLC: out of E-STOP, after its cause is gone. */
  void pressStart() noexcept { start_pressed_.store(true, std::memory_order_relaxed); }
  const StateServer& stateServer() const noexcept { return state_server_; }
  /** Why the control loop did not get its priority; empty if it did. */
  std::string refusal() const { return control_.refusal(); }

  // One thread: what publishes on ROS.
  /** Waits at most `timeout_ms` for the report of a cycle. */
  void waitForReport(int timeout_ms) noexcept { report_ready_.wait(timeout_ms); }
  /** Next report, one a cycle, in order. @return false if none waits. */
  bool nextReport(RavenReport* report) noexcept { return reports_.tryPop(report); }
  /** Reports lost because nobody took them. */
  std::uint64_t reportsDropped() const noexcept { return reports_.dropped(); }

  /** One message of /raven_automove, from one thread. @return false if there is no room. */
  bool automove(const RavenAutomove& move) noexcept { return automoves_.tryPush(move); }

 private:
  /** Cut at 256 bytes, as the robot's recvfrom cuts: still longer than an ITP packet. */
  struct Datagram {
    std::uint32_t size{};
    std::uint64_t source{};
    wire::Nonce fresh{};  ///< nonce for its answer; random only if it is a handshake
    std::array<std::uint8_t, 256> bytes{};
  };

  /** Answer of the control thread, which the network thread sends. */
  struct Reply {
    std::uint64_t to{};
    wire::HandshakeBytes bytes{};
  };

  void controlTick(std::int64_t now_ns) noexcept;
  void takeInputs() noexcept;
  void publish(std::int64_t now_ns) noexcept;
  RobotState withLost(RobotState state) const noexcept;
  void receiveLoop();
  void takeDatagrams();
  void sendReplies();

  model::RavenModel model_;
  const bool verifies_;
  std::unique_ptr<const wire::ItpKey> key_;
  raven::ControlSoftware software_;
  plant::Plant plant_;
  net::UdpReceiver receiver_;
  StateServer state_server_;
  RuntimeConfig runtime_;
  net::EventFd report_ready_;

  SpscRing<Datagram, 256> datagrams_;              // receiver -> control
  SpscRing<Reply, 16> replies_;                    // control -> receiver
  SpscRing<RavenReport, 256> reports_;             // control -> ros
  SpscRing<RavenAutomove, 64> automoves_;          // ros -> control
  StateCell<RobotState> state_;                    // written by control
  StateCell<LoopTiming> timing_;                   // written by control
  std::atomic<std::uint64_t> detector_cycles_{0};  // written by control
  std::atomic<bool> start_pressed_{false};
  std::atomic<bool> stop_{false};

  threads::CyclicThread control_;
  threads::Thread receive_thread_;
};

}  // namespace raven2_trainer::robot
