#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/loop/pedal_beat.h"
#include "raven2_trainer/net/itp_sender.h"
#include "raven2_trainer/net/udp_receiver.h"
#include "raven2_trainer/threads/cyclic_thread.h"

namespace raven2_trainer::daemon {

/** The console's thread: one ITP packet a millisecond out, and pedal packets; forces and pictures in. */
class ConsoleRunner {
 public:
  /** @throw NetworkException, ConfigException (the key). */
  ConsoleRunner(const TrainerConfig& config, std::unique_ptr<console::MotionSource> source);
  /** @param[in] realtime with FIFO priority; not for surgeons that allocate memory while they move (expert, clumsy). */
  void start(bool realtime = true);
  void stop();
  /** Body of the thread, every millisecond. */
  void tick(std::int64_t now_ns) noexcept;

  /** The motion is over; packets with the pedal up go on until stop(). */
  bool finished() const noexcept { return finished_.load(std::memory_order_relaxed); }
  /** Force packets that made sense, and those that did not. */
  LinkCounts forceCounts() const noexcept { return force_counts_.load(); }
  /** The same of pictures. */
  LinkCounts sightCounts() const noexcept { return sight_counts_.load(); }
  bool realtime() const noexcept { return thread_.realtime(); }
  /** Packets go out signed: the daemon has answered. */
  bool signing() const noexcept { return signing_.load(std::memory_order_relaxed); }
  /** Pedals that ITP does not carry were held, but ITP packets are signed or must be: the daemon refuses unsigned pedal
   * packets. */
  bool pedalsRefused() const noexcept { return pedals_refused_.load(std::memory_order_relaxed); }
  std::uint16_t forcePort() const noexcept { return forces_.port(); }
  /** 0: it takes no pictures. */
  std::uint16_t sightPort() const noexcept { return pictures_ ? pictures_->port() : 0; }

 private:
  void send(std::int64_t now_ns) noexcept;
  void receiveForces() noexcept;
  Reject takeForce(const std::uint8_t* bytes, std::size_t size) noexcept;
  void receivePictures() noexcept;

  console::Console console_;
  std::unique_ptr<const wire::ItpKey> key_;
  net::ItpSender to_daemon_;
  loop::PedalBeat pedal_beat_;
  net::UdpReceiver forces_;
  std::optional<net::UdpReceiver> pictures_;
  const std::int64_t ready_timeout_ns_;  ///< 0 never: real hands wait for the robot, however long
  const bool must_sign_;
  std::int64_t started_ns_{0};
  bool ready_{false};
  LinkCounts forces_counted_{}, pictures_counted_{};
  StateCell<LinkCounts> force_counts_, sight_counts_;
  StateCell<LoopTiming> timing_;
  std::atomic<bool> finished_{false}, signing_{false}, pedals_refused_{false};
  threads::CyclicThread thread_;
};

}  // namespace raven2_trainer::daemon
