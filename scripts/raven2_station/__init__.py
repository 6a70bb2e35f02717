"""The station: a web server with a page for the instructor and one for the trainee (doc/station.md).

Two processes: the server (aiohttp), which owns the pages and the programs of an attempt, and `ros_side`, its link to ROS, which ends
with the ROS master and is started again with the next one.
"""
