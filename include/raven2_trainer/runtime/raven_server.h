#pragma once

#include <array>
#include <atomic>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/net/event_fd.h"
#include "raven2_trainer/net/tcp_server.h"
#include "raven2_trainer/net/udp_receiver.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/runtime/cyclic_thread.h"
#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::runtime {

/** The virtual Raven's threads: control loop with plant (1 kHz), UDP receiver, TCP server. */
class RavenServer {
 public:
  /** @throw NetworkException, ModelException. */
  explicit RavenServer(const TrainerConfig& config);
  ~RavenServer();
  void start();
  void stop();
  /** State after the last control cycle. */
  RobotState state() const noexcept { return state_.load(); }
  LoopTiming timing() const noexcept { return timing_.load(); }
  /** The start button of the emulated PLC: out of E-STOP, after its cause is gone. Any thread. */
  void pressStart() noexcept { start_pressed_.store(true, std::memory_order_relaxed); }
  std::uint64_t framesDropped() const noexcept { return frames_dropped_.load(std::memory_order_relaxed); }
  bool realtime() const noexcept { return control_.realtime(); }

 private:
  /** Longer datagrams are cut here as the robot's recvfrom does; 256 bytes keep "longer" visible. */
  struct Datagram {
    std::uint32_t size{};
    std::array<std::uint8_t, 256> bytes{};
  };
  class Readers;

  void controlTick() noexcept;
  void receiveLoop();
  void serveLoop();

  model::RavenModel model_;
  raven::ControlSoftware software_;
  plant::Plant plant_;
  net::UdpReceiver receiver_;
  net::TcpServer server_;
  net::EventFd state_ready_;

  SpscRing<Datagram, 256> datagrams_;  // receiver -> control
  SpscRing<RobotState, 256> states_;   // control -> server
  StateCell<FaultPlan> faults_;        // written by server
  StateCell<RobotState> state_;        // written by control
  StateCell<LoopTiming> timing_;       // written by control
  std::atomic<std::uint64_t> frames_dropped_{0};
  std::atomic<bool> start_pressed_{false};
  std::atomic<bool> stop_{false};

  CyclicThread control_;
  Thread receive_thread_, serve_thread_;
};

}  // namespace raven2_trainer::runtime
