"""The messages of crtk_msgs 1.3.0 that tests use, from its published text: Debian has no such package. Replaces the
module crtk_msgs.msg where tests run the commands of doc/crtk.md."""

import genmsg
import genmsg.gentools
import genpy.dynamic

TEXTS = {"crtk_msgs/OperatingState": "Header  header\nstring  state\nbool    is_homed\nbool    is_busy\n",
         "crtk_msgs/StringStamped": "std_msgs/Header header\nstring string\n"}


def message_class(name):
    context = genmsg.MsgContext.create_default()
    spec = genmsg.msg_loader.load_msg_from_string(context, TEXTS[name], name)
    genmsg.msg_loader.load_depends(context, spec, {"std_msgs": ["/usr/share/std_msgs/msg"]})
    return genpy.dynamic.generate_dynamic(name, genmsg.gentools.compute_full_text(context, spec))[name]


def service_class(name, request, response):
    """A service's class from both halves of its .srv, as gensrv makes it."""
    context = genmsg.MsgContext.create_default()
    parts = {}
    for part, text in ((f"{name}Request", request), (f"{name}Response", response)):
        spec = genmsg.msg_loader.load_msg_from_string(context, text, part)
        genmsg.msg_loader.load_depends(context, spec, {"geometry_msgs": ["/usr/share/geometry_msgs/msg"],
                                                       "std_msgs": ["/usr/share/std_msgs/msg"]})
        parts[part] = spec
        context.register(part, spec)
    service = genmsg.SrvSpec(*parts.values(), request + "---\n" + response, name, "crtk_msgs")
    asks, answers = (genpy.dynamic.generate_dynamic(part, genmsg.gentools.compute_full_text(context, spec))[part]
                     for part, spec in parts.items())
    return type(name.split("/")[1], (), {"_type": name, "_md5sum": genmsg.compute_md5(context, service),
                                         "_request_class": asks, "_response_class": answers})


OperatingState, StringStamped = (message_class(name) for name in TEXTS)
QueryForwardKinematics = service_class("crtk_msgs/QueryForwardKinematics", "float64[] jp\ngeometry_msgs/Pose cp\n",
                                       "geometry_msgs/Pose cp\nbool result\nstring message\n")
QueryInverseKinematics = service_class("crtk_msgs/QueryInverseKinematics", "geometry_msgs/Pose cp\nfloat64[] jp\n",
                                       "float64[] jp\nbool result\nstring message\n")
