"""The choices on the instructor's page: exercises, hazards, links, curricula and hand devices of the configuration folder."""

import pathlib

import yaml

from . import words

TRAINEE = r"[a-z0-9_-]{1,32}"  # the whole ID
SLOW = 0.05  # [-] motion scale of a simulated surgeon who moves a real robot, as in launch/hardware.launch


def _files(folder):
    for path in sorted(pathlib.Path(folder).glob("*.yaml")):
        try:
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
        except yaml.YAMLError as error:
            raise ValueError(f"{path}: {error}") from None
        if isinstance(content, dict):
            yield path.stem, content


class Library:
    """@param share: the folder with config/, urdf/ and meshes/. @param config: another configuration folder.
    @throw ValueError with the file that is wrong."""

    def __init__(self, share, config=None):
        config = pathlib.Path(config or pathlib.Path(share) / "config")
        try:
            self._read(config)
        except KeyError as error:
            raise ValueError(f"{config}: an exercise, hazard or curriculum lacks {error}") from None

    def _read(self, config):
        exercises = sorted(_files(config / "exercises"), key=lambda item: item[1].get("number", 0))
        self.exercises = [{"name": name, "title": e["title"], "time_limit": e.get("time_limit"), "skills": e.get("skills", []),
                           "drill": e.get("drill", {}).get("scenario"), "clumsy": sorted(e.get("clumsy", {})),
                           "expert": bool(e.get("expert")), "steps": words.steps(e),
                           "tracks": [len(track.get("steps", [])) for track in e.get("tracks", [])]} for name, e in exercises]
        self.hazards = [{"name": name, "title": h["title"], "expected": h.get("expected", ""), "response": h.get("response", ""),
                         "severity": words.severity(h.get("hazard", [])), "number": h.get("number", 0)}
                        for name, h in _files(config / "faults")]
        self.hazards.sort(key=lambda h: (words.SEVERITIES.index(h["severity"]), h["number"] == 0, h["number"], h["name"]))
        self.links = [{"name": "none", "title": "good link"}] + [
            {"name": name, "title": i.get("meaning", name)} for name, i in _files(config / "impairments")]
        self.curricula = [{"name": name, "title": c["title"], "stages": c["stages"]} for name, c in _files(config / "curricula")]
        masters = dict(_files(config / "masters"))
        self._scales = {name: m.get("scale") for name, m in masters.items()}
        self.masters = [{"name": name, "title": m.get("meaning", name)} for name, m in masters.items() if name != "browser"]

    def describe(self):
        """The choices, for the page."""
        return {"exercises": self.exercises, "hazards": self.hazards, "links": self.links, "curricula": self.curricula,
                "masters": self.masters, "clumsy": words.CLUMSY}

    def exercise(self, name):
        return next((e for e in self.exercises if e["name"] == name), None)

    def curriculum(self, name):
        """The first one without a name; None if it is unknown."""
        return next((c for c in self.curricula if name in (None, "", c["name"])), None)

    def scale(self, driver, is_real):
        """Motion scale [-] for console and daemon, which must have the same one. @return None: that of the configuration."""
        if is_real and words.is_demonstration(driver):
            return SLOW
        return self._scales.get(driver.split(":")[-1])

    def names(self, what):
        return [each["name"] for each in getattr(self, what)]
