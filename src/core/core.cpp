#include <type_traits>

#include "raven2_trainer/core/bytes.h"
#include "raven2_trainer/core/record.h"

// Assumptions of all other modules, checked where they are compiled first.

namespace raven2_trainer {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the wire formats and the log are little-endian copies");
static_assert(sizeof(double) == 8 && sizeof(float) == 4, "IEEE 754 sizes");
static_assert(std::is_trivially_copyable<TickRecord>::value && std::is_trivially_copyable<FaultPlan>::value,
              "cross threads");

}  // namespace raven2_trainer
