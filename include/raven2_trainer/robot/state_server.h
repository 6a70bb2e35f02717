#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <string>

#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/net/event_fd.h"
#include "raven2_trainer/net/tcp_server.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::robot {

/**
 * The robot's end of the TCP link (doc/wire.md): hello, one state frame a cycle to every reader, fault plans back. A
 * separate thread sends; push() only puts the state into a ring.
 *
 * Fault plans: the first reader that sends one owns the plan until it leaves, then nothing is armed; if the same
 * session comes back, its faults go on where they would be by then. The others' plans are refused and counted; the
 * owner's own, sent again byte for byte, is passed over; every plan is answered. A real robot refuses every plan.
 * Beginnings and ends of faults go to every reader. A reader is closed if it begins a frame and does not finish it
 * within kFrameDeadlineNs, breaks the stream, or takes nothing for TcpServer::kStallNs.
 */
class StateServer {
 public:
  static constexpr std::int64_t kFrameDeadlineNs = 500'000'000;  ///< [ns] sources.md 2.2

  /** @throw NetworkException. */
  StateServer(const std::string& bind_address, std::uint16_t port, bool is_virtual);
  ~StateServer() { stop(); }
  StateServer(const StateServer&) = delete;
  StateServer& operator=(const StateServer&) = delete;

  /** Starts the thread; without it a test calls serve(). @throw RealtimeException. */
  void start();
  void stop();

  /** The state of a cycle, from one thread. Real-time safe. A full ring drops it, counted in statesDropped(). */
  void push(const RobotState& state) noexcept;

  /** A fault that began or ended, ahead of the state of that cycle. The same. */
  void push(const FaultChange& change) noexcept;

  /** One round of the thread: sends waiting states, receives from the readers. */
  void serve(std::int64_t now_ns);

  /** The plan armed now; its generation changes with every plan. Any thread. */
  const StateCell<FaultPlan>& faults() const noexcept { return faults_; }

  /** Signals for triggers, from the owner of the plan. Any thread. */
  const StateCell<FaultSignals>& signals() const noexcept { return signals_; }

  std::uint16_t port() const noexcept { return server_.port(); }

  // Any thread.
  /** Counts of all frames, as of the last serve(). */
  net::FrameTotals frames() const noexcept { return frames_.load(); }
  std::uint64_t framesDropped() const noexcept { return frames().dropped; }
  std::uint64_t statesDropped() const noexcept { return states_.dropped(); }
  std::uint64_t readersRefused() const noexcept { return readers_refused_.load(std::memory_order_relaxed); }
  std::uint64_t readersEvicted() const noexcept { return readers_evicted_.load(std::memory_order_relaxed); }
  std::uint64_t plansRefused() const noexcept { return plans_refused_.load(std::memory_order_relaxed); }
  std::size_t readers() const noexcept { return reader_count_.load(std::memory_order_relaxed); }
  /** Readers of which a part of a frame waits for the rest. */
  std::size_t partsWaiting() const noexcept { return parts_waiting_.load(std::memory_order_relaxed); }

 private:
  using ClientId = net::TcpServer::ClientId;
  class Events;

  struct Reader {
    wire::FrameParser parser;
    std::int64_t part_since{0};  ///< [ns] since when a part of a frame waits; 0 none
    bool was_refused{false};     ///< a plan of it, and that was reported
    FaultSignals signals;        ///< as it sent them last, whether its plan is armed or not
  };

  void greet(ClientId client);
  void receive(ClientId client, const std::uint8_t* bytes, std::size_t size);
  void handle(ClientId client, Reader* reader, const wire::Frame& frame);
  void refuse(ClientId client, Reader* reader, const char* why);
  void report(const std::string& words);
  void arm(const FaultPlan& plan);
  void forget(ClientId client);
  void closeDribblers(std::int64_t now_ns);

  const bool is_virtual_;
  net::TcpServer server_;
  net::EventFd state_ready_;
  SpscRing<RobotState, 256> states_;    // push() -> thread
  SpscRing<FaultChange, 256> changes_;  // push() -> thread
  StateCell<FaultPlan> faults_;         // written by the thread
  StateCell<FaultSignals> signals_;     // written by the thread
  StateCell<net::FrameTotals> frames_;  // written by the thread
  std::atomic<std::uint64_t> plans_refused_{0}, readers_refused_{0}, readers_evicted_{0};
  std::atomic<std::size_t> reader_count_{0}, parts_waiting_{0};
  std::atomic<bool> stop_{false};

  // The thread's own.
  std::map<ClientId, Reader> connected_;
  ClientId plan_owner_{0};
  wire::FrameBytes owners_plan_;  // as its owner sent it
  std::uint32_t session_{0};      // of the owner, or of the last one
  std::uint64_t generation_{0};
  std::uint32_t sequence_{0};
  std::int64_t now_ns_{0}, may_publish_ns_{0};
  std::array<std::uint8_t, wire::kMaxFrame> buffer_{};

  threads::Thread thread_;
};

}  // namespace raven2_trainer::robot
