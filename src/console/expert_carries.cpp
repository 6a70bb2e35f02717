#include "expert_verbs.h"

namespace raven2_trainer::console {

void Expert::liftOff(Arm arm) {
  then([this, arm]() -> Tick {
    Hold& hold = at(holds_, arm);
    if (hold.lifted || hold.object == kNobody) return 0;
    hold.lifted = true;
    const Pose up = level(lifted(hold.object), headingOf(ring(hold.object)));
    first({travel(
        arm, [this, arm, up] { return up * at(holds_, arm).X_TR.inverse(); }, skill_.slowest)});
    return 0;
  });
}

void Expert::carry(const Verb& verb) {
  if (at(holds_, verb.arm).object != verb.object) return again(regrip(verb));
  liftOff(verb.arm);
  if (verb.via_W) then(carryTo(verb.arm, toEigen(*verb.via_W), speed()));
  const Vector3 to_W = toEigen(verb.to_W);
  if (verb.let_go_at >= 0.0) return letGoOnTheWay(verb, to_W);
  then(carryTo(verb.arm, to_W, speed()));
  then(settleRing(verb.arm, to_W, kLooks));
  then([this, verb]() -> Tick {
    if (!holds(verb.arm)) again(regrip(verb));
    return 0;
  });
}

void Expert::letGoOnTheWay(const Verb& verb, const Vector3& to_W) {
  const double pace = speed();
  then([this, verb, to_W, pace] {
    const Vector3 here = ring(verb.object).p;
    first({carryTo(verb.arm, here + verb.let_go_at * (to_W - here), pace)});
    return Tick{0};
  });
  thenLog("let_go");
  jaws(verb.arm, kOpenJaws);
  then([this, verb]() -> Tick {
    at(holds_, verb.arm) = Hold{};
    return toTicks(0.5);
  });
}

void Expert::takeOver(const Verb& verb) {
  const Arm giver = otherArm(verb.arm);
  grip(verb);
  then([this, verb]() -> Tick {
    if (isClosedOnSomething(verb.arm)) return 0;
    forgetSteps();  // there is nothing between the jaws: once more
    letGo(verb.arm, verb);
    then([this, verb]() -> Tick {
      again({verb});
      return 0;
    });
    return 0;
  });
  letGo(giver, verb);
  then([this, verb]() -> Tick {
    at(holds_, verb.arm).X_TR = ringInTool(verb.arm, verb.object);
    if (!holds(verb.arm)) again(regripAlone(verb));
    return 0;
  });
}

void Expert::putOver(const Verb& verb) {
  if (at(holds_, verb.arm).object != verb.object) return again(regrip(verb));
  liftOff(verb.arm);
  then(carryTo(verb.arm, abovePeg(verb), speed()));
  then(settleRing(verb.arm, abovePeg(verb), kLooks));
  then([this, verb]() -> Tick {
    if (holds(verb.arm)) return 0;
    forgetSteps();
    again(regrip(verb));
    return 0;
  });
  then(carryTo(verb.arm, onPeg(verb), skill_.slowest));
  push(verb);
  letGo(verb.arm, verb);
  rest(0.5);
  then([this, verb]() -> Tick {
    if (pegIn(verb.object) != &roles_.pegs[verb.peg]) again(regrip(verb));
    return 0;
  });
}

void Expert::push(const Verb& verb) {
  if (verb.push_W == Vec3{}) return;
  then([this, verb] {
    log("pushed");
    Pose to = hand(verb.arm).goal();
    to.p += toEigen(verb.push_W);
    return move(verb.arm, to, skill_.slowest);
  });
  rest(0.3);
}

void Expert::letGo(Arm arm, const Verb& verb) {
  thenLog("open");
  jaws(arm, openFor(shape(verb).bar_radius));
  leave(arm);
}

}  // namespace raven2_trainer::console
