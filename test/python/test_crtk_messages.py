"""Names, texts and check sums of the CRTK messages that the package writes itself, against genmsg's own computation."""
import pathlib
import re

import genmsg
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADER = (ROOT / "src/ros/crtk/crtk_messages.h").read_text()
# crtk_msgs 1.3.0, msg/*.msg.
TEXTS = {"OperatingState": "Header  header\nstring  state\nbool    is_homed\nbool    is_busy\n",
         "StringStamped": "std_msgs/Header header\nstring string\n"}
STD_MSGS = pathlib.Path("/usr/share/std_msgs/msg")


def md5_of(name, text):
    context = genmsg.MsgContext.create_default()
    spec = genmsg.msg_loader.load_msg_from_string(context, text, name)
    genmsg.msg_loader.load_depends(context, spec, {"std_msgs": [str(STD_MSGS)]})
    return genmsg.gentools.compute_md5(context, spec)


@pytest.mark.parametrize("name", list(TEXTS))
def test_check_sum_and_definition_are_those_of_crtk_msgs(name):
    expected = md5_of(f"crtk_msgs/{name}", TEXTS[name])
    ours = re.search(rf'(?s)struct {name} {{.*?md5\(\) {{ return "(\w+)"; }}.*?withPart<std_msgs::Header>\("(.*?)"\)', HEADER)
    assert ours.group(1) == expected
    definition = ours.group(2).replace("\\n", "\n")
    assert md5_of(f"crtk_msgs/{name}", definition) == expected, "clients read the text that comes with the topic"


def test_another_field_is_another_check_sum():
    assert md5_of("crtk_msgs/OperatingState", TEXTS["OperatingState"].replace("is_busy", "busy")) != md5_of(
        "crtk_msgs/OperatingState", TEXTS["OperatingState"])
