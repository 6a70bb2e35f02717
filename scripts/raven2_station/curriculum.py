"""How far a trainee is in a curriculum: the rule of score_session (src/training/curriculum.cpp), for the page's next stage."""

import dataclasses


@dataclasses.dataclass
class Stage:
    """One stage of config/curricula, and what a trainee has done of it."""
    exercise: str
    drill: str     # "" for none
    passes: int    # in a row
    extra: int     # passes after those, in any order
    attempts: int = 0
    in_a_row: int = 0
    more: int = 0
    done: bool = False

    @property
    def title(self):
        return self.exercise.replace("_", " ") + (f" with {self.drill.replace('_', ' ')}" if self.drill else "")

    def count(self, passed):
        self.attempts += 1
        if self.in_a_row >= self.passes:
            self.more += passed
        else:
            self.in_a_row = self.in_a_row + 1 if passed else 0
        self.done = self.in_a_row >= self.passes and self.more >= self.extra

    def describe(self):
        return {**dataclasses.asdict(self), "title": self.title}


def stages_of(curriculum):
    """@param curriculum: of Library.curricula, or None."""
    return [Stage(s["exercise"], "" if s.get("drill", "none") == "none" else s["drill"], s.get("passes", 1), s.get("extra", 0))
            for s in (curriculum or {}).get("stages", [])]


def follow(curriculum, attempts):
    """@param attempts: dicts with exercise, drill ("" for none) and passed (None: not judged), in the order in which they were made.
    @return (stages, index of the first that is not done; len(stages) if all are)."""
    stages, current = stages_of(curriculum), 0
    for attempt in attempts:
        if current == len(stages):
            break
        own = stages[current]
        if attempt["passed"] in (True, False) and (attempt["exercise"], attempt["drill"] or "") == (own.exercise, own.drill):
            own.count(attempt["passed"])
            current += own.done
    return stages, current
