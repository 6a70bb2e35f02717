// record_eventful DIR SEED: records a session with every kind of input that physics accepts, for scripts/session_sums.

#include <cstdio>
#include <cstdlib>

#include "support/eventful_session.h"
#include "support/made_up_session.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: record_eventful DIR SEED\n");
    return 1;
  }
  testing::InitGoogleTest();
  raven2_trainer::testing::useOde();
  raven2_trainer::lockstep::EventfulSession(argv[1], std::strtoull(argv[2], nullptr, 10)).run();
  return testing::UnitTest::GetInstance()->Failed() ? 1 : 0;
}
