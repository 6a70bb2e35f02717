"""Pictures of the video at what happened, each a link to that moment of it."""

import base64
import concurrent.futures
import os
import subprocess
import urllib.parse

from raven2_report.text import esc

WIDTH = 480  # pixels


def section(facts, page):
    """HTML; `page`: path of the report, from where the video is linked."""
    video = facts.session.file("video.mp4")
    if video is None:
        return ("<p>There is no video of this session yet. The station's button <b>Render the video</b> makes one, or "
                "<code>render_session DIR</code>.</p>")
    moments = facts.moments()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        pictures = list(pool.map(lambda moment: take_frame(video, moment["at_s"]), moments))
    link = urllib.parse.quote(os.path.relpath(video, os.path.dirname(os.path.abspath(page))))
    shown = [f'<figure><a href="{link}#t={moment["at_s"]:.2f}"><img src="data:image/jpeg;base64,{picture}" '
             f'alt="{esc(moment["caption"])}"></a><figcaption><b>{moment["at_s"]:.1f} s</b> {esc(moment["caption"])}'
             '</figcaption></figure>'
             for moment, picture in zip(moments, pictures) if picture]
    if not shown:
        return "<p>The video could not be read.</p>"
    return (f'<div class="frames">{"".join(shown)}</div><p class="sub">A picture opens the video there, as long as '
            'video.mp4 '
            "stays next to this file.</p>")


def take_frame(video, seconds):
    """One frame as base64 JPEG; None if ffmpeg is missing or the video ends before."""
    command = ["ffmpeg", "-nostdin", "-loglevel", "error", "-ss", f"{seconds:.3f}", "-i", os.path.abspath(video),
               "-frames:v",
               "1", "-vf", f"scale={WIDTH}:-2", "-q:v", "4", "-f", "image2pipe", "-c:v", "mjpeg", "pipe:1"]
    try:
        picture = subprocess.run(command, capture_output=True, timeout=20, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return None
    return base64.b64encode(picture).decode() if picture else None
