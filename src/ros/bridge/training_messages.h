#pragma once

#include <ros/time.h>

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/ExerciseEventStamped.h"
#include "raven2_trainer/ExerciseProgress.h"
#include "raven2_trainer/TrainerMode.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/state.h"

// The mode, the exercise and its events as messages.

namespace raven2_trainer::ros_bridge {

TrainerMode trainerMode(const ModelState& model, const ros::Time& stamp);

/** @param[in] exercise of the session; without tracks: no exercise. */
ExerciseProgress exerciseProgress(const ModelState& model, const Exercise& exercise, const ros::Time& stamp);

/** @param[in] number of the event, from 1 on. @param[in] body_names daemon::Simulator::bodyNames(). */
ExerciseEventStamped exerciseEvent(std::uint64_t number,
                                   const ExerciseRecord& record,
                                   const Exercise& exercise,
                                   const std::vector<std::string>& body_names,
                                   const ros::Time& stamp);

/** Whether the message would differ between two states, apart from fields that change in every tick. */
bool isSameMode(const ModelState& a, const ModelState& b) noexcept;
bool isSameProgress(const ExerciseState& a, const ExerciseState& b) noexcept;

}  // namespace raven2_trainer::ros_bridge
