"""crtk_msgs 1.3.0's OperatingState and StringStamped, from their published text: Debian has no such package. Stands in for the
module crtk_msgs.msg where commands of doc/crtk.md are run."""

import genmsg
import genpy.dynamic

TEXTS = {"crtk_msgs/OperatingState": "Header  header\nstring  state\nbool    is_homed\nbool    is_busy\n",
         "crtk_msgs/StringStamped": "std_msgs/Header header\nstring string\n"}


def message_class(name):
    context = genmsg.MsgContext.create_default()
    spec = genmsg.msg_loader.load_msg_from_string(context, TEXTS[name], name)
    genmsg.msg_loader.load_depends(context, spec, {"std_msgs": ["/usr/share/std_msgs/msg"]})
    return genpy.dynamic.generate_dynamic(name, genmsg.gentools.compute_full_text(context, spec))[name]


OperatingState, StringStamped = (message_class(name) for name in TEXTS)
